"""Files that are whole or not there: what is left of others, what is left alone, and what cannot be written."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from emovid.atomic_io import (
    clear_leftovers,
    file_digest,
    is_written,
    make_folder,
    replace_if_changed,
    whole_folder,
    writing,
)
from emovid.errors import EmovidError, InputError
from tests.helpers.owners import DEAD, ELSEWHERE, PARENT, former


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_leftovers_of_a_dead_process_with_the_same_number_are_removed(tmp_path) -> None:
    # In a container, a killed command and the next one often have the same number.
    left = tmp_path / f".x.{former()}.part"
    left.mkdir()
    (left / "old").touch()
    with whole_folder(tmp_path / "x") as part:
        (part / "new").touch()
    assert names(tmp_path) == ["x"]
    assert names(tmp_path / "x") == ["new"]


@pytest.mark.parametrize("dead", [DEAD, DEAD.replace("999999999", str(10**30))])
def test_only_leftovers_of_dead_processes_are_removed(tmp_path, dead) -> None:
    (tmp_path / f".x.mp4.{dead}.part").touch()
    (tmp_path / f".frames.{dead}.part").mkdir()
    kept = [f".x.mp4.{PARENT}.part", f".x.{ELSEWHERE}.part", ".hidden.part", "x.part", f".x.mp4.{dead}.txt"]
    for name in kept:
        (tmp_path / name).touch()
    clear_leftovers(tmp_path)
    assert names(tmp_path) == sorted(kept)


@pytest.mark.parametrize("owner", [ELSEWHERE, "a-host-17"])  # the second as 0.1.0 wrote it
def test_file_of_another_machine_counts_as_unfinished_for_a_day(tmp_path, owner) -> None:
    file = tmp_path / f".x.mp4.{owner}.part"
    file.touch()
    assert is_written(file)
    os.utime(file, (time.time() - 90_000,) * 2)
    assert not is_written(file)
    file.unlink()
    assert is_written(file)  # it has just been renamed


def test_file_with_equal_content_is_not_rewritten(tmp_path) -> None:
    file = tmp_path / "x.csv"
    replace_if_changed(file, b"1")
    os.utime(file, (0, 0))
    replace_if_changed(file, b"1")
    assert file.stat().st_mtime == 0
    replace_if_changed(file, b"2")
    assert file.read_bytes() == b"2"


def test_unreadable_and_unwritable_files_give_a_one_line_message(tmp_path) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(EmovidError, match=r"folder: cannot be written: is a directory"):
        replace_if_changed(tmp_path / "folder", b"1")
    no_folder = r"none/x: cannot be written: no such file or directory: is its folder still there\?"
    with pytest.raises(EmovidError, match=no_folder), writing(tmp_path / "none" / "x"):
        pass
    with pytest.raises(EmovidError, match=r"none: cannot be read: no such file or directory"):
        file_digest(tmp_path / "none")
    (tmp_path / "file").touch()
    with pytest.raises(EmovidError, match=r"file: cannot be made: file exists"):
        make_folder(tmp_path / "file")
    assert names(tmp_path) == ["file", "folder"]


def test_an_error_keeps_the_old_folder(tmp_path) -> None:
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "old").touch()
    with pytest.raises(ZeroDivisionError), whole_folder(tmp_path / "x") as part:
        (part / str(1 // 0)).touch()
    assert names(tmp_path) == ["x"]
    assert names(tmp_path / "x") == ["old"]


def test_folder_that_vanishes_during_writing_keeps_the_old_one(tmp_path) -> None:
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "old").touch()
    with pytest.raises(EmovidError, match="x: cannot be written: no such file"), whole_folder(tmp_path / "x") as part:
        part.rmdir()
    assert names(tmp_path) == ["x"]
    assert names(tmp_path / "x") == ["old"]


def test_a_process_of_another_user_is_alive(tmp_path, monkeypatch) -> None:
    def refuse(pid: int, number: int) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "kill", refuse)
    assert is_written(tmp_path / f".x.{PARENT}.part")


def test_a_process_is_found_on_a_system_without_proc(tmp_path, monkeypatch) -> None:
    def missing(path: Path) -> str:
        raise FileNotFoundError

    assert is_written(tmp_path / f".x.{PARENT}.part")
    monkeypatch.setattr(Path, "read_text", missing)
    assert is_written(tmp_path / f".x.{PARENT}.part")


def test_folder_digest_depends_on_names_and_contents(tmp_path) -> None:
    digests = set()
    for name, content in (("a", b"1"), ("b", b"1"), ("a", b"2"), ("a", b"1")):
        folder = tmp_path / f"{len(names(tmp_path))}"
        folder.mkdir()
        (folder / name).write_bytes(content)
        digests.add(file_digest(folder))
    assert len(digests) == 3


# Kills a child at each line of the module in turn, while it replaces a file and a folder, and prints what is left.
KILLED = """
import os, signal, sys
from pathlib import Path
from emovid import atomic_io

