"""Status and verification: every state of a result, and the stage that differs."""

import json
import tempfile
from pathlib import Path

import pytest

from emovid.atomic_io import file_digest
from emovid.batch.cache import make_missing
from emovid.batch.check import Finding, rebuild, rebuildable, status, verify
from emovid.batch.job import Job, Record
from emovid.batch.manifest import Journal
from emovid.batch.sweep_file import read_sweep
from emovid.batch.workers import InProcess
from emovid.errors import InputError
from tests.helpers.batches import Silent, jobs

SMALL = {"video.size": "96x64", "video.fps": 5, "duration": 0.4}


@pytest.fixture
def folder(make_scene, tmp_path) -> Path:
    jobs = [
        Job(make_scene("anger", SMALL), tmp_path / "v.mp4"),
        Job(make_scene("anger", SMALL), tmp_path / "t.npz", only="trajectory"),
        Job(make_scene("anger", SMALL), tmp_path / "m", only="measure"),
    ]
    assert not make_missing(jobs, Silent(), InProcess(Silent().advanced)).failures
    return tmp_path


def states(found: list[Finding]) -> dict[str, str]:
    return {result.name: result.state for result in found}


def record(folder: Path, section: str, name: str, **changes: object) -> None:
    """Change a record of the manifest."""
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest[section][name] |= changes
    (folder / "manifest.json").write_text(json.dumps(manifest))


def test_unchanged_results_are_current(folder) -> None:
    assert states(status(folder)) == {"v.mp4": "current", "t.npz": "current", "m": "current"}
    assert states(verify(folder)) == {"v.mp4": "current", "t.npz": "current", "m": "current"}
    assert states(map(rebuild, rebuildable(folder))) == {"v.mp4": "current", "t.npz": "current", "m": "current"}


def test_missing_stale_and_corrupt_results_are_distinguished(folder) -> None:
    (folder / "v.mp4").unlink()
    (folder / "t.npz").write_bytes(b"damaged")
    versions = json.loads((folder / "manifest.json").read_text())["measurements"]["m"]["versions"]
    record(folder, "measurements", "m", versions=versions | {"numpy": "1.0"})
    found = {result.name: result for result in status(folder)}
    assert states(found.values()) == {"v.mp4": "missing", "t.npz": "corrupt", "m": "stale"}
    assert found["m"].reason == f"made with numpy 1.0, now {versions['numpy']}"
    assert states(verify(folder)) == {"v.mp4": "missing", "t.npz": "corrupt", "m": "current"}


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
def test_first_differing_stage_is_named(folder, section, name, key, stage) -> None:
    record(folder, section, name, **{key: {"speed_mean": 0.0} if key == "descriptors" else "another"})
    (work,) = [work for work in rebuildable(folder) if work.name == name]
    assert rebuild(work) == Finding(name, "changed", stage)


def test_a_record_with_an_unreadable_scene_is_stale(folder) -> None:
    record(folder, "videos", "v.mp4", scene={"emotion": "anger"})
    (work,) = [work for work in rebuildable(folder) if work.name == "v.mp4"]
    stale = Finding("v.mp4", "stale", "recorded by another version of emovid")
    assert rebuild(work) == stale
    assert stale in status(folder)


def test_a_record_of_another_version_names_both_versions(folder) -> None:
    versions = json.loads((folder / "manifest.json").read_text())["videos"]["v.mp4"]["versions"]
    older = versions | {"emovid": "0.0.1", "something": "1.0"}
    record(folder, "videos", "v.mp4", scene={"emotion": "anger"}, versions=older)
    assert Finding("v.mp4", "stale", f"made with emovid 0.0.1, now {versions['emovid']}") in status(folder)


@pytest.mark.parametrize("key", ["trajectory_sha256", "frames_crc32", "sha256"])
def test_a_missing_digest_never_matches(folder, key) -> None:
    manifest = json.loads((folder / "manifest.json").read_text())
    del manifest["videos"]["v.mp4"][key]
    (folder / "manifest.json").write_text(json.dumps(manifest))
    (work,) = [work for work in rebuildable(folder) if work.name == "v.mp4"]
    assert rebuild(work).state == "changed"
    assert states(verify(folder))["v.mp4"] == ("corrupt" if key == "sha256" else "current")


def test_results_are_rebuilt_outside_their_folder(folder) -> None:
    (work,) = [work for work in rebuildable(folder) if work.name == "t.npz"]
    for name in ("../../t.npz", str(folder / "again.npz")):
        assert rebuild(work._replace(name=name)) == Finding(name, "current")
    assert not (folder / "again.npz").exists()
    assert not (Path(tempfile.gettempdir()).parent / "t.npz").exists()


def test_all_items_of_a_plan_are_listed(tmp_path) -> None:
    (tmp_path / "sweep.yaml").write_text(
        "only: trajectory\nscenes: [anger]\nset: {duration: 0.2, robots: 2}\nseeds: 4\n"
    )
    sweep, folder = read_sweep(tmp_path / "sweep.yaml"), tmp_path / "out"
    made, stray, absent, older = jobs(sweep, folder)
    assert not make_missing([made, older], Silent(), InProcess(Silent().advanced)).failures
    (folder / "plan.json").write_text(sweep.plan(folder).text)
    record(folder, "trajectories", older.target.name, scene_digest="of another")
    stray.target.write_bytes(b"")
    assert status(folder)[:4] == [
        Finding(made.target.name, "current"),
        Finding(stray.target.name, "missing", "exists, but is not recorded"),
        Finding(absent.target.name, "missing"),
        Finding(older.target.name, "stale", "made from another scene"),
    ]


def test_a_contact_sheet_is_current_or_corrupt_and_never_rebuilt(folder) -> None:
    sheet = folder / "contact-sheet.png"
    sheet.write_bytes(b"a picture")
    with Journal(folder) as journal:
        journal.add(sheet.name, Record("sheet", sha256=file_digest(sheet)))
    assert states(status(folder))[sheet.name] == "current"
    assert sheet.name not in {work.name for work in rebuildable(folder)}
    sheet.write_bytes(b"another")
    assert states(status(folder))[sheet.name] == states(verify(folder))[sheet.name] == "corrupt"


def test_folder_without_results_gives_a_one_line_message(tmp_path) -> None:
    for find in (status, verify):
        with pytest.raises(InputError, match=r"no results: expected a folder with a manifest\.json"):
            find(tmp_path)
