"""Sweep files: their items, their plan, and a one-line message for each error."""

import re
import shutil
from pathlib import Path

import pytest
import yaml
from PIL import Image

from emovid.batch import sweep as sweep_module
from emovid.batch.sweep import Items, axes, shard_of
from emovid.batch.sweep_file import Sweep, read_sweep
from emovid.errors import InputError, SourceError
from emovid.scene.load import find_scene, load_scene
from tests.helpers.batches import items

ROOT = Path(__file__).parents[2]
DRAWN = {"law": "coverage", "kappa": 1.0, "density": {"kind": "image", "file": "a.png", "smoothing": 0.05}}


@pytest.fixture
def read(tmp_path):
    def read_text(text: str, name: str = "sweep.yaml") -> Sweep:
        (tmp_path / name).write_text(text)
        return read_sweep(tmp_path / name)

    return read_text


def cells(sweep: Sweep) -> list[tuple]:
    found = Items(sweep)
    return [tuple(found.cells(number).values()) for number in range(1, len(found) + 1)]


def test_items_combine_all_scenes_entries_grid_points_and_seeds(read) -> None:
    sweep = read(
        "scenes: [anger, fear]\nseeds: [3, 5]\ngrid: {robot.K: [2, 4], robot.l: [0.01]}\n"
        "list:\n  - {duration: 2}\n  - {duration: 3, robots: 4}\n"
    )
    found, rows = items(sweep), cells(sweep)
    assert len(found) == 2 * 2 * 2 * 1 * 2
    assert Items(sweep).columns == ["scene", "duration", "robots", "robot.K", "robot.l", "seed"]
    assert rows[0] == ("anger", 2, None, 2, 0.01, 3)
    assert rows[-1] == ("fear", 3, 4, 4, 0.01, 5)
    assert [item.number for item in found] == list(range(1, 17))
    for item in found:
        scene, cell = item.scene, Items(sweep).cells(item.number)
        assert (scene.emotion, scene.duration, scene.seed) == (cell["scene"], cell["duration"], cell["seed"])
        assert (scene.robot.K, scene.robot.l, scene.robots) == (cell["robot.K"], 0.01, cell["robots"] or 15)


def test_keys_set_for_all_items_are_not_columns(read) -> None:
    sweep = read("scenes: [anger]\nset: {duration: 2}\n")
    (item,) = items(sweep)
    assert Items(sweep).cells(1) == {"scene": "anger"}
    assert item.scene.duration == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{from: 1, to: 3, count: 5}", [1.0, 1.5, 2.0, 2.5, 3.0]),
        ("{from: 3, to: 1, count: 2}", [3.0, 1.0]),
        ("{from: 1, to: 100, count: 3, log: true}", [1.0, 10.0, 100.0]),
        ("{from: 0.1, to: 0.7, count: 7}", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]),
        ("{from: 2.0, to: 4, count: 3}", [2.0, 3.0, 4.0]),
    ],
)
def test_a_range_is_evenly_spaced(read, text, expected) -> None:
    assert [cell[1] for cell in cells(read(f"scenes: [anger]\ngrid: {{robot.K: {text}}}\n"))] == expected


def test_integer_range_is_accepted_for_an_integer_key(read) -> None:
    assert cells(read("scenes: [fear]\ngrid: {robots: {from: 5, to: 15, count: 3}}\n")) == [
        ("fear", 5),
        ("fear", 10),
        ("fear", 15),
    ]
    with pytest.raises(SourceError, match=r"robots: 5\.5: expected a whole number"):
        items(read("scenes: [fear]\ngrid: {robots: {from: 5, to: 6, count: 3}}\n"))


def test_testbed_scenes_are_found_from_any_folder(read, monkeypatch) -> None:
    monkeypatch.chdir("/")
    (item,) = items(read("scenes: [robotarium/sadness]\n"))
    assert item.scene.resolved() == load_scene("robotarium/sadness").resolved()


