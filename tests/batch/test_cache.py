"""Results of jobs: checked before use, made by matching versions, shared between parallel runs."""

import json
import os
import time
from dataclasses import replace
from pathlib import Path

import pytest

from emovid.atomic_io import file_digest, owner
from emovid.batch import manifest
from emovid.batch.cache import find_current, is_current, make_missing
from emovid.batch.job import Delivery, Job, Order, fulfill, make
from emovid.batch.manifest import Journal, read_manifest
from emovid.batch.workers import InProcess
from emovid.errors import EmovidError
from emovid.scene.model import Scene
from tests.helpers.batches import Silent
from tests.helpers.owners import ELSEWHERE, PARENT


class Worker(InProcess):
    """A worker whose results are changed in transfer."""

    def __init__(self, change=lambda delivery: delivery, *, is_remote: bool = False) -> None:
        super().__init__(lambda *_: None)
        self.change, self.is_remote = change, is_remote
        self.orders: list[Order] = []

    def submit(self, work, item):
        self.orders.append(item)
        return super().submit(lambda order, on_step: self.change(work(order, on_step)), item)


def changed(**facts):
    return lambda delivery: replace(delivery, record=replace(delivery.record, **facts))


@pytest.fixture
def job(make_scene, tmp_path) -> Job:
    scene: Scene = make_scene("fear", {"duration": 0.5, "robots": 3})
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "fear.npz").write_bytes(b"the old one")
    return Job(scene, tmp_path / "out" / "fear.npz", only="trajectory")


def failure(job: Job, pool: InProcess) -> str:
    """Return the error of a job, and check that its old file stays."""
    made = make_missing([job], Silent(), pool)
    assert made.records == {}
    assert [path.name for path in job.target.parent.iterdir()] == ["fear.npz"]
    assert job.target.read_bytes() == b"the old one"
    return str(made.failures[job.target])


def test_a_worker_refuses_to_start_with_other_versions(job) -> None:
    expected = {"numpy": "1.0", "code": "abc"}
    here = job.recipe.versions
    with pytest.raises(
        Exception, match=rf"other versions: numpy {here['numpy']}, here 1\.0; code {here['code']}, here"
    ):
        fulfill(Order(job, expected, job.target.parent / "nowhere"))
    assert job.target.read_bytes() == b"the old one"


def test_result_from_other_versions_is_refused(job) -> None:
    here = job.recipe.versions
    said = failure(job, Worker(changed(versions={**here, "numpy": "1.0", "scipy": "1.1"})))
    expected = f"numpy 1.0, here {here['numpy']}; scipy 1.1, here {here['scipy']}"
    assert said == f"{job.target}: its worker has other versions: {expected}"
    said = failure(job, Worker(changed(versions={name: of for name, of in here.items() if name != "code"})))
    assert said == f"{job.target}: its worker has other versions: code None, here {here['code']}"


def test_result_damaged_in_transfer_is_refused(job) -> None:
    damaged = f"{job.target}: not what its worker recorded: it was damaged on its way"
    assert failure(job, Worker(changed(sha256="0" * 64))) == damaged
    cut = Worker(lambda delivery: replace(delivery, content={"": delivery.content[""][:-1]}), is_remote=True)
    assert failure(job, cut) == damaged


def test_result_of_a_remote_worker_is_transferred(job, make_scene) -> None:
    pool = Worker(is_remote=True)
    assert make_missing([job], Silent(), pool).failures == {}
    assert pool.orders[0].folder is None
    assert file_digest(job.target) == read_manifest(job.target.parent)["fear.npz"].sha256
    pictures = make_scene(
        "fear", {"duration": 0.2, "video.fps": 10, "video.size": "96x64", "video.format": "png-sequence"}
    )
    sequence = Job(pictures, job.target.with_name("pictures"))
    assert make_missing([sequence], Silent(), pool).failures == {}
    assert sorted(path.name for path in sequence.target.iterdir()) == ["00000.png", "00001.png"]


