"""A result from another machine counts only if the same versions made it and its file is here."""

from dataclasses import replace
from pathlib import Path

import pytest

from emovid.batch.cache import make_missing
from emovid.batch.job import Job
from emovid.batch.workers import InProcess
from emovid.scene.model import Scene


class Silent:
    def advanced(self, job, done, total) -> None: ...
    def finished(self, job, record, *, made) -> None: ...
    def failed(self, job) -> None: ...
    def died(self, job, attempt) -> None: ...


class Elsewhere(InProcess):
    """A worker on another machine: its files stay there, or it has other versions."""

    def __init__(self, *, shares: bool = True, without: str = "", **versions: str) -> None:
        super().__init__(lambda *_: None)
        self.shares, self.without, self.versions = shares, without, versions

    def submit(self, work, item):
        return super().submit(lambda job, on_step: self._spoilt(work(job, on_step), job), item)

    def _spoilt(self, record, job):
        if not self.shares:
            job.target.unlink()
        versions = record.versions | self.versions
        return replace(record, versions={name: of for name, of in versions.items() if name != self.without})


@pytest.fixture
def job(make_scene, tmp_path) -> Job:
    scene: Scene = make_scene("fear", {"duration": 0.5, "robots": 3})
    return Job(scene, tmp_path / "out" / "fear.npz", only="trajectory")


def failure(job: Job, pool: InProcess) -> str:
    made = make_missing([job], Silent(), pool)
    assert made.records == {}
    assert not (job.target.parent / "manifest.json").exists()
    return str(made.failures[job.target])


def test_a_worker_of_other_versions_is_named_with_them(job) -> None:
    here = job.recipe.versions
    said = failure(job, Elsewhere(numpy="1.0", scipy="1.1"))
    expected = f"numpy 1.0, here {here['numpy']}; scipy 1.1, here {here['scipy']}"
    assert said == f"{job.target}: its worker has other versions: {expected}"
    said = failure(job, Elsewhere(without="code"))
    assert said == f"{job.target}: its worker has other versions: code None, here {here['code']}"


def test_a_worker_that_does_not_share_the_folder_is_said(job) -> None:
    said = failure(job, Elsewhere(shares=False))
    assert said == f"{job.target}: made, but not here: workers must share the output folder"


def test_no_jobs_make_no_folder(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert make_missing([], Silent(), InProcess(lambda *_: None)) == ({}, {})
    assert list(Path().iterdir()) == []
