import copy
import pickle
import re
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft202012Validator
from pydantic import ValidationError

from emovid.errors import SourceError
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import (
    Setting,
    find_scene,
    load_scene,
    parse_scene,
    scene_digest,
    scene_schema,
    scene_text,
    shipped_scene,
)
from emovid.scene.model import Scene
from emovid.yaml_source import read_yaml

CONFIGS = Path(__file__).parents[2] / "configs"
DOI = "10.1007/s12369-020-00665-6"
BEHAVIOURS = {  # Table II and Appendix A of the paper
    "happiness": {"law": "contour", "shape": "circular_sinusoid"},
    "surprise": {"law": "contour", "shape": "expanding_circle"},
    "sadness": {"law": "contour", "shape": "circle"},
    "fear": {"law": "coverage", "kind": "uniform"},
    "disgust": {"law": "coverage", "kind": "boundary"},
    "anger": {"law": "coverage", "kind": "gaussian"},
}
TRIANGLE = [{"x": -0.6, "y": -0.4}, {"x": 0.6, "y": -0.4}, {"x": 0.0, "y": 0.6}]
SHORT = """\
emotion: null
behaviour:
  law: contour
  shape: circle
  R: 0.12
  angular_rate: 0.1
robot:
  model: single_integrator
  K: 4
robots: 3
stage:
  width: 1.2
  height: 0.8
start:
  place: contour
control_period: 0.05
duration: 15
seed: 1
"""

each_emotion = pytest.mark.parametrize("emotion", list(EMOTIONS))


def text_of(emotion: str) -> str:
    return (CONFIGS / f"{emotion}.yaml").read_text(encoding="utf-8")


def raw_of(emotion: str) -> dict:
    return read_yaml(text_of(emotion), f"{emotion}.yaml")[0]


def leaves(data, path=()):
    if isinstance(data, dict | list) and data:
        items = data.items() if isinstance(data, dict) else enumerate(data)
        return {key: value for name, item in items for key, value in leaves(item, (*path, name)).items()}
    return {".".join(map(str, path)): data}


def groups_in(data):
    items = data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    return ([data] if isinstance(data, dict) else []) + [group for item in items for group in groups_in(item)]


# --- the six shipped scenes ------------------------------------------------------------------------------------------


@each_emotion
def test_shipped_scene_matches_the_study(emotion):
    scene = load_scene(emotion)
    assert scene.emotion == emotion
    assert (scene.duration, scene.video.size, scene.video.fps, scene.robots) == (15, "1280x720", 30, 15)
    assert (scene.video.width, scene.video.height) == (1280, 720)
    assert scene.robot.body.name == "gritsbot"


@each_emotion
def test_shipped_scene_has_the_papers_behavior(emotion):
    written = leaves(raw_of(emotion)["behaviour"])
    assert BEHAVIOURS[emotion].items() <= {key.split(".")[-1]: value for key, value in written.items()}.items()


@each_emotion
def test_emotion_name_loads_its_file_in_configs(emotion):
    assert find_scene(emotion) == shipped_scene(emotion)
    assert shipped_scene(emotion).samefile(CONFIGS / f"{emotion}.yaml")
    assert load_scene(CONFIGS / f"{emotion}.yaml").resolved() == load_scene(emotion).resolved()


def test_configs_contain_only_the_six_emotions():
    assert {path.stem for path in CONFIGS.glob("*.yaml")} == set(EMOTIONS)


@each_emotion
def test_header_cites_the_paper_and_the_video(emotion):
    header = re.match(r"(#.*\n)+", text_of(emotion))
    assert header
    assert f"doi {DOI}" in header[0]
    assert EMOTIONS[emotion].video in header[0].split()
    assert header[0].lower().startswith(f"# {emotion}: ")


@each_emotion
def test_config_has_one_key_per_line(emotion):
    lines = [re.sub(r"(^|\s)#.*", "", line).rstrip() for line in text_of(emotion).splitlines()]
    written = [line for line in lines if line]
    assert len(written) > 35
    for line in written:
        assert re.fullmatch(r"(  )*(- \S+|\w+:( [^\s{}\[\]:]+)?)", line), line


@each_emotion
def test_config_spells_out_every_key(emotion):
    resolved = load_scene(emotion).resolved()
    resolved["robot"]["model"] = resolved["robot"]["model"]["name"]  # the other keys are in the file of the robot
    assert leaves(raw_of(emotion)).keys() == leaves(resolved).keys()


# --- text and digest -------------------------------------------------------------------------------------------------


