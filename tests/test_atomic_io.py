"""Files that are whole or not there: what is left of others, what is left alone, and what cannot be written."""

import os
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
from emovid.errors import EmovidError
from tests.helpers.owners import DEAD, ELSEWHERE, PARENT, former


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_leftovers_of_a_dead_process_with_our_number_are_removed(tmp_path) -> None:
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
def test_a_file_of_another_machine_counts_as_unfinished_for_a_day(tmp_path, owner) -> None:
    file = tmp_path / f".x.mp4.{owner}.part"
    file.touch()
    assert is_written(file)
    os.utime(file, (time.time() - 90_000,) * 2)
    assert not is_written(file)
    file.unlink()
    assert is_written(file)  # it has just been renamed


def test_a_file_is_left_as_it_is_if_it_says_this_already(tmp_path) -> None:
    file = tmp_path / "x.csv"
    replace_if_changed(file, b"1")
    os.utime(file, (0, 0))
    replace_if_changed(file, b"1")
    assert file.stat().st_mtime == 0
    replace_if_changed(file, b"2")
    assert file.read_bytes() == b"2"


def test_what_cannot_be_written_read_or_made_is_one_line(tmp_path) -> None:
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


def test_a_folder_that_vanishes_before_it_is_whole_leaves_the_old_one(tmp_path) -> None:
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


def test_the_digest_of_a_folder_is_of_names_and_contents(tmp_path) -> None:
    digests = set()
    for name, content in (("a", b"1"), ("b", b"1"), ("a", b"2"), ("a", b"1")):
        folder = tmp_path / f"{len(names(tmp_path))}"
        folder.mkdir()
        (folder / name).write_bytes(content)
        digests.add(file_digest(folder))
    assert len(digests) == 3