if sys.argv[1] == "renames":
    atomic_io._exchange = lambda *_: False

def replace():
    with atomic_io.writing(Path("file")) as file:
        file.write(b"new")
    with atomic_io.whole_folder(Path("folder")) as part:
        for name in ("a", "b"):
            (part / name).write_text("new")

def state():
    return [Path("file").read_text(), *(Path("folder", name).read_text() for name in ("a", "b"))]

def child(last):
    lines = 0
    def trace(frame, event, _):
        nonlocal lines
        if frame.f_code.co_filename != atomic_io.__file__:
            return None
        lines += event == "line"
        if lines == last:
            os.kill(os.getpid(), signal.SIGKILL)
        return trace
    sys.settrace(trace)
    replace()
    os._exit(0)

ended = None
last = 0
while ended != 0:
    last += 1
    Path("file").write_text("old")
    Path("folder").mkdir(exist_ok=True)
    for name in ("a", "b"):
        Path("folder", name).write_text("old")
    pid = os.fork() or child(last)
    ended = os.waitpid(pid, 0)[1]
    if sys.argv[1] == "renames":
        atomic_io.clear_leftovers(Path())
    print(*state())
    atomic_io.clear_leftovers(Path())
    assert sorted(os.listdir()) == ["file", "folder"], os.listdir()
"""


@pytest.mark.parametrize("how", ["exchange", "renames"])
def test_kill_at_any_line_leaves_a_complete_old_or_new_file(how, tmp_path) -> None:
    done = subprocess.run([sys.executable, "-c", KILLED, how], cwd=tmp_path, capture_output=True, text=True, check=True)
    states = done.stdout.splitlines()
    assert len(states) > 50
    assert set(states) == {"old old old", "new old old", "new new new"}
    assert states == sorted(states, key=["old old old", "new old old", "new new new"].index)


def test_symbolic_link_is_kept_and_its_target_replaced(tmp_path) -> None:
    (tmp_path / "disk" / "pictures").mkdir(parents=True)
    (tmp_path / "disk" / "pictures" / "old").touch()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "pictures").symlink_to("../disk/pictures")
    (tmp_path / "out" / "text").symlink_to("../disk/text")
    with whole_folder(tmp_path / "out" / "pictures") as part:
        (part / "new").touch()
    with writing(tmp_path / "out" / "text") as file:
        file.write(b"text")
    assert names(tmp_path / "out") == ["pictures", "text"]
    assert (tmp_path / "out" / "pictures").is_symlink()
    assert names(tmp_path / "disk") == ["pictures", "text"]
    assert names(tmp_path / "disk" / "pictures") == ["new"]


def test_symbolic_link_leftover_is_removed_and_its_target_kept(tmp_path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "text").touch()
    (tmp_path / f".x.{DEAD}.part").symlink_to("mine")
    clear_leftovers(tmp_path)
    assert names(tmp_path) == ["mine"]
    assert names(tmp_path / "mine") == ["text"]


def test_links_to_each_other_give_a_one_line_message(tmp_path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(EmovidError, match=r"a: cannot be written: too many levels of symbolic links"):
        replace_if_changed(tmp_path / "a", b"1")
    assert names(tmp_path) == ["a", "b"]


def test_name_that_is_too_long_is_invalid_input(tmp_path) -> None:
    long = "x" * 250  # valid by itself, but too long for the temporary name
    with pytest.raises(InputError, match=r"x: cannot be written: file name too long: choose a shorter name"):
        replace_if_changed(tmp_path / long, b"1")
    assert names(tmp_path) == []


def test_a_private_file_stays_private(tmp_path) -> None:
    file = tmp_path / "answers.csv"
    file.write_text("1")
    file.chmod(0o600)
    replace_if_changed(file, b"2")
    assert file.read_bytes() == b"2"
    assert file.stat().st_mode & 0o777 == 0o600


def test_data_are_synced_before_the_rename(tmp_path, monkeypatch) -> None:
    done: list[str] = []
    sync, replace = os.fsync, Path.replace

    def fsync(descriptor: int) -> None:
        done.append(Path(f"/proc/self/fd/{descriptor}").readlink().name.partition(".part")[0].lstrip(".").split(".")[0])
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", lambda part, target: done.append("rename") or replace(part, target))
    monkeypatch.setattr("emovid.atomic_io._replace_folder", lambda target, part: done.append("rename"))
    with writing(tmp_path / "x") as file:
        file.write(b"1")
    assert done == ["x", "rename", tmp_path.name]
    done.clear()
    with whole_folder(tmp_path / "pictures") as part:
        (part / "a").touch()
    assert done == ["a", "pictures", "rename", tmp_path.name]