@each_emotion
def test_scene_text_loads_as_the_same_scene(emotion):
    scene = load_scene(emotion)
    again = parse_scene(scene_text(scene), "again.yaml")
    assert again.resolved() == scene.resolved()
    assert scene_digest(again) == scene_digest(scene)


@pytest.mark.parametrize("value", [1e-7, 1e-300, 0.1 + 0.2, 1 / 3, 99.99999999999999])
def test_scene_text_keeps_every_digit(value):
    scene = parse_scene(SHORT, "f.yaml", [Setting("behaviour.angular_rate", value, "")])
    again = parse_scene(scene_text(scene), "again.yaml")
    assert again.resolved()["behaviour"]["angular_rate"] == value


def test_scene_text_spells_out_defaults():
    data = yaml.safe_load(scene_text(parse_scene(SHORT, "f.yaml")))
    assert data["behaviour"]["centre"] == {"x": 0, "y": 0}
    assert data["video"]["fps"] == 30
    assert data["robot"]["limits"] is None


@each_emotion
def test_digest_ignores_key_order_and_comments(emotion):
    raw = raw_of(emotion)
    expected = scene_digest(load_scene(emotion))
    backwards = yaml.safe_dump({key: raw[key] for key in reversed(raw)}, sort_keys=False)
    assert not backwards.startswith("emotion")
    assert scene_digest(parse_scene(backwards, "f.yaml")) == expected
    assert scene_digest(parse_scene("# a comment\n" + text_of(emotion), "f.yaml")) == expected
    assert re.fullmatch("[0-9a-f]{64}", expected)


@pytest.mark.parametrize("number", ["15.0", "1.5e1", "+15", "0xF", "15."])
def test_digest_ignores_the_notation_of_numbers(number):
    spelt = SHORT.replace("duration: 15", f"duration: {number}")
    assert scene_digest(parse_scene(spelt, "f.yaml")) == scene_digest(parse_scene(SHORT, "f.yaml"))


def test_digest_includes_omitted_defaults():
    spelt = SHORT + "video:\n  fps: 30\n"
    assert scene_digest(parse_scene(spelt, "f.yaml")) == scene_digest(parse_scene(SHORT, "f.yaml"))


def another(key, value):
    words = {"kinematics": "single_integrator", "wheel_max": 0.1, "size": "640x360", "limits": {"v_max": 0.1},
             "seconds": 3, "format": "webm", "theme": "dark", "snapshots": [0, 1], "view": "perspective",
             "distance": 2, "tilt": 30, "field_of_view": 60, "lights": [{"x": 0, "y": 0, "radius": 0.001}],
             "ahead": 0.001}  # fmt: skip
    name = key.split(".")[-1]
    if name in words:
        return words[name]
    if name == "emotion":
        return None
    if value is None:
        return 3
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return "#123456"
    return value + 1 if isinstance(value, int) else value * 1.01 or 0.01


@each_emotion
def test_digest_changes_with_any_value(emotion):
    scene = load_scene(emotion)
    resolved, text = scene.resolved(), scene_text(scene)
    needy = ("law", "shape", "kind", "place", "fade", "density", "saturation")  # other values need other keys
    free = [key for key in leaves(resolved) if key.split(".")[-1] not in needy]
    digests = {
        key: scene_digest(parse_scene(text, "f.yaml", [Setting(key, another(key, leaves(resolved)[key]), key)]))
        for key in free
    }
    assert len(free) >= 30
    assert len({*digests.values(), scene_digest(load_scene(emotion))}) == len(free) + 1


def test_digest_changes_with_the_kind_of_start():
    groups = (
        {"place": "contour"},
        {"place": "stage"},
        {"place": "poses", "poses": [{"x": x, "y": 0} for x in (0, 0.1, 0.2)]},
    )
    assert len({scene_digest(parse_scene(SHORT, "f.yaml", [Setting("start", group, "")])) for group in groups}) == 3


def test_byte_order_mark_and_crlf_change_nothing(tmp_path):
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + text_of("fear").replace("\n", "\r\n").encode())
    assert scene_digest(load_scene(path)) == scene_digest(load_scene("fear"))


# --- schema ----------------------------------------------------------------------------------------------------------


def test_schema_is_valid():
    Draft202012Validator.check_schema(scene_schema())
    assert scene_schema()["$schema"] == "https://json-schema.org/draft/2020-12/schema"


@each_emotion
def test_schema_accepts_shipped_scenes(emotion):
    Draft202012Validator(scene_schema()).validate(raw_of(emotion))


