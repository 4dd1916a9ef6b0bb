"""Records of finished jobs: kept by whoever made them, merged by whoever comes, lost by nobody."""

import io
import json
import multiprocessing
import os
import socket
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.batch.ledger import Ledger, merge, read_ledger
from emovid.errors import EmovidError

HOST = socket.gethostname()
MEASURED = {"only": "measure", "descriptors": {"speed_mean": 0.1, "cost": None}}


def hidden(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


def leave_journal(folder: Path, text: str, owner: str = f"{HOST}-999999999") -> Path:
    path = folder / f".manifest.json.{owner}.journal"
    path.write_text(text)
    return path


def test_records_are_known_at_once_and_merged_at_the_end(tmp_path) -> None:
    with Ledger(tmp_path) as ledger:
        ledger.add("a", MEASURED)
        assert read_ledger(tmp_path) == {"a": MEASURED}
        assert not (tmp_path / "manifest.json").exists()
    assert hidden(tmp_path) == []
    assert json.loads((tmp_path / "manifest.json").read_text()) == {
        "measurements": {"a": {"descriptors": MEASURED["descriptors"]}}
    }
    assert read_ledger(tmp_path) == {"a": MEASURED}


def test_nothing_new_leaves_the_manifest_as_it_is(tmp_path) -> None:
    (tmp_path / "manifest.json").write_text('{"videos":   {}}')
    with Ledger(tmp_path):
        pass
    assert (tmp_path / "manifest.json").read_text() == '{"videos":   {}}'


@given(st.integers(0, 200))
def test_a_killed_run_loses_at_most_the_line_it_was_writing(tmp_path_factory, kept) -> None:
    folder = tmp_path_factory.mktemp("ledger")
    lines = "".join(json.dumps([f"item{i}", MEASURED]) + "\n" for i in range(4))
    leave_journal(folder, lines[:kept])
    whole = lines[:kept].count("\n") + (kept % (len(lines) // 4) == len(lines) // 4 - 1)
    assert len(read_ledger(folder)) == whole
    merge(folder)
    assert hidden(folder) == []
    assert len(read_ledger(folder)) == whole


def test_a_killed_run_that_had_our_number_costs_only_what_it_was_writing(tmp_path) -> None:
    # In a container, the number of a killed command and that of the next one are often the same.
    first = json.dumps(["a", MEASURED]) + "\n"
    leave_journal(tmp_path, first + first[:9], f"{HOST}-{os.getpid()}")
    with Ledger(tmp_path) as ledger:
        ledger.add("b", MEASURED)
        ledger.add("c", MEASURED)
    assert sorted(read_ledger(tmp_path)) == ["a", "b", "c"]


def test_records_of_no_known_kind_are_none(tmp_path) -> None:
    records = [["a", {}], ["b", {"only": "sound"}], ["c", {"only": ["video"]}], ["d", 4], ["e", MEASURED]]
    leave_journal(tmp_path, "".join(json.dumps(record) + "\n" for record in records))
    for name in "abcd":
        (tmp_path / name).touch()
    assert sorted(read_ledger(tmp_path)) == ["e"]
    merge(tmp_path)
    assert sorted(read_ledger(tmp_path)) == ["e"]


def test_the_section_of_a_record_says_its_kind(tmp_path) -> None:
    (tmp_path / "manifest.json").write_text('{"measurements": {"a": {"only": "sound"}}}')
    assert read_ledger(tmp_path) == {"a": {"only": "measure"}}


def test_a_running_run_s_journal_is_read_and_left(tmp_path) -> None:
    own = leave_journal(tmp_path, json.dumps(["a", MEASURED]) + "\n", f"{HOST}-{os.getppid()}")
    far = leave_journal(tmp_path, json.dumps(["b", MEASURED]) + "\n", "elsewhere-1")
    merge(tmp_path)
    assert own.exists()
    assert far.exists()
    assert sorted(read_ledger(tmp_path)) == ["a", "b"]


def test_another_machine_s_journal_of_yesterday_is_merged_and_removed(tmp_path) -> None:
    far = leave_journal(tmp_path, json.dumps(["b", MEASURED]) + "\n", "elsewhere-1")
    os.utime(far, (0, 0))
    merge(tmp_path)
    assert hidden(tmp_path) == []
    assert sorted(read_ledger(tmp_path)) == ["b"]


def test_records_of_files_that_are_gone_go(tmp_path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"")
    with Ledger(tmp_path) as ledger:
        ledger.add("a.mp4", {"only": "video"})
        ledger.add("b.mp4", {"only": "video"})
    assert sorted(read_ledger(tmp_path)) == ["a.mp4"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"videos": [1]}', '{"videos": {"a": 1}}', "\xff", '{"videos": null}'])
def test_a_manifest_that_is_none_holds_nothing(tmp_path, text) -> None:
    (tmp_path / "manifest.json").write_text(text, encoding="latin1")
    assert read_ledger(tmp_path) == {}
    with Ledger(tmp_path) as ledger:
        ledger.add("a", MEASURED)
    assert sorted(read_ledger(tmp_path)) == ["a"]


def test_a_lock_that_a_killed_run_left_stops_nobody(tmp_path) -> None:
    (tmp_path / ".manifest.json.lock").write_bytes(b"")
    merge(tmp_path)
    assert hidden(tmp_path) == []


def test_a_journal_that_cannot_be_written_is_said(tmp_path) -> None:
    path = tmp_path / f".manifest.json.{HOST}-{os.getpid()}.journal"
    with Ledger(tmp_path) as ledger:
        path.symlink_to("/dev/full")
        with pytest.raises(EmovidError, match=r"manifest\.json: cannot be written: no space left on device"):
            ledger.add("a", MEASURED)
        path.unlink()


def test_a_journal_that_is_written_in_part_is_said(tmp_path) -> None:
    class Full(io.RawIOBase):
        def write(self, line: bytes) -> int:
            return len(line) - 1

    with Ledger(tmp_path) as ledger:
        ledger._journal = Full()
        with pytest.raises(EmovidError, match="cannot be written: no space left on device: free some space"):
            ledger.add("a", MEASURED)
    assert ledger.records == {}


def test_a_manifest_that_cannot_be_written_leaves_the_journal_to_the_next_run(tmp_path) -> None:
    (tmp_path / "manifest.json").mkdir()
    with pytest.raises(EmovidError, match="is a directory"), Ledger(tmp_path) as ledger:
        ledger.add("a", MEASURED)
    with pytest.raises(ZeroDivisionError), Ledger(tmp_path) as ledger:  # an error that came first says more
        ledger.add("b", {"only": "measure", "inverse": 1 / 0})
    (tmp_path / "manifest.json").rmdir()
    merge(tmp_path, tmp_path / f".manifest.json.{HOST}-{os.getpid()}.journal")
    assert sorted(read_ledger(tmp_path)) == ["a"]
    assert hidden(tmp_path) == []


def test_a_lock_that_cannot_be_taken_is_said(tmp_path) -> None:
    leave_journal(tmp_path, json.dumps(["a", MEASURED]) + "\n")
    (tmp_path / ".manifest.json.lock").mkdir()
    with pytest.raises(EmovidError, match=r"manifest\.json: cannot be written: is a directory"):
        merge(tmp_path)


def _add(folder: Path, worker: int) -> None:
    for run in range(5):
        with Ledger(folder) as ledger:
            for i in range(4):
                ledger.add(f"{worker}-{run}-{i}", MEASURED)


def test_runs_side_by_side_lose_nothing(tmp_path) -> None:
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=_add, args=(tmp_path, worker)) for worker in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
        assert worker.exitcode == 0
    merge(tmp_path)
    assert len(read_ledger(tmp_path)) == 4 * 5 * 4
    assert len(json.loads((tmp_path / "manifest.json").read_text())["measurements"]) == 4 * 5 * 4
    assert hidden(tmp_path) == []
