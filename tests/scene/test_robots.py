"""Robot files: contents, use in scenes, and messages about invalid files."""

import json
import pickle
import re
from math import hypot
from pathlib import Path

import jsonschema
import pytest

from emovid.cli.main import main
from emovid.errors import SourceError
from emovid.scene.load import (
    Setting,
    load_robot,
    load_scene,
    parse_scene,
    scene_digest,
    scene_schema,
    scene_text,
    shipped_robots,
)
from emovid.scene.robots import Limits

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "robots.md").read_text()
BROKEN = sorted((ROOT / "configs" / "errors" / "robots").iterdir())
OWN = """
kinematics: unicycle
shape:
  kind: circle
  radius: 0.02
height: 0.03
wheels:
  radius: 0.006
  width: 0.002
  base: 0.03
limits:
  wheel_max: 0.15
"""


def scene_of(model: object, **keys: object):
    settings = [Setting("robot.model", model, "test"), *(Setting(f"robot.{key}", keys[key], "test") for key in keys)]
    return load_scene("sadness", settings)


def test_shipped_robots_are_listed() -> None:
    expected = ["crazyflie", "e_puck2", "gritsbot", "gritsbot_x", "single_integrator", "turtlebot3_burger"]
    assert shipped_robots() == expected
    assert {load_robot(name).name for name in expected} == set(expected)


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_robot_files_cite_sources_and_keep_the_line_length(name: str) -> None:
    lines = (ROOT / "configs" / "robots" / f"{name}.yaml").read_text().splitlines()
    header = " ".join(lines[: next(i for i, line in enumerate(lines) if not line.startswith("#"))])
    assert any(source in header for source in ("doi", "github.com", ".org", "Appendix A"))
    assert max(map(len, lines)) <= 120


def test_gritsbot_x_has_the_dimensions_of_the_robotarium() -> None:
    robot = load_robot("gritsbot_x")
    assert robot.wheels is not None
    assert (robot.wheels.radius, robot.wheels.base, robot.limits) == (0.016, 0.105, Limits(wheel_max=0.2))
    assert robot.shape.box == (0.09, 0.095)
    ahead, radius = robot.disc
    assert ahead == 0.015  # a sixth of the body
    # Two bodies at the smallest distance that the simulator allows do not touch.
    assert 2 * radius < 0.135
    assert robot.radius == pytest.approx(hypot(0.06 - 0.012, 0.0475 - 0.012) + 0.012)


def test_disk_around_the_body_center_is_smaller_than_around_the_axle() -> None:
    for name in shipped_robots():
        robot = load_robot(name)
        ahead, radius = robot.disc
        assert radius <= robot.radius <= radius + abs(ahead)


def test_robot_file_path_is_relative_to_the_scene(tmp_path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "mine.yaml").write_text(OWN)
    text = (ROOT / "configs" / "sadness.yaml").read_text()
    (tmp_path / "scene.yaml").write_text(text.replace("model: gritsbot", "model: robots/mine.yaml"))
    scene = load_scene(tmp_path / "scene.yaml")
    assert scene.robot.body.name == "mine"
    assert scene.robot.body.radius == 0.02
    assert scene.robot.limits is None