@pytest.mark.parametrize("corners", [TRIANGLE, TRIANGLE[::-1]])
def test_schema_accepts_a_stage_by_its_corners(corners):
    data = raw_of("anger") | {"stage": {"corners": corners}}
    Draft202012Validator(scene_schema()).validate(data)
    assert parse_scene(yaml.safe_dump(data), "f.yaml").stage.inradius > 0.3


@each_emotion
def test_schema_rejects_unknown_keys_in_every_group(emotion):
    validator = Draft202012Validator(scene_schema())
    count = len(groups_in(raw_of(emotion)))
    assert count >= 8
    for i in range(count):
        data = raw_of(emotion)
        groups_in(data)[i]["colour_of_the_sky"] = 1
        assert not validator.is_valid(data)


@pytest.mark.parametrize(
    ("key", "value"),
    [("duration", "15"), ("duration", -1), ("robots", 1.5), ("emotion", "joy"), ("seed", None), ("stage", []),
     ("stage", {}), ("stage", {"width": 1.2}), ("stage", {"corners": TRIANGLE[:2]}), ("stage", {"corners": None}),
     ("stage", {"width": 1.2, "height": 0.8, "corners": TRIANGLE}), ("stage", {"corners": TRIANGLE, "depth": 1}),
     ("start", {"place": "stage", "region": None}), ("behaviour", {"law": "contour"}), ("video", {"fps": 0}),
     ("video", {"colours": {"body": "red"}}), ("video", {"colours": {"trails": []}})],
)  # fmt: skip
def test_schema_and_parser_reject_the_same_values(key, value):
    data = raw_of("happiness")
    data[key] = value
    assert not Draft202012Validator(scene_schema()).is_valid(data)
    with pytest.raises(SourceError):
        parse_scene(yaml.safe_dump(data), "f.yaml")


@pytest.mark.parametrize("key", ["emotion", "behaviour", "robot", "robots", "stage", "start", "duration", "seed"])
def test_schema_and_parser_require_the_same_keys(key):
    data = raw_of("happiness")
    del data[key]
    assert not Draft202012Validator(scene_schema()).is_valid(data)
    with pytest.raises(SourceError, match=rf": {key}: missing"):
        parse_scene(yaml.safe_dump(data), "f.yaml")


def test_schema_describes_every_key():
    schemas = [group for group in groups_in(scene_schema()) if isinstance(group.get("properties"), dict)]
    described = [(name, item.get("description")) for schema in schemas for name, item in schema["properties"].items()]
    assert len(schemas) >= 20
    assert {"emotion", "law", "shape", "kind", "place", "l", "K", "wheel_max", "trails", "heading"} <= dict(
        described
    ).keys()
    assert not [name for name, description in described if not description]


# --- a loaded scene --------------------------------------------------------------------------------------------------


def test_pickled_scene_keeps_its_line_numbers():
    scene = parse_scene(SHORT, "f.yaml")
    copied = pickle.loads(pickle.dumps(scene))  # noqa: S301 - it is our own
    assert isinstance(copied, Scene)
    assert copied == scene
    assert copied.resolved() == scene.resolved()
    assert str(copied.fault("robots", "too many")) == "f.yaml:10: robots: too many"


def test_source_error_can_be_pickled():
    fault = parse_scene(SHORT, "f.yaml").fault("robots", "too many")
    copied = pickle.loads(pickle.dumps(fault))  # noqa: S301 - it is our own
    assert isinstance(copied, SourceError)
    assert (str(copied), copied.where, copied.key) == ("f.yaml:10: robots: too many", "f.yaml:10", "robots")


@pytest.mark.parametrize("key", ["robots", "robot.K", "behaviour.R", "video.colours.body"])
def test_scene_is_frozen(key):
    scene = load_scene("sadness")
    before = scene_digest(scene)
    *groups, last = key.split(".")
    holder = scene
    for group in groups:
        holder = getattr(holder, group)
    with pytest.raises(ValidationError, match="frozen"):
        setattr(holder, last, copy.copy(getattr(holder, last)))
    assert scene_digest(scene) == before


@pytest.mark.parametrize(
    ("key", "place"),
    [
        ("robots", "f.yaml:10"),
        ("behaviour.R", "f.yaml:5"),
        ("robot.l", "f.yaml:7"),  # left out: its group
        ("video.trails.robots", "f.yaml:1"),  # left out with its group
        ("start", "--start"),
        ("start.place", "--start"),  # written in the file, but replaced with its group
        ("start.poses", "--start"),
    ],
)
def test_source_error_names_file_and_line(key, place):
    start = {"place": "poses", "poses": [{"x": x, "y": 0} for x in (-0.1, 0, 0.1)]}
    scene = parse_scene(SHORT, "f.yaml", [Setting("start", start, "--start")])
    assert str(scene.fault(key, "too far")) == f"{place}: {key}: too far"


