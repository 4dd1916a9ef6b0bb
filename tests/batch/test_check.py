"""Status and verification: every way in which a folder can be wrong is told apart, down to the stage."""

import json
import tempfile
from pathlib import Path

import pytest

from emovid.atomic_io import file_digest
from emovid.batch.check import Found, rebuild, rebuildable, status, verify
from emovid.batch.job import Job
from emovid.batch.ledger import Ledger
from emovid.batch.local import InProcess
from emovid.batch.make import make_missing
from emovid.batch.results import write_plan
from emovid.batch.sweep import items
from emovid.batch.sweep_file import read_sweep_file
from emovid.errors import InputError

SMALL = {"video.size": "96x64", "video.fps": 5, "duration": 0.4}


class Nobody:
    def advanced(self, job, done, total) -> None: ...
    def finished(self, job, record, *, made) -> None: ...
    def died(self, job, attempt) -> None: ...


@pytest.fixture
def folder(make_scene, tmp_path) -> Path:
    jobs = [
        Job(make_scene("anger", SMALL), tmp_path / "v.mp4"),
        Job(make_scene("anger", SMALL), tmp_path / "t.npz", only="trajectory"),
        Job(make_scene("anger", SMALL), tmp_path / "m", only="measure"),
    ]
    assert not make_missing(jobs, Nobody(), InProcess(Nobody().advanced)).failures
    return tmp_path


def states(found: list[Found]) -> dict[str, str]:
    return {result.name: result.state for result in found}


def record(folder: Path, section: str, name: str, **changes: object) -> None:
    """Change what the manifest records."""
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest[section][name] |= changes
    (folder / "manifest.json").write_text(json.dumps(manifest))


def test_what_is_whole_is_current(folder) -> None:
    assert states(status(folder)) == {"v.mp4": "current", "t.npz": "current", "m": "current"}
    assert states(verify(folder)) == {"v.mp4": "current", "t.npz": "current"}
    assert states(map(rebuild, rebuildable(folder))) == {"v.mp4": "current", "t.npz": "current", "m": "current"}


def test_missing_stale_and_corrupt_are_told_apart(folder) -> None:
    (folder / "v.mp4").unlink()
    (folder / "t.npz").write_bytes(b"spoilt")
    versions = json.loads((folder / "manifest.json").read_text())["measurements"]["m"]["versions"]
    record(folder, "measurements", "m", versions=versions | {"numpy": "1.0"})
    found = {result.name: result for result in status(folder)}
    assert states(found.values()) == {"v.mp4": "missing", "t.npz": "corrupt", "m": "stale"}
    assert found["m"].reason == f"made with numpy 1.0, now {versions['numpy']}"
    assert states(verify(folder)) == {"v.mp4": "missing", "t.npz": "corrupt"}


@pytest.mark.parametrize(
    ("section", "name", "key", "stage"),
    [
        ("videos", "v.mp4", "trajectory_sha256", "from the trajectory on"),
        ("videos", "v.mp4", "frames_crc32", "from the frames on"),
        ("videos", "v.mp4", "sha256", "in the encoding"),
        ("trajectories", "t.npz", "trajectory_sha256", "from the trajectory on"),
        ("trajectories", "t.npz", "sha256", "in the file"),
        ("measurements", "m", "trajectory_sha256", "from the trajectory on"),
        ("measurements", "m", "descriptors", "in the descriptors"),
    ],
)
def test_the_stage_is_named_at_which_a_difference_starts(folder, section, name, key, stage) -> None:
    record(folder, section, name, **{key: "another"})
    (work,) = [work for work in rebuildable(folder) if work.name == name]
    assert rebuild(work) == Found(name, "changed", stage)


def test_a_record_that_says_too_little_is_stale(folder) -> None:
    record(folder, "videos", "v.mp4", scene={"emotion": "anger"})
    (work,) = [work for work in rebuildable(folder) if work.name == "v.mp4"]
    stale = Found("v.mp4", "stale", "recorded by another version of emovid")
    assert rebuild(work) == stale
    assert stale in status(folder)


def test_a_record_of_another_version_names_what_changed_since(folder) -> None:
    versions = json.loads((folder / "manifest.json").read_text())["videos"]["v.mp4"]["versions"]
    older = versions | {"emovid": "0.0.1", "something": "1.0"}
    record(folder, "videos", "v.mp4", scene={"emotion": "anger"}, versions=older)
    assert Found("v.mp4", "stale", f"made with emovid 0.0.1, now {versions['emovid']}") in status(folder)


@pytest.mark.parametrize("key", ["trajectory_sha256", "frames_crc32", "sha256"])
def test_what_a_record_does_not_say_is_no_match(folder, key) -> None:
    manifest = json.loads((folder / "manifest.json").read_text())
    del manifest["videos"]["v.mp4"][key]
    (folder / "manifest.json").write_text(json.dumps(manifest))
    (work,) = [work for work in rebuildable(folder) if work.name == "v.mp4"]
    assert rebuild(work).state == "changed"
    assert states(verify(folder))["v.mp4"] == ("corrupt" if key == "sha256" else "current")


def test_a_result_is_made_again_apart_whatever_its_name(folder) -> None:
    (work,) = [work for work in rebuildable(folder) if work.name == "t.npz"]
    for name in ("../../t.npz", str(folder / "again.npz")):
        assert rebuild(work._replace(name=name)) == Found(name, "current")
    assert not (folder / "again.npz").exists()
    assert not (Path(tempfile.gettempdir()).parent / "t.npz").exists()


def test_of_a_sweep_all_items_of_the_plan_are_told(tmp_path) -> None:
    (tmp_path / "sweep.yaml").write_text(
        "only: trajectory\nscenes: [anger]\nset: {duration: 0.2, robots: 2}\nseeds: 4\n"
    )
    sweep, folder = read_sweep_file(tmp_path / "sweep.yaml"), tmp_path / "out"
    write_plan(folder, sweep)
    made, stray, absent, older = (item.job(folder, sweep.only) for item in items(sweep))
    assert not make_missing([made, older], Nobody(), InProcess(Nobody().advanced)).failures
    record(folder, "trajectories", older.target.name, scene_digest="of another")
    stray.target.write_bytes(b"")
    assert status(folder) == [
        Found(made.target.name, "current"),
        Found(stray.target.name, "missing", "there, but not recorded"),
        Found(absent.target.name, "missing"),
        Found(older.target.name, "stale", "made of another scene"),
    ]


def test_a_contact_sheet_is_current_or_corrupt_and_never_made_again_alone(folder) -> None:
    sheet = folder / "contact-sheet.png"
    sheet.write_bytes(b"a picture")
    with Ledger(folder) as ledger:
        ledger.add(sheet.name, {"only": "sheet", "sha256": file_digest(sheet)})
    assert states(status(folder))[sheet.name] == "current"
    assert sheet.name not in {work.name for work in rebuildable(folder)}
    sheet.write_bytes(b"another")
    assert states(status(folder))[sheet.name] == states(verify(folder))[sheet.name] == "corrupt"


def test_a_folder_of_something_else_is_one_line(tmp_path) -> None:
    for find in (status, verify):
        with pytest.raises(InputError, match=r"no results: expected a folder with a manifest\.json"):
            find(tmp_path)