def test_worker_error_names_the_final_file(job) -> None:
    job.target.parent.chmod(0o755)
    order = Order(job, job.recipe.versions, job.target.parent / "missing")
    with pytest.raises(EmovidError, match="cannot be written: no such file or directory") as error:
        fulfill(order)
    assert str(error.value).startswith(f"{job.target}: ")


def test_no_folder_is_made_without_jobs(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = make_missing([], Silent(), InProcess(lambda *_: None))
    assert (made.records, made.failures) == ({}, {})
    assert list(Path().iterdir()) == []


def test_modification_time_of_current_files_is_updated(job) -> None:
    make_missing([job], Silent(), InProcess(lambda *_: None))
    os.utime(job.target, (0, 0))
    assert list(find_current([job], Silent())) == [job.target]
    assert job.target.stat().st_mtime > 0


def test_measurements_that_were_changed_are_not_current(make_scene, tmp_path) -> None:
    job = Job(make_scene("fear", {"duration": 0.5, "robots": 3}), tmp_path / "m", only="measure")
    record = make(job)
    assert is_current(record, job)
    assert not is_current(replace(record, descriptors={**record.descriptors, "speed_mean": 99.0}), job)


# --- parallel runs ----------------------------------------------------------------------------------------------------


class OtherRun:
    """The journal of another live run, read by this process."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / f".manifest.json.{PARENT}.journal"

    def write(self, *entry: object) -> None:
        with self.path.open("a") as file:
            file.write(json.dumps(list(entry)) + "\n")


def test_parallel_runs_share_their_jobs(make_scene, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(manifest, "_PACE", 0)
    scenes = [make_scene("fear", {"duration": 0.5, "robots": 3, "seed": seed}) for seed in (1, 2, 3)]
    work = [Job(scene, tmp_path / str(scene.seed), only="measure") for scene in scenes]
    other, report = OtherRun(tmp_path), Silent()
    other.write("1")
    other.write("2")

    def finish_one(delivery: Delivery) -> Delivery:
        other.write("1", make(work[0]).to_json())
        other.path.rename(tmp_path / ".manifest.json.0123456789ab-2-2.journal")  # this run ends, another one continues
        os.utime(tmp_path / ".manifest.json.0123456789ab-2-2.journal", (0, 0))
        return delivery

    made = make_missing(work, report, Worker(finish_one))
    assert report.made[0] == "3"
    assert "1" in report.kept
    assert set(made.elsewhere) | set(made.records) == {job.target for job in work}
    assert sorted(read_manifest(tmp_path)) == ["1", "2", "3"]


def test_claim_of_another_container_holds_while_its_journal_is_updated(tmp_path) -> None:
    path = tmp_path / f".manifest.json.{ELSEWHERE}.journal"
    path.write_text('["a"]\n')
    with Journal(tmp_path) as journal:
        assert journal.claimed_elsewhere() == {"a"}
    os.utime(path, (time.time() - 90,) * 2)  # it was killed
    with Journal(tmp_path) as journal:
        assert journal.claimed_elsewhere() == set()


def test_run_updates_the_time_of_its_journal(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(manifest, "_HEARTBEAT", 0.01)
    with Journal(tmp_path) as journal:
        journal.claim("a")
        (path,) = tmp_path.glob(".manifest.json.*.journal")
        os.utime(path, (0, 0))
        deadline = time.monotonic() + 30
        while path.stat().st_mtime == 0:
            assert time.monotonic() < deadline
            time.sleep(0.01)


def test_claim_of_a_dead_run_is_ignored(tmp_path) -> None:
    (tmp_path / ".manifest.json.0123456789ab-2-2.journal").write_text('["a"]\n')
    os.utime(tmp_path / ".manifest.json.0123456789ab-2-2.journal", (0, 0))
    with Journal(tmp_path) as journal:
        assert journal.claimed_elsewhere() == set()
    assert owner() not in str(list(tmp_path.iterdir()))