def test_source_error_names_the_line_of_a_list_item():
    poses = "start:\n  place: poses\n  poses:\n" + "".join(f"    - x: {x}\n      y: 0\n" for x in (-0.1, 0, 0.1))
    scene = parse_scene(SHORT.replace("start:\n  place: contour\n", poses), "f.yaml")
    assert scene.fault("start.poses.0", "").where == "f.yaml:17"
    assert scene.fault("start.poses.2", "").where == "f.yaml:21"
    assert scene.fault("start.poses.2.y", "").where == "f.yaml:22"


def test_load_scene_does_not_modify_the_given_values() -> None:
    robot = {"model": "gritsbot", "l": 0.02, "K": 3.0, "limits": "model"}
    density = {"kind": "gaussian", "sigma": 0.12}
    keys = {"robot": robot, "behaviour.density": density, "behaviour.density.sigma": 0.2}
    assert load_scene("anger", keys).behaviour.density.sigma == 0.2
    assert density == {"kind": "gaussian", "sigma": 0.12}
    # The second robot has its own limits, although a scene was made from the same values before.
    keys |= {"start.min_spacing": None, "robots": 3}
    limits = [load_scene("anger", keys | {"robot.model": model}).robot.limits for model in ("gritsbot", "e_puck2")]
    assert [limit.wheel_max for limit in limits] == [None, 0.154]


def test_load_scene_takes_a_mapping_and_names_unknown_keys() -> None:
    assert load_scene("anger", {"robot.l": 0.002, "video": {"fps": 5}}).video.fps == 5
    with pytest.raises(SourceError, match=r"^robot\.k: unknown key \(did you mean robot\.K\?\)$"):
        load_scene("anger", {"robot.k": 2})


OF_ITS_OWN = f"{SHORT}snapshots: [0, 5, 15]\n"


@pytest.mark.parametrize(
    ("duration", "snapshots"), [(15, (0, 5, 15)), (20, (0, 5, 15)), (9, (0, 5, 9)), (5, (0, 5)), (0.5, (0, 0.5))]
)
def test_shorter_duration_by_option_drops_later_snapshots(duration, snapshots) -> None:
    scene = parse_scene(OF_ITS_OWN, "my.yaml", [Setting("duration", duration, "--set")])
    assert scene.snapshots == snapshots
    assert scene_digest(parse_scene(scene_text(scene), "resolved")) == scene_digest(scene)


def test_snapshot_after_the_end_in_the_same_source_is_refused() -> None:
    def refusal(text: str, *settings: Setting) -> str:
        with pytest.raises(SourceError) as caught:
            parse_scene(text, "my.yaml", settings)
        return str(caught.value)

    shorter, late = Setting("duration", 4, "--set duration=4"), Setting("snapshots", [0, 16], "--set snapshots=[0, 16]")
    beyond = "expected at most the duration"
    wrong = OF_ITS_OWN.replace("15]", "16]")
    assert refusal(wrong) == f"my.yaml:19: snapshots.2: 16: {beyond}, 15"
    assert refusal(wrong, shorter) == f"my.yaml:19: snapshots.1: 5: {beyond}, 4"
    assert refusal(SHORT, late) == f"--set snapshots=[0, 16]: snapshots.1: 16: {beyond}, 15"
    assert refusal(OF_ITS_OWN, late, shorter) == f"--set snapshots=[0, 16]: snapshots.1: 16: {beyond}, 4"
    one = Setting("snapshots.1", 6, "--set snapshots.1=6")
    assert refusal(OF_ITS_OWN, shorter, one) == f"--set snapshots.1=6: snapshots.1: 6: {beyond}, 4"


@pytest.mark.parametrize(
    ("snapshots", "duration", "said"),
    [("[0, 12, 9]", 10, "snapshots.2: 9: expected more than the one before, 10"),
     ("[0, late]", 10, "snapshots.1: 'late': expected a number"), ("[]", 10, "snapshots: []: expected at least 1"),
     ("12", 10, "snapshots: 12: expected a list"), ("[0, 12]", -1, "duration: -1: expected more than 0"),
     ("[0, 12]", "short", "duration: 'short': expected a number")],
)  # fmt: skip
def test_shorter_duration_does_not_hide_other_errors(snapshots, duration, said) -> None:
    with pytest.raises(SourceError, match=rf"^\S+: {re.escape(said)}"):
        parse_scene(f"{SHORT}snapshots: {snapshots}\n", "my.yaml", [Setting("duration", duration, "--set")])