def test_number_of_seeds_gives_seeds_from_1(read) -> None:
    assert cells(read("scenes: [fear]\nseeds: 3\n")) == [("fear", 1), ("fear", 2), ("fear", 3)]


def test_file_paths_are_relative_to_the_sweep_file(read, tmp_path, monkeypatch) -> None:
    (tmp_path / "mine.yaml").write_bytes(find_scene("sadness").read_bytes())
    monkeypatch.chdir("/")
    assert cells(read("scenes: [mine.yaml, anger]\n")) == [("mine",), ("anger",)]


def test_names_depend_on_content_and_are_stable_when_the_sweep_grows(read) -> None:
    few = items(read("scenes: [anger]\ngrid: {robot.K: [2, 4]}\n"))
    more = items(read("scenes: [fear, anger]\ngrid: {robot.K: [1, 2, 3, 4]}\n"))
    assert {item.name for item in few} < {item.name for item in more}
    assert all(len(item.name.removesuffix(".mp4").split("-")[1]) == 12 for item in more)


@pytest.mark.parametrize(("only", "suffix"), [("video", ".mp4"), ("trajectory", ".npz"), ("measure", "")])
def test_result_kind_is_part_of_the_name(read, only, suffix) -> None:
    (item,) = items(read(f"only: {only}\nscenes: [anger]\n"))
    assert item.name.removeprefix("anger-")[12:] == suffix


def test_format_is_part_of_the_name(read) -> None:
    sweep = read("scenes: [anger]\ngrid: {video.format: [webm, gif, png-sequence]}\n")
    assert [item.name[18:] for item in items(sweep)] == [".webm", ".gif", ""]


def test_plan_reproduces_the_sweep_without_other_files(read, tmp_path) -> None:
    (tmp_path / "mine.yaml").write_bytes(find_scene("sadness").read_bytes())
    first = read(
        "only: measure\nscenes: [mine.yaml, anger]\nseeds: 2\nset: {duration: 3}\n"
        "grid: {robot.K: {from: 1, to: 2, count: 3}}\nlist: [{robot.l: 0.01}, {robots: 3}]\n"
    )
    (tmp_path / "mine.yaml").unlink()
    again = read(first.plan(tmp_path).text, "plan.json")
    assert [(a.name, a.point) for a in items(again)] == [(b.name, b.point) for b in items(first)]
    assert axes(again) == axes(first)
    assert again.plan(tmp_path) == first.plan(tmp_path)


def test_plan_contains_robots_and_pictures_of_its_scenes(read, tmp_path) -> None:
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    anger = find_scene("anger").read_text().replace("model: gritsbot", "model: own.yaml")
    (scenes / "mine.yaml").write_text(anger.replace("limits: null", "limits: model"))
    (scenes / "own.yaml").write_bytes((ROOT / "configs/robots/gritsbot.yaml").read_bytes())
    (scenes / "drawn.yaml").write_text(yaml.safe_dump(load_scene("fear").resolved() | {"behaviour": DRAWN}))
    for name, grey in (("a", 0), ("b", 99)):
        Image.new("L", (8, 8), grey).save(scenes / f"{name}.png")
    first = read(
        "only: measure\nscenes: [scenes/mine.yaml, scenes/drawn.yaml]\nset: {robots: 3, start.min_spacing: null}\n"
        "list: [{robot.K: 2}, {robot.limits: null}, {robot.model: e_puck2}]\n"
    )
    named = [item.name for item in items(first)]
    plan = first.plan(tmp_path).text
    shutil.rmtree(scenes)
    assert [item.name for item in items(read(plan, "plan.json"))] == named


