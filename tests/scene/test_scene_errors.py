import re
from math import copysign
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.cli.options import settings
from emovid.errors import SourceError
from emovid.scene.load import load_scene
from emovid.scene.model import Scene

ROOT = Path(__file__).parents[2]
SHIPPED = "configs/happiness.yaml"
BROKEN = sorted(path for path in (ROOT / "configs" / "errors").iterdir() if path.is_file())
KINDS = [
    "unknown_key", "unknown_key_far", "unknown_group", "missing_key", "missing_group", "text_for_number",
    "quoted_number", "bool_for_number", "float_for_whole_number", "whole_number_with_point", "out_of_range", "nan",
    "inf", "yaml_syntax", "duplicate_key", "tag", "tag_of_yaml", "alias", "anchor", "contour_leaves_stage",
    "no_room_at_random", "no_room_in_region", "no_room_on_contour", "poses_overlap", "l_zero", "l_negative",
    "l_missing", "too_many_robots", "absurd_duration", "absurd_fps", "absurd_run", "odd_video_size", "bad_colour",
    "wrong_law", "wrong_shape", "wrong_emotion", "R_max_below_R_min", "A_not_below_R", "contour_start_with_coverage",
    "pose_count", "pose_off_stage", "region_off_stage", "sigma_too_small", "density_centre_off_stage", "limits_empty",
    "limits_of_wheels", "not_utf8", "empty_file", "top_level_list", "two_documents", "stage_of_two_forms",
    "stage_not_convex", "stage_star", "stage_corner_twice", "stage_corner_on_edge", "stage_of_two_corners",
    "stage_of_many_corners", "stage_corners_misspelt", "robot_larger_than_triangle", "contour_leaves_hexagon",
    "contour_centre_off_stage", "density_centre_off_triangle", "ridge_beyond_centre_of_triangle", "region_off_hexagon",
    "pose_off_triangle", "no_room_on_triangle", "robot_misspelt", "robot_file_missing", "robot_as_number",
    "robot_inline_incomplete", "limits_of_the_model_missing", "limits_misspelt",
]  # fmt: skip

BOX = {
    "kinematics": "unicycle",
    "shape": {"kind": "rectangle", "length": 0.03, "width": 2 / 75},
    "height": 0.03,
}


@pytest.fixture(autouse=True)
def _in_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def overridden(*pairs: str, source: str | Path = SHIPPED) -> Scene:
    return load_scene(source, settings(pairs))


def assert_refused(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, before: int = 0
) -> None:
    code = main(["render", *arguments, "-o", str(tmp_path / "out")])
    out, err = capsys.readouterr()
    assert err == expected + "\n"
    assert out == ""
    assert code == 2
    assert len(list(tmp_path.iterdir())) == before


# --- configs/errors --------------------------------------------------------------------------------------------------


def test_every_kind_of_error_has_an_example_in_configs():
    assert {path.suffix for path in BROKEN} == {".yaml"}
    assert set(KINDS) <= {path.stem for path in BROKEN}
    assert len(BROKEN) >= 80


@pytest.mark.parametrize(
    ("key", "corners", "expected"),
    [
        (
            "stage.corners",
            [{"x": 0, "y": 0}, {"x": 1}, {"x": 0, "y": 1}],
            "stage.corners.1.y: missing (meters above the origin, which is the center of a rectangular stage)",
        ),
        (
            "robot.model.shape.corners",
            [[0.01, 0.01], [0.01], [0, 0]],
            "robot.model.shape.corners.1.1: missing (a value)",
        ),
        ("stage.corners", [{"x": 0, "y": 0}, {"x": 1, "y": 1}], "stage.corners: a list of 2: expected at least 3"),
    ],
)
def test_invalid_list_item_is_named_instead_of_a_wrong_count(key, corners, expected):
    shape = {"robot.model": BOX | {"shape": {"kind": "polygon"}}} if "shape" in key else {"stage": {}}
    with pytest.raises(SourceError) as caught:
        load_scene("anger", shape | {key: corners})
    assert str(caught.value) == expected


