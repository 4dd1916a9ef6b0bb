import csv
import re
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.errors import EmovidError, InputError
from emovid.scene.load import Setting
from emovid.swarm.files import load_trajectory, save_trajectory
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory


@pytest.fixture(scope="module")
def run(make_scene) -> Trajectory:
    return simulate(make_scene("disgust", {"duration": 2, "control_period": 0.25}))


def test_npz_has_the_documented_arrays(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as arrays:
        assert arrays["t"].shape == (9,)
        assert arrays["poses"].shape == (9, 15, 3)
        assert arrays["commands"].shape == (8, 15, 2)
        assert "emotion: disgust" in str(arrays["scene"])


def test_saved_run_loads_unchanged(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.npz")
    back = load_trajectory(tmp_path / "run.npz")
    assert back.digest() == run.digest()
    assert back.scene.resolved() == run.scene.resolved()
    assert np.array_equal(back.stage_cut, run.stage_cut)
    assert np.array_equal(back.separation_cut, run.separation_cut)


def test_equal_runs_give_identical_files(run, tmp_path) -> None:
    for name in ("a.npz", "b.npz"):
        save_trajectory(run, tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_csv_has_a_row_for_each_sample_and_robot(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time", "robot", "x", "y", "heading", "v", "omega"]
    assert len(rows) == 9 * 15
    values = np.array([[float(row[key]) for key in ("x", "y", "heading")] for row in rows]).reshape(9, 15, 3)
    assert np.array_equal(values, run.poses)  # every digit
    held = np.array([[float(row[key]) for key in ("v", "omega")] for row in rows[:-15]]).reshape(8, 15, 2)
    assert np.array_equal(held, run.commands)
    assert {row[key] for row in rows[-15:] for key in ("v", "omega")} == {""}  # none after the last sample
    assert [int(row["robot"]) for row in rows[:15]] == list(range(1, 16))


def test_video_keys_of_a_saved_run_can_change_but_not_its_motion(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.npz")
    changed = load_trajectory(tmp_path / "run.npz", [Setting("video.fps", 60, "--fps 60")])
    assert changed.scene.video.fps == 60
    with pytest.raises(InputError, match=re.escape("--seed 3: seed: ")):
        load_trajectory(tmp_path / "run.npz", [Setting("seed", 3, "--seed 3")])


def npy() -> bytes:
    file = BytesIO()
    np.save(file, np.zeros(3))
    return file.getvalue()


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 broken", npy()])
def test_file_that_is_not_a_run_is_refused(tmp_path, content) -> None:
    (tmp_path / "x.npz").write_bytes(content)
    with pytest.raises(InputError, match="not a run"):
        load_trajectory(tmp_path / "x.npz")


@given(st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=3))
def test_damaged_run_loads_completely_or_is_refused(run, tmp_path_factory, changes) -> None:
    file = tmp_path_factory.getbasetemp() / "damaged.npz"
    save_trajectory(run, file)
    content = bytearray(file.read_bytes())
    for place, byte in changes:
        content[place % len(content)] = byte
    file.write_bytes(content)
    try:
        loaded = load_trajectory(file)
    except InputError:
        return
    assert loaded.digest() == run.digest()


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        (
            "poses",
            lambda poses: np.where(poses == poses.max(), np.nan, poses),
            "not all of poses are finite numbers",
        ),
        ("commands", lambda commands: commands.astype("U9"), "not all of commands are finite numbers"),
        ("t", lambda t: t[::-1], "the times in t do not rise"),
    ],
)
def test_run_with_nonfinite_values_is_refused(run, tmp_path, name, change, message) -> None:
    save_trajectory(replace(run, **{name: change(getattr(run, name))}), tmp_path / "run.npz")
    with pytest.raises(InputError, match=f"run.npz: not a run: {message}"):
        load_trajectory(tmp_path / "run.npz")


def test_run_with_wrong_array_shapes_is_refused(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as arrays:
        kept = {name: arrays[name] for name in arrays}
    np.savez(tmp_path / "bad.npz", **(kept | {"poses": kept["poses"][:, :3]}))
    with pytest.raises(InputError, match="not a run: arrays of shapes"):
        load_trajectory(tmp_path / "bad.npz")
    np.savez(tmp_path / "few.npz", t=kept["t"])
    with pytest.raises(InputError, match="not a run: expected"):
        load_trajectory(tmp_path / "few.npz")


def test_pickles_are_not_opened(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as arrays:
        kept = {name: arrays[name] for name in arrays}
    np.savez(tmp_path / "evil.npz", **(kept | {"scene": np.array([{"a": 1}], dtype=object)}))
    with pytest.raises(InputError, match="not a run"):
        load_trajectory(tmp_path / "evil.npz")


def test_a_missing_run_and_a_missing_folder_are_named(run, tmp_path) -> None:
    with pytest.raises(InputError, match="no such file"):
        load_trajectory(tmp_path / "none.npz")
    with pytest.raises(EmovidError, match="cannot be written: no such file"):
        save_trajectory(run, tmp_path / "none" / "run.npz")


def test_invalid_video_option_is_named(run, tmp_path) -> None:
    save_trajectory(run, tmp_path / "run.npz")
    with pytest.raises(InputError, match=r"^--fps 0: video\.fps: 0: expected at least 1$"):
        load_trajectory(tmp_path / "run.npz", [Setting("video.fps", 0, "--fps 0")])
