"""The examples in docs/examples: each runs, in an empty folder, and does what its first line says."""

import runpy
from pathlib import Path

import pytest

import emovid
from emovid.cli.main import main
from tests.helpers.tiny import write_study

EXAMPLES = sorted((Path(__file__).parent.parent / "docs" / "examples").glob("*.py"))
MADE = {
    "build_a_kit": ["kit"],
    "draw_a_figure": ["circumplex.pdf"],
    "own_density": ["two_crowds.mp4"],
    "plan_a_study": ["simulated.csv"],
    "render_an_emotion": ["anger.mp4"],
}


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_examples_run_unchanged(example, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    given = []
    if "responses.csv" in example.read_text():
        assert main(["study", "simulate", "-o", "responses.csv"]) == 0
        given = ["responses.csv"]
    if "study.yaml" in example.read_text():
        write_study(tmp_path)
        given = ["study.yaml"]
    capsys.readouterr()
    runpy.run_path(str(example), run_name="__main__")
    assert bool(capsys.readouterr().out) == (example.stem != "show_in_a_notebook")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(given + MADE.get(example.stem, []))


@pytest.mark.parametrize("example", EXAMPLES, ids=[path.stem for path in EXAMPLES])
def test_examples_are_short_and_have_a_docstring(example) -> None:
    lines = example.read_text().splitlines()
    assert len(lines) < 30
    assert lines[0].startswith('"""')


def test_every_public_name_can_be_imported_and_every_function_is_used_by_an_example() -> None:
    texts = "".join(path.read_text() for path in EXAMPLES)
    for name in emovid.__all__:
        public = getattr(emovid, name)
        if name == "__version__":
            assert isinstance(public, str)
            continue
        assert isinstance(public, type) or f"{name}(" in texts, name
        assert callable(public)
    assert set(emovid.__all__) <= set(dir(emovid))
    with pytest.raises(AttributeError, match="has no attribute 'simulat'"):
        _ = emovid.simulat


def test_errors_can_be_caught_by_their_public_names() -> None:
    with pytest.raises(emovid.InputError, match="no such file or emotion") as caught:
        emovid.load_scene("nowhere.yaml")
    assert isinstance(caught.value, emovid.EmovidError)