@pytest.mark.parametrize(
    ("source", "keys", "expected"),
    [
        ("anger", {"video.format": "gif", "video.fps": 60}, "video.fps: 60: expected at most 50 in a gif"),
        ("anger", {"video.trails.seconds": None}, "video.trails.fade: true: a permanent trail cannot fade"),
        ("anger", {"robot.l": 1e-7}, "robot.l: 1e-07: expected at least a micrometer, 1e-06"),
        ("robotarium/anger", {"safety.period": 0.02}, "safety.period: 0.02: expected a whole number of times in the"),
        (
            "robotarium/anger",
            {"robot.model": "single_integrator", "robot.limits": None, "robot.l": None, "snapshots": None},
            "safety.kind: barrier: it needs the limits of the motors; expected robot.limits of v_max",
        ),
    ],
)
def test_keys_without_their_companions_are_refused(source, keys, expected):
    with pytest.raises(SourceError) as caught:
        load_scene(source, keys)
    assert f"{caught.value.key}: {caught.value.message}".startswith(expected)


@pytest.mark.parametrize(
    ("source", "key", "given", "others"),
    [
        ("robotarium/anger", "safety.spacing", 0.01, {}),
        ("robotarium/anger", "safety.gamma", 50.0, {"safety.period": 0.06, "control_period": 0.06}),
        ("anger", "start.min_spacing", 0.01, {"robot.model": "gritsbot_x", "robots": 1}),
        ("anger", "behaviour.density.sigma", 1e-4, {"stage": {"width": 1.0, "height": 2 / 3}}),
        ("disgust", "behaviour.density.inset", 1.0, {"stage": {"width": 1.0, "height": 2 / 3}}),
        ("fear", "robot.model.shape.corner", 0.03, {"robot.model": BOX}),
    ],
)
def test_bound_in_a_message_is_itself_accepted(source, key, given, others):
    keys = others | {"snapshots": None}
    with pytest.raises(SourceError) as caught:
        load_scene(source, keys | {key: given})
    assert caught.value.key == key
    bound = float(re.findall(r"[0-9][0-9.]*", caught.value.message)[-1])
    load_scene(source, keys | {key: bound})
    with pytest.raises(SourceError, match=key):  # and values clearly beyond it are refused
        load_scene(source, keys | {key: bound * (1 + copysign(1e-3, given - bound))})


@pytest.mark.parametrize(
    ("key", "source"), [("stage.width", "anger"), ("stage.height", "anger"), ("safety.period", "robotarium/anger")]
)
def test_number_too_small_to_divide_by_gives_a_one_line_message(key, source):
    with pytest.raises(SourceError, match=rf"^--set {key}=5e-324: {key}: 5e-324: expected at least 1e-06$"):
        overridden(f"{key}=5e-324", source=source)


@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.stem)
def test_invalid_scene_gives_one_line_and_writes_no_file(path, capsys, tmp_path):
    comment = path.read_bytes().splitlines()[0].decode("ascii")
    expected = comment.removeprefix("# expected: ")
    assert expected.startswith(f"configs/errors/{path.name}:")
    assert_refused([f"configs/errors/{path.name}"], expected, capsys, tmp_path)


# --- files without a scene -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("configs/nowhere.yaml", "configs/nowhere.yaml: no such file or emotion"),
        ("hapiness", "hapiness: no such file or emotion (did you mean happiness?)"),
        ("configs", "configs: cannot be read: is a directory"),
    ],
)
def test_missing_scene_file_is_reported(source, expected, capsys, tmp_path):
    assert_refused([source], expected, capsys, tmp_path)