def test_loaded_scene_contains_its_robot(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(OWN)
    scene = scene_of(str(file))
    file.unlink()
    again = parse_scene(scene_text(scene), "again.yaml")
    assert again.resolved() == scene.resolved()
    assert scene_digest(again) == scene_digest(scene)


def test_pickled_scene_contains_its_robot(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(OWN)
    sent = pickle.dumps(scene_of(str(file)))
    file.unlink()
    assert pickle.loads(sent).robot.body.wheels.base == 0.03  # noqa: S301 - what we have just dumped


def test_a_wheel_base_changes_the_digest_and_a_comment_does_not(tmp_path) -> None:
    file = tmp_path / "mine.yaml"
    digests = []
    for text in (OWN, OWN.replace("0.03\nlimits", "0.031\nlimits"), f"# another\n{OWN}"):
        file.write_text(text)
        digests.append(scene_digest(scene_of(str(file))))
    assert digests[0] == digests[2] != digests[1]


def test_digest_does_not_depend_on_the_folder_of_a_robot_file(tmp_path) -> None:
    digests = set()
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mine.yaml").write_text(OWN)
        digests.add(scene_digest(scene_of(str(tmp_path / folder / "mine.yaml"))))
    assert len(digests) == 1


def test_model_limits_come_from_the_robot_file() -> None:
    assert scene_of("gritsbot", limits="model").robot.limits == Limits(v_max=0.1, omega_max=6.283185307179586)
    assert scene_of("gritsbot").robot.limits is None


@pytest.mark.parametrize("limits", [{"v_max": 0.1}, {"v_max": 0.2, "omega_max": 3.0}])
def test_model_limits_come_from_a_robot_written_in_the_scene(limits) -> None:
    body = {"kinematics": "unicycle", "shape": {"kind": "circle", "radius": 0.01}, "height": 0.02}
    assert scene_of(body | {"limits": limits}, limits="model").robot.limits == Limits(**limits)
    with pytest.raises(SourceError, match=r"test: robot.limits: model: a robot has none; expected null or limits"):
        scene_of(body, limits="model")
    with pytest.raises(SourceError, match=r"test: robot.limits: model: a beetle has none"):
        scene_of(body | {"name": "beetle"}, limits="model")


@pytest.mark.parametrize("model", [3, None, ["gritsbot"]])
def test_limits_without_a_model_are_refused(model) -> None:
    with pytest.raises(SourceError, match=r"test: robot.model: .*: expected a robot's name"):
        scene_of(model, limits="model")


def test_a_robot_can_be_written_in_the_scene() -> None:
    scene = scene_of({"kinematics": "single_integrator", "shape": {"kind": "circle", "radius": 0.01}, "height": 0.02})
    assert (scene.robot.body.name, scene.robot.body.radius, scene.robot.body.steers) == ("robot", 0.01, False)


@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.stem)
def test_invalid_robot_gives_one_line_with_file_and_line(path, capsys, monkeypatch, tmp_path) -> None:
    monkeypatch.chdir(ROOT)
    expected = path.read_text().splitlines()[0].removeprefix("# expected: ")
    with pytest.raises(SourceError) as caught:
        load_robot(path.relative_to(ROOT))
    assert str(caught.value) == expected
    scene = (ROOT / "configs" / "sadness.yaml").read_text().replace("model: gritsbot", f"model: {path}")
    (tmp_path / "scene.yaml").write_text(scene)
    assert main(["scene", "check", str(tmp_path / "scene.yaml")]) == 2
    assert capsys.readouterr().err == f"{ROOT}/{expected}\n"


def test_examples_of_invalid_robots_cover_every_kind() -> None:
    kinds = {"unknown_key", "missing_key", "wrong_kinematics", "wrong_shape", "corner_too_round", "no_group"}
    assert kinds <= {path.stem for path in BROKEN}


def test_empty_robot_file_is_refused(tmp_path) -> None:
    (tmp_path / "empty.yaml").write_text("# nothing\n")
    with pytest.raises(SourceError, match=r"empty.yaml: empty: expected a robot$"):
        load_robot(tmp_path / "empty.yaml")


def test_the_schema_offers_names_files_and_a_robot_in_the_scene() -> None:
    validator = jsonschema.Draft202012Validator(scene_schema())
    scene = json.loads(json.dumps(load_scene("sadness").resolved()))
    for model in ("gritsbot_x", "robots/mine.yaml", scene["robot"]["model"]):
        validator.validate(scene | {"robot": scene["robot"] | {"model": model, "limits": "model"}})
    for model in ("gritsbotx", 2, {"kinematics": "unicycle"}):
        assert not validator.is_valid(scene | {"robot": scene["robot"] | {"model": model}})


def test_robots_are_listed(capsys) -> None:
    assert main(["scene", "robots"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == shipped_robots()
    assert "0.2 m/s per wheel" in next(line for line in lines if line.startswith("gritsbot_x"))
    assert main(["scene", "robots", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["turtlebot3_burger"]["wheels"]["base"] == 0.16


@pytest.mark.parametrize("name", ["x" * 300 + ".yaml", "robot.yaml\n"])
def test_robot_name_that_no_file_can_have_is_refused(name: str) -> None:
    with pytest.raises(SourceError, match=r"^test: robot.model: ") as caught:
        scene_of(name)
    assert "\n" not in str(caught.value)


def test_robots_page_lists_all_robots_and_its_example_loads(tmp_path) -> None:
    assert sorted(re.findall(r"^\| `([a-z0-9_]+)` \|", GUIDE, re.MULTILINE)) == shipped_robots()
    (text,) = re.findall(r"```yaml\n(# roomba.yaml.*?)```", GUIDE, re.DOTALL)
    (tmp_path / "roomba.yaml").write_text(text)
    roomba = load_robot(tmp_path / "roomba.yaml")
    assert (roomba.name, roomba.radius) == ("roomba", 0.17)
