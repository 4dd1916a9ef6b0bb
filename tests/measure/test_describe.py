import re
from dataclasses import replace
from math import isnan
from pathlib import Path

import numpy as np
import pytest

from emovid.errors import InputError
from emovid.measure.describe import DESCRIPTORS, FAMILIES, describe
from emovid.measure.window import Window, window_of
from emovid.scene.emotions import EMOTIONS
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from tests.helpers.driven import standing

DOCS = Path(__file__).parents[2] / "docs" / "descriptors.md"


@pytest.fixture(scope="module")
def runs(make_scene) -> dict[str, Trajectory]:
    return {emotion: simulate(make_scene(emotion, {"duration": 3})) for emotion in EMOTIONS}


# --- the table --------------------------------------------------------------------------------------------------------


def test_the_documentation_has_each_descriptor_with_unit_definition_and_source() -> None:
    sections = re.split(r"^## ", DOCS.read_text(), flags=re.MULTILINE)
    tables = {section.partition("\n")[0]: re.findall(r"^\| `(.*) \|$", section, re.MULTILINE) for section in sections}
    expected = {
        family: [f"{each.name}` | {each.unit} | {each.definition} | {each.source}".rstrip() for each in descriptors]
        for family, descriptors in FAMILIES.items()
    }
    assert {family: [row.rstrip() for row in tables.get(family, [])] for family in FAMILIES} == expected


def test_descriptor_names_are_unique() -> None:
    assert len(DESCRIPTORS) == sum(len(family) for family in FAMILIES.values())


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_each_descriptor_has_a_value_in_the_order_of_the_table(runs, emotion) -> None:
    found = describe(runs[emotion])
    assert list(found) == list(DESCRIPTORS)
    assert all(type(value) is float for value in found.values())
    undefined = {name for name, value in found.items() if isnan(value)}
    covers = emotion in ("fear", "disgust", "anger")
    assert undefined == (set() if covers else {each.name for each in FAMILIES["Convergence"]})


# --- the window -------------------------------------------------------------------------------------------------------


def test_window_ends_at_the_last_snapshot_or_the_end_of_the_run(make_scene) -> None:
    def ends(emotion: str, keys: dict[str, object]) -> float:
        return window_of(simulate(make_scene(emotion, keys))).end

    assert ends("happiness", {"duration": 5}) == EMOTIONS["happiness"].snapshot_times[-1] == 4
    assert ends("happiness", {"duration": 5, "emotion": None}) == 5
    assert ends("happiness", {"duration": 3}) == 3


@pytest.mark.parametrize(("start", "end"), [(2, 2), (2, 1), (-1, 2), (0, 3.5), (float("nan"), 2)])
def test_empty_window_or_window_outside_the_run_is_refused(runs, start, end) -> None:
    with pytest.raises(InputError, match=r"expected a start before its end, both within the run of 0 to 3 s"):
        describe(runs["fear"], start, end)


def test_values_depend_only_on_the_window(runs) -> None:
    whole = runs["fear"]
    k = np.flatnonzero(np.isclose(whole.t, 2.0))[0]
    parts = {name: getattr(whole, name)[:k] for name in ("commands", "stage_cut", "separation_cut")}
    first = replace(whole, t=whole.t[: k + 1], poses=whole.poses[: k + 1], **parts)
    assert describe(whole, 0.0, 2.0) == pytest.approx(describe(first), rel=1e-9, abs=1e-12)


# --- invariance -------------------------------------------------------------------------------------------------------


def test_video_keys_do_not_change_descriptors(runs, make_scene) -> None:
    other = make_scene("anger", {"duration": 3, "video.fps": 60, "video.size": "640x360", "video.trails.robots": 0})
    assert describe(simulate(other)) == describe(runs["anger"])


@pytest.mark.parametrize("emotion", ["fear", "anger"])
def test_robot_order_and_mirroring_do_not_change_descriptors(runs, emotion) -> None:
    run = runs[emotion]
    who = np.random.default_rng(1).permutation(15)
    poses = run.poses[:, who] * [1, -1, -1]
    commands = run.commands[:, who] * [1, -1]
    other = replace(run, poses=poses, commands=commands)
    assert describe(other) == pytest.approx(describe(run), rel=1e-6, abs=1e-9)


# --- edge cases -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("emotion", ["sadness", "fear", "disgust", "anger"])
@pytest.mark.parametrize(
    "points",
    [
        [[0.1, 0.1]],
        [[0.1, 0.1], [-0.1, 0.2]],
        [[0.1, 0.1], [-0.1, 0.2], [0.3, 0]],
        [[0.0, 0.0], [0.1, 0.1], [0.2, 0.2]],  # on a line
        [[0.1, 0.1]] * 3,  # in one place
        [[0.1, 0.1], [0.1, 0.1], [0.3, 0]],
    ],
)
def test_few_stationary_robots_have_defined_size_and_undefined_motion_descriptors(make_scene, emotion, points) -> None:
    found = describe(standing(make_scene(emotion, {"robots": len(points)}), points))
    assert found["speed_mean"] == found["trace_length"] == 0
    undefined = {"sparc", "log_dimensionless_jerk", "turning_per_metre", "polarisation", "rotation"}
    assert all(isnan(found[name]) for name in undefined)
    assert not isnan(found["radius_of_gyration_mean"])


@pytest.mark.parametrize("emotion", EMOTIONS)
@pytest.mark.parametrize("robots", [1, 2, 3])
def test_few_robots_are_described(make_scene, emotion, robots) -> None:
    found = describe(simulate(make_scene(emotion, {"robots": robots, "duration": 1})))
    assert found["speed_mean"] > 0


def test_a_window_within_one_period_is_described(runs) -> None:
    found = describe(runs["fear"], 0.01, 0.02)
    assert found["speed_mean"] > 0
    assert Window(runs["fear"], 0.01, 0.02).times() == pytest.approx([0.01, 0.02])