def test_too_long_scene_name_is_reported(capsys, tmp_path):
    name = "x" * 300
    code = main(["render", name, "-o", str(tmp_path / "out")])
    out, err = capsys.readouterr()
    assert code == 2
    assert out == ""
    assert err.startswith(f"{name}: ")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_too_large_scene_file_is_refused(capsys, tmp_path):
    path = tmp_path / "large.yaml"
    with path.open("wb") as file:
        file.truncate(32_000_001)
    assert_refused([str(path)], f"{path}: too large for a scene: more than 32 MB", capsys, tmp_path, before=1)


# --- overrides -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--set", "robot.k=8"], "--set robot.k=8: robot.k: unknown key (did you mean robot.K?)"),
        (["--set", "video.frames=9"], "--set video.frames=9: video.frames: unknown key; "
                                      "expected one of size, fps, speed, begin, end, format, view, camera, "
                                      "trails, overlays, theme, colours"),
        (["--set", "robot.5=1"], "--set robot.5=1: robot.5: unknown key; expected one of model, l, K, limits, "
                               "saturation"),
        (["--set", "robot.K"], "--set robot.K: expected KEY=VALUE, as in robot.l=0.002"),
        (["--set", "=8"], "--set =8: expected KEY=VALUE, as in robot.l=0.002"),
        (["--set", "robot.K=fast"], "--set robot.K=fast: robot.K: 'fast': expected a number"),
        (["--set", "robot.K=-1"], "--set robot.K=-1: robot.K: -1: expected more than 0"),
        (["--set", "robot.K=[8"], "--set robot.K=[8: not YAML: expected ',' or ']', but got '<stream end>'"),
        (["--set", "robot.K.x=8"], "--set robot.K.x=8: robot.K.x: there is nothing at x to set"),
        (["--set", "video.colours.trails.5=#112233"], "--set video.colours.trails.5=#112233: video.colours.trails.5: "
                                                      "there is nothing at 5 to set"),
        (["--set", "robot=8"], "--set robot=8: robot: 8: expected a group of keys"),
        (["--set", "robot.l=20 mm"], "--set robot.l=20 mm: robot.l: '20 mm': expected a number (did you mean 0.02?)"),
        (["--set", "duration=2,5"], "--set duration=2,5: duration: '2,5': expected a number (did you mean 2.5?)"),
        (["--set", "duration=1,500"], "--set duration=1,500: duration: '1,500': expected a number"),
        (["--set", "duration=1m"], "--set duration=1m: duration: '1m': expected a number"),
        (["--set", "robots=1e1"], "--set robots=1e1: robots: 10.0: expected a whole number (did you mean 10?)"),
        (["--set", "robots=1e999"], "--set robots=1e999: robots: inf: expected a whole number"),
        (["--size", "1920 X 1079"], "--size 1920 X 1079: video.size: '1920 X 1079': expected width x height in pixels, "
                                    "as in 1280x720 (did you mean 1920x1080?)"),
        (["--set", "duration="], "--set duration=: duration: empty: expected a number"),
        (["--set", "robot.K=4", "--set", "seed=-1"], "--set seed=-1: seed: -1: expected at least 0"),
        (["--set", "stage={}"], "--set stage={}: stage.width: missing (extent along x [m])"),
        (["--set", "stage={width: 1}"], "--set stage={width: 1}: stage.height: missing (extent along y [m])"),
        (["--set", "stage.widht=1"], "--set stage.widht=1: stage.widht: unknown key (did you mean stage.width?)"),
        (["--set", "stage={Corner: []}"], "--set stage={Corner: []}: stage.Corner: unknown key "
                                          "(did you mean stage.corners?)"),
        (["--set", "stage={corners: null}"], "--set stage={corners: null}: stage.corners: empty: expected a list"),
        (["--set", "stage={corners: [[0, 0], [1, 0], [1, 1]]}"], "--set stage={corners: [[0, 0], [1, 0], [1, 1]]}: "
                                                               "stage.corners.0: [0, 0]: expected a group of keys"),
        (["--seed", "-1"], "--seed -1: expected a whole number, at least 0 (did you mean 0?)"),
        (["--size", "1281x720"], "--size 1281x720: video.size: 1281x720: expected two even numbers from 64 to 8192, "
                                 "as in 1280x720"),
        (["--fps", "0"], "--fps 0: expected a whole number, at least 1 (did you mean 1?)"),
    ],
)  # fmt: skip
def test_invalid_override_is_named(options, expected, capsys, tmp_path):
    assert_refused([SHIPPED, *options], expected, capsys, tmp_path)


