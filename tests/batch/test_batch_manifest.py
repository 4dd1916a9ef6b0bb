"""Records of finished jobs: journals keep them, later runs merge them, and none is lost."""

import io
import json
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.atomic_io import owner
from emovid.batch.job import Record
from emovid.batch.manifest import Journal, merge_journals, read_manifest
from emovid.errors import EmovidError
from tests.helpers.containers import UNSHARE, unshare_works
from tests.helpers.owners import DEAD, ELSEWHERE, PARENT, former

MEASURED = Record("measure", descriptors={"speed_mean": 0.1, "cost": None})


def line(name: str) -> str:
    return json.dumps([name, MEASURED.to_json()]) + "\n"


def hidden(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


def leave_journal(folder: Path, text: str, owner: str = DEAD) -> Path:
    path = folder / f".manifest.json.{owner}.journal"
    path.write_text(text)
    return path


def test_records_are_readable_at_once_and_merged_at_the_end(tmp_path) -> None:
    with Journal(tmp_path) as journal:
        journal.add("a", MEASURED)
        assert read_manifest(tmp_path) == {"a": MEASURED}
        assert not (tmp_path / "manifest.json").exists()
    assert hidden(tmp_path) == []
    assert json.loads((tmp_path / "manifest.json").read_text()) == {
        "measurements": {"a": {"descriptors": MEASURED.descriptors}}
    }
    assert read_manifest(tmp_path) == {"a": MEASURED}


def test_manifest_is_unchanged_without_new_records(tmp_path) -> None:
    (tmp_path / "manifest.json").write_text('{"videos":   {}}')
    with Journal(tmp_path):
        pass
    assert (tmp_path / "manifest.json").read_text() == '{"videos":   {}}'


@given(st.integers(0, 200))
def test_a_killed_run_loses_at_most_the_line_it_was_writing(tmp_path_factory, kept) -> None:
    folder = tmp_path_factory.mktemp("ledger")
    lines = "".join(line(f"item{i}") for i in range(4))
    leave_journal(folder, lines[:kept])
    whole = lines[:kept].count("\n") + (kept % (len(lines) // 4) == len(lines) // 4 - 1)
    assert len(read_manifest(folder)) == whole
    merge_journals(folder)
    assert hidden(folder) == []
    assert len(read_manifest(folder)) == whole


def test_dead_run_with_a_reused_process_number_loses_only_its_unfinished_line(tmp_path) -> None:
    # In a container, a killed command and the next one often have the same process number.
    first = line("a")
    leave_journal(tmp_path, first + first[:9], former())
    with Journal(tmp_path) as journal:
        journal.add("b", MEASURED)
        journal.add("c", MEASURED)
    assert sorted(read_manifest(tmp_path)) == ["a", "b", "c"]


def test_records_of_unknown_kinds_are_ignored(tmp_path) -> None:
    records = [["a", {}], ["b", {"only": "sound"}], ["c", {"only": ["video"]}], ["d", 4], ["e", MEASURED.to_json()]]
    leave_journal(tmp_path, "".join(json.dumps(record) + "\n" for record in records))
    for name in "abcd":
        (tmp_path / name).touch()
    assert sorted(read_manifest(tmp_path)) == ["e"]
    merge_journals(tmp_path)
    assert sorted(read_manifest(tmp_path)) == ["e"]


def test_records_are_stored_by_kind(tmp_path) -> None:
    (tmp_path / "manifest.json").write_text('{"measurements": {"a": {"only": "sound"}}}')
    assert read_manifest(tmp_path) == {"a": Record("measure")}


def test_the_journal_of_a_live_run_is_read_and_kept(tmp_path) -> None:
    own = leave_journal(tmp_path, line("a"), PARENT)
    far = leave_journal(tmp_path, line("b"), ELSEWHERE)
    merge_journals(tmp_path)
    assert own.exists()
    assert far.exists()
    assert sorted(read_manifest(tmp_path)) == ["a", "b"]


def test_stale_journal_of_another_machine_is_removed_after_a_day(tmp_path) -> None:
    far = leave_journal(tmp_path, line("b"), ELSEWHERE)
    os.utime(far, (0, 0))
    merge_journals(tmp_path)
    assert hidden(tmp_path) == []
    assert sorted(read_manifest(tmp_path)) == ["b"]


def test_records_of_missing_files_are_dropped(tmp_path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"")
    with Journal(tmp_path) as journal:
        journal.add("a.mp4", Record("video"))
        journal.add("b.mp4", Record("video"))
    assert sorted(read_manifest(tmp_path)) == ["a.mp4"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"videos": [1]}', '{"videos": {"a": 1}}', "\xff", '{"videos": null}'])
def test_file_that_is_not_a_manifest_has_no_records(tmp_path, text) -> None:
    (tmp_path / "manifest.json").write_text(text, encoding="latin1")
    assert read_manifest(tmp_path) == {}
    with Journal(tmp_path) as journal:
        journal.add("a", MEASURED)
    assert sorted(read_manifest(tmp_path)) == ["a"]


def test_lock_of_a_killed_run_does_not_block_others(tmp_path) -> None:
    (tmp_path / ".manifest.json.lock").write_bytes(b"")
    merge_journals(tmp_path)
    assert hidden(tmp_path) == []


def test_a_journal_that_cannot_be_written_is_an_error(tmp_path) -> None:
    path = tmp_path / f".manifest.json.{owner()}.journal"
    with Journal(tmp_path) as journal:
        path.symlink_to("/dev/full")
        with pytest.raises(EmovidError, match=r"manifest\.json: cannot be written: no space left on device"):
            journal.add("a", MEASURED)
        path.unlink()


def test_partially_written_journal_is_an_error(tmp_path) -> None:
    class Full(io.RawIOBase):
        def write(self, line: bytes) -> int:
            return len(line) - 1

    with Journal(tmp_path) as journal:
        journal._file = Full()
        with pytest.raises(EmovidError, match="cannot be written: no space left on device: free some space"):
            journal.add("a", MEASURED)
    assert journal.records == {}


def test_the_next_run_merges_the_journal_if_the_manifest_cannot_be_written(tmp_path) -> None:
    (tmp_path / "manifest.json").mkdir()
    with pytest.raises(EmovidError, match="is a directory"), Journal(tmp_path) as journal:
        journal.add("a", MEASURED)
    with pytest.raises(ZeroDivisionError), Journal(tmp_path) as journal:  # the first error is more informative
        journal.add("b", Record("measure", samples=1 // 0))
    (tmp_path / "manifest.json").rmdir()
    merge_journals(tmp_path, tmp_path / f".manifest.json.{owner()}.journal")
    assert sorted(read_manifest(tmp_path)) == ["a"]
    assert hidden(tmp_path) == []


def test_a_lock_that_cannot_be_taken_is_an_error(tmp_path) -> None:
    leave_journal(tmp_path, line("a"))
    (tmp_path / ".manifest.json.lock").mkdir()
    with pytest.raises(EmovidError, match=r"manifest\.json: cannot be written: is a directory"):
        merge_journals(tmp_path)


def _add(folder: Path, worker: int) -> None:
    for run in range(5):
        with Journal(folder) as journal:
            for i in range(4):
                journal.add(f"{worker}-{run}-{i}", MEASURED)


def test_parallel_runs_lose_no_records(tmp_path) -> None:
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=_add, args=(tmp_path, worker)) for worker in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
        assert worker.exitcode == 0
    merge_journals(tmp_path)
    assert len(read_manifest(tmp_path)) == 4 * 5 * 4
    assert len(json.loads((tmp_path / "manifest.json").read_text())["measurements"]) == 4 * 5 * 4
    assert hidden(tmp_path) == []


@pytest.mark.skipif(not unshare_works(), reason="this machine allows no PID namespaces")
def test_runs_in_containers_with_equal_process_numbers_lose_no_records(tmp_path) -> None:
    script = (
        "import sys; from pathlib import Path; from emovid.batch.job import Record;"
        "from emovid.batch.manifest import Journal; folder, name = Path(sys.argv[1]), sys.argv[2]\n"
        "with Journal(folder) as journal:\n"
        "    for i in range(20): journal.add(f'{name}-{i}', Record('measure'))\n"
        "    (folder / f'{name}.ready').touch()\n"
        "    while len(list(folder.glob('*.ready'))) < 3: time.sleep(0.01)\n"
    )
    command = [*UNSHARE, sys.executable, "-c", f"import time; {script}", str(tmp_path)]
    runs = [subprocess.Popen([*command, name]) for name in "abc"]
    assert [run.wait(60) for run in runs] == [0, 0, 0]
    merge_journals(tmp_path)
    assert len(read_manifest(tmp_path)) == 60