def test_plan_resolves_paths_of_set_files(read, tmp_path) -> None:
    for name, grey in (("a", 0), ("b", 99), ("c", 150)):
        Image.new("L", (8, 8), grey).save(tmp_path / f"{name}.png")
    (tmp_path / "own.yaml").write_bytes((ROOT / "configs/robots/e_puck2.yaml").read_bytes())
    (tmp_path / "drawn.yaml").write_text(yaml.safe_dump(load_scene("fear").resolved() | {"behaviour": DRAWN}))
    first = read(
        "scenes: [drawn.yaml]\nset: {robots: 3, start.min_spacing: null, robot: {model: own.yaml, l: 0.01, K: 1}}\n"
        "grid: {behaviour.density.file: [b.png, c.png]}\n"
    )
    (tmp_path / "elsewhere").mkdir()
    again = read(first.plan(tmp_path / "elsewhere").text, "elsewhere/plan.json")
    for one, other in zip(items(first), items(again), strict=True):
        assert one.scene.robot == other.scene.robot
        assert one.scene.behaviour.density.pixels == other.scene.behaviour.density.pixels
    assert len({item.scene.behaviour.density.pixels for item in items(again)}) == 2


def test_axes_are_listed_in_item_order(read) -> None:
    sweep = read("scenes: [anger]\nseeds: [4]\nlist: [{robots: 3, robot.l: 0.01}]\ngrid: {robot.K: [1.0, 2]}\n")
    assert axes(sweep) == [
        ("scene", ["anger"]),
        ("", ["robots 3, robot.l 0.01"]),
        ("robot.K", ["1", "2"]),
        ("seed", ["4"]),
    ]


WRONG = {
    "": "sweep.yaml: empty: expected a sweep",
    "[1]": "sweep.yaml: not a sweep: expected some of scenes, only, set, list, grid, seeds",
    "scenes: [anger]\nsedes: 3": "sweep.yaml:2: sedes: unknown key (did you mean seeds?)",
    "seeds: 3": "sweep.yaml:1: scenes: missing (a list of emotions and scene files)",
    "scenes: {}": "sweep.yaml:1: scenes: a group of keys: expected names of scenes and their keys",
    "scenes: []": "sweep.yaml:1: scenes: []: expected a list of emotions and scene files",
    "scenes:\n  - angr": "sweep.yaml:2: scenes.0: angr: no such file or emotion (did you mean anger?)",
    "scenes: [/no/such.yaml]": "sweep.yaml:1: scenes.0: /no/such.yaml: no such file or emotion",
    "scenes: [robotarium/angr]": "sweep.yaml:1: scenes.0: robotarium/angr: no such file or emotion (did you mean "
    "robotarium/anger?)",
    "scenes: {mine: 3}": "sweep.yaml:1: scenes.mine: 3: expected keys of a scene and their values, as in "
    "robot.l: 0.002",
    "scenes: {../mine: {robots: 3}}": "sweep.yaml:1: scenes.../mine: expected a name without /",
    "scenes: [3]": "sweep.yaml:1: scenes.0: 3: expected an emotion or a scene file",
    "scenes: [anger, anger]": "sweep.yaml:1: scenes.1: anger: there is another scene called anger",
    "scenes: [anger]\nonly: vidoe": "sweep.yaml:2: only: 'vidoe': expected one of video, trajectory, measure "
    "(did you mean video?)",
    "scenes: [anger]\nonly: [video]": "sweep.yaml:2: only: ['video']: expected one of video, trajectory, measure",
    "scenes: [anger]\nseeds: 0": "sweep.yaml:2: seeds: 0: expected a list of seeds, or how many, from 1 on",
    "scenes: [anger]\nseeds: [1, -1]": "sweep.yaml:2: seed: -1: expected at least 0",
    "scenes: [anger]\ngrid: [1]": "sweep.yaml:2: grid: [1]: expected keys of a scene, each with a list of "
    "values, as in "
    "robot.l: [0.002, 0.004]",
    "scenes: [anger]\ngrid:\n  robot.l: 0.1": "sweep.yaml:3: grid.robot.l: 0.1: expected a list of values, or "
    "{from: 0.001, "
    "to: 0.01, count: 10}",
    "scenes: [anger]\ngrid:\n  robot.l:\n    - 0.01\n    - -1": "sweep.yaml:5: robot.l: -1: expected more than 0",
    "scenes: [anger]\ngrid:\n  robot.k: [1]": "sweep.yaml:3: robot.k: unknown key (did you mean robot.K?)",
    "scenes: [anger]\ngrid:\n  robot.l: {form: 1}": "sweep.yaml:3: grid.robot.l.form: unknown key (did you mean from?)",
    "scenes: [anger]\ngrid:\n  robot.l: {from: 1, to: a, count: 2}": "sweep.yaml:3: grid.robot.l.to: 'a': "
    "expected a number",
    "scenes: [anger]\ngrid:\n  robot.l: {from: 0, to: 1, count: 2, log: true}": "sweep.yaml:3: grid.robot.l: log: "
    "expected from and to above 0",
    "scenes: [anger]\nlist: 3": "sweep.yaml:2: list: 3: expected a list of groups of keys, as in - {robot.l: 0.002, "
    "robot.K: 6}",
    "scenes: [anger]\nlist: [3]": "sweep.yaml:2: list.0: 3: expected keys of a scene and their values, as in robot.l: "
    "0.002",
    "scenes: [anger]\nset: {robot.K: 1}\ngrid: {robot.K: [1, 2]}": "sweep.yaml:3: grid.robot.K: given in set too",
    "scenes: [anger]\nseeds: [1]\nlist: [{seed: 1}]": "sweep.yaml:3: list.seed: given in seeds too",
    "scenes: [anger]\nseeds: [1, 1]": "sweep.yaml: items 1 and 2 are the same scene: scene anger, seed 1",
    "scenes: [anger]\nseeds: 1000\ngrid: {robot.K: {from: 1, to: 2, count: 1000}}": "sweep.yaml: 1000000 items: at "
    "most 100000",
    "scenes: [anger]\n  - x": "sweep.yaml:2: not YAML: this line or the one before it has a wrong indentation, or "
    "lacks its colon",
}  # fmt: skip