@pytest.mark.parametrize("key", ["²", "start.poses.².x", "9" * 5000, "robot.", ".", "robot..K", "robot.K.0"])
def test_override_of_an_invalid_key_is_a_source_error(key):
    with pytest.raises(SourceError) as caught:
        overridden(f"{key}=1")
    assert str(caught.value).startswith("--set ")


def test_override_refused_by_the_simulator_is_named(capsys, tmp_path):
    source = ["configs/errors/no_room_at_random.yaml", "--set", "start.min_spacing=0.07", "--set", "robots=180"]
    message = "180 robots do not fit into 1.16 m x 0.761 m at random with 70 mm between centers: room was found for 135"
    assert_refused(source, f"--set robots=180: robots: {message}", capsys, tmp_path)


def test_override_can_fix_an_invalid_scene(capsys):
    broken = ["scene", "check", "configs/errors/out_of_range.yaml", "--set", "duration=0.2"]
    assert main(broken) == 2
    assert main([*broken, "--set", "behaviour.kappa=6.5"]) == 0
    assert capsys.readouterr().out.startswith("configs/errors/out_of_range.yaml: valid\n")


def test_later_override_wins():
    assert overridden("robot.K=4", "robot.K=5").robot.K == 5


def test_override_creates_its_parent_group():
    assert overridden().robot.limits is None
    limits = overridden("robot.limits.v_max=0.1").robot.limits
    assert limits is not None
    assert (limits.v_max, limits.omega_max, limits.wheel_max) == (0.1, None, None)


def test_override_creates_an_omitted_optional_group(tmp_path):
    short = tmp_path / "short.yaml"
    short.write_text(Path(SHIPPED).read_text(encoding="utf-8").partition("video:  #")[0], encoding="utf-8")
    assert load_scene(short).video.trails.robots != 2
    assert overridden("video.trails.robots=2", source=short).video.trails.robots == 2


def test_override_replaces_a_whole_group():
    start = overridden("start={place: stage, min_spacing: 0.05}").start
    assert start.model_dump() == {"place": "stage", "min_spacing": 0.05}


def test_override_sets_an_item_of_a_list():
    file = "configs/errors/poses_overlap.yaml"  # robots 1 and 2 overlap: only the simulator checks this
    poses = overridden("start.poses.1.x=0.1", source=file).start.model_dump()["poses"]
    assert [pose["x"] for pose in poses] == [0, 0.1, 0.2]


def test_invalid_override_of_a_list_item_is_named():
    with pytest.raises(SourceError) as caught:
        overridden("start.poses.1.x=east", source="configs/errors/poses_overlap.yaml")
    assert str(caught.value) == "--set start.poses.1.x=east: start.poses.1.x: 'east': expected a number"


def test_override_of_a_hex_color_is_not_read_as_a_comment():
    colours = overridden("video.colours.body=#112233", "video.colours.trails.1=#445566").video.colours
    assert colours.body == "#112233"
    assert colours.trails[1] == "#445566"


def test_override_without_a_value_is_null():
    assert load_scene("configs/fear.yaml").behaviour.model_dump()["u_max"] is not None
    assert overridden("behaviour.u_max=", source="configs/fear.yaml").behaviour.model_dump()["u_max"] is None


def test_override_may_have_an_equals_sign_in_its_value():
    with pytest.raises(SourceError, match=r"^--set emotion=a=b: emotion: 'a=b': expected one of happiness, "):
        overridden("emotion=a=b")
