import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.cli.main import main
from emovid.scene.difference import ABSENT, differences
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene, shipped_scene

CHANGES = {"robot.l": 0.0021, "robots": 9, "video.trails.seconds": 2.5, "video.colours.trails.3": "#102030", "seed": 12}


@given(st.sets(st.sampled_from(sorted(CHANGES))))
def test_diff_lists_exactly_the_replaced_keys(keys) -> None:
    fear = load_scene("fear")
    found = differences(fear, load_scene("fear", {key: CHANGES[key] for key in keys}))
    assert {row.key for row in found} == keys
    assert all(row.second == CHANGES[row.key] for row in found)


@pytest.mark.parametrize("other", sorted(set(EMOTIONS) - {"anger"}))
def test_applying_the_differences_turns_one_scene_into_the_other(other) -> None:
    anger, second = load_scene("anger"), load_scene(other)
    data = anger.resolved()
    for key, _, value in differences(anger, second):
        *groups, last = key.split(".")
        group = data
        for name in groups:
            if not isinstance(group.get(name), dict):
                group[name] = {}
            group = group[name]
        group.pop(last, None)
        if value is not ABSENT:
            group[last] = value

    def pruned(value):  # remove groups without keys
        if not isinstance(value, dict):
            return value
        kept = {key: pruned(item) for key, item in value.items()}
        return {key: item for key, item in kept.items() if item != {}}

    assert pruned(data) == pruned(second.resolved())


def test_a_key_that_only_one_scene_has_is_absent_in_the_other() -> None:
    found = {row.key: row for row in differences(load_scene("fear"), load_scene("anger"))}
    sigma = found["behaviour.density.sigma"]
    assert sigma.first is ABSENT
    assert sigma.second == load_scene("anger").behaviour.density.sigma


def test_lists_of_different_length_differ_as_one_key() -> None:
    one, two = (
        load_scene("fear", [Setting("video.colours.trails", trails, "")]) for trails in (["theme"], 2 * ["theme"])
    )
    assert differences(one, two) == [("video.colours.trails", ["theme"], ["theme", "theme"])]


def test_scene_diff_prints_a_table_and_exits_like_diff(tmp_path, capsys) -> None:
    mine = tmp_path / "mine.yaml"
    text = shipped_scene("anger").read_text()
    mine.write_text("# a comment is no difference\n" + text)
    assert main(["scene", "diff", "anger", str(mine)]) == 0
    assert capsys.readouterr() == ("", "")
    mine.write_text(text.replace("seed: ", "seed: 9"))
    assert main(["scene", "diff", "anger", str(mine)]) == 1
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    seed = load_scene("anger").seed
    assert rows == [["key", "anger", str(mine)], ["seed", str(seed), f"9{seed}"]]


def test_json_has_full_values_and_omits_absent_keys(capsys) -> None:
    assert main(["scene", "diff", "fear", "anger", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["first"], found["second"]) == ("fear", "anger")
    rows = {row["key"]: row for row in found["differences"]}
    assert rows["emotion"] == {"key": "emotion", "first": "fear", "second": "anger"}
    assert "first" not in rows["behaviour.density.sigma"]


def test_invalid_scene_gives_a_one_line_message(capsys) -> None:
    assert main(["scene", "diff", "fear", "angr"]) == 2
    assert capsys.readouterr().err == "angr: no such file or emotion (did you mean anger?)\n"