@pytest.mark.parametrize(("text", "message"), WRONG.items())
@pytest.mark.parametrize("folder", ["/", "."], ids=["from elsewhere", "from its folder"])
def test_error_names_file_line_and_key(read, tmp_path, monkeypatch, folder, text, message) -> None:
    monkeypatch.chdir(tmp_path / folder)
    with pytest.raises(SourceError) as error:
        items(read(text))
    assert str(error.value).replace(f"{tmp_path}/", "") == message


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, '{"scenes": 9' + "9" * 5000 + "}"])
def test_plan_that_is_not_json_gives_a_one_line_message(read, text) -> None:
    with pytest.raises(SourceError, match=r"plan\.json: not JSON: expected a plan that emovid sweep wrote$"):
        read(text, "plan.json")


def test_error_in_a_scene_names_the_scene(read, tmp_path) -> None:
    (tmp_path / "mine.yaml").write_text(find_scene("sadness").read_text().replace("robots: 15", "robots: many"))
    with pytest.raises(SourceError, match=r"mine\.yaml:[0-9]+: robots: 'many': expected a whole number"):
        items(read("scenes: [mine.yaml]\n"))


@pytest.mark.parametrize("given", ["0/4", "5/4", "a/4", "4", "1/", "-1/4", "1/2/3"])
def test_shard_must_be_a_number_and_a_count(given) -> None:
    with pytest.raises(InputError, match="expected a number and a count, from 1/40 to 40/40"):
        shard_of(given)
    assert shard_of("40/40") == (40, 40)


def test_shipped_sweep_is_valid_and_comments_every_key() -> None:
    (path,) = (ROOT / "configs" / "sweeps").glob("*.yaml")
    sweep = read_sweep(path)
    assert 1 < len(items(sweep)) <= sweep_module.MAX_ITEMS
    text = path.read_text()
    assert all(f"{key}:" in text for key in ("only", "scenes", "set", "list", "grid", "seeds"))


def test_a_syntax_error_in_a_scene_file_names_that_file(read, tmp_path) -> None:
    (tmp_path / "mine.yaml").write_text("emotion: [fear\n")
    with pytest.raises(SourceError, match=rf"^{re.escape(str(tmp_path))}/mine\.yaml:2: "):
        read("scenes: [mine.yaml]\n")
