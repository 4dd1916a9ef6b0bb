"""The public functions for notebooks and scripts: those that the docs list exist, with these parameters, and work."""

import inspect
import re
from pathlib import Path

import matplotlib.figure
import numpy as np
import pytest

import emovid
from emovid.errors import InputError
from tests.helpers.tiny import write_study

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "docs" / "python.md").read_text()
SIGNATURES = re.findall(r"^\| `(\w+)\((.*)\)` \|", TEXT, re.MULTILINE)
TINY = {"duration": 0.4, "video.size": "96x64", "video.fps": 5}
REFERENCE = ROOT / "studies" / "santos-egerstedt" / "responses.csv"


def test_documented_functions_are_exactly_the_public_ones() -> None:
    assert {name for name, _ in SIGNATURES} | {"EmovidError", "InputError", "Trajectory", "__version__"} == set(
        emovid.__all__
    )
    assert set(emovid.__all__) <= set(dir(emovid))


@pytest.mark.parametrize(("name", "parameters"), SIGNATURES)
def test_documented_signatures_match_the_functions(name, parameters) -> None:
    found = inspect.signature(getattr(emovid, name)).parameters
    for said in parameters.split(", "):
        parameter, _, default = said.partition("=")
        assert parameter in found, (name, parameter)
        if default:
            assert repr(found[parameter].default) == default
        else:
            assert found[parameter].default is inspect.Parameter.empty


def test_version_matches_the_package() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", emovid.__version__)


def test_reprs_are_a_single_short_line() -> None:
    scene = emovid.load_scene("fear", {"duration": 1})
    run, responses = emovid.simulate(scene), emovid.read_responses(REFERENCE)
    for value, said in (
        (scene, "Scene(fear, 15 robots, 1 s, seed 1)"),
        (run, f"Trajectory(fear, 15 robots, {len(run.t)} samples, 1 s)"),
        (responses, "Responses(45 participants, 270 answers, 6 labels)"),
        (emovid.analyze(responses), "StudyResults(270 answers to 6 emotions)"),
    ):
        assert repr(value) == said


def test_numpy_numbers_are_accepted() -> None:
    seeds = [emovid.load_scene("fear", {"seed": seed}).seed for seed in np.arange(3)]
    assert seeds == [0, 1, 2]
    assert {type(seed) for seed in seeds} == {int}
    settings = {"video.overlays.clock": np.bool_(True), "robot.l": np.float32(0.25), "snapshots": np.array([0.0, 1.0])}
    scene = emovid.load_scene("fear", settings)
    assert scene.video.overlays.clock is True
    assert scene.robot.l == 0.25
    assert list(scene.snapshot_times) == [0.0, 1.0]


def test_wrong_argument_type_gives_a_one_line_message() -> None:
    with pytest.raises(emovid.InputError, match=r"^simulate: 'fear' is not a scene; expected one such as load_scene"):
        emovid.simulate("fear")
    with pytest.raises(
        emovid.InputError, match=r"^analyze: 'x.csv' is not a Responses object; expected the result of read_respon"
    ):
        emovid.analyze("x.csv")


@pytest.mark.parametrize("name", ["a.gif", "a.avi", "a.webm"])
def test_render_refuses_a_suffix_of_another_format(name, tmp_path) -> None:
    run = emovid.simulate(emovid.load_scene("fear", TINY))
    with pytest.raises(emovid.InputError, match=r"cannot write .*; expected .mp4, or a scene whose video.format is"):
        emovid.render_video(run, tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    gif = emovid.load_scene("fear", TINY | {"video.format": "gif"})
    emovid.render_video(emovid.simulate(gif), tmp_path / "a.gif")
    assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF89a")


def test_figures_of_the_paper_are_returned() -> None:
    assert isinstance(emovid.paper_figure("gritsbot"), matplotlib.figure.Figure)
    assert isinstance(emovid.paper_figure("circumplex"), matplotlib.figure.Figure)
    with pytest.raises(emovid.InputError, match=r"^gritsbt: no such figure \(did you mean gritsbot\?\)$"):
        emovid.paper_figure("gritsbt")


def test_simulated_responses_can_be_analyzed(tmp_path) -> None:
    table = emovid.simulate_responses(participants=12, accuracy=1.0, seed=3)
    table.to_csv(tmp_path / "responses.csv", index=False)
    matrix = emovid.confusion_table(emovid.read_responses(tmp_path / "responses.csv"))
    assert (matrix.index.name, matrix.columns.name) == ("perceived", "signalled")
    assert matrix.loc["anger", "anger"] == 12
    assert matrix.to_numpy().trace() == matrix.to_numpy().sum() == 72


def test_reference_study_matrix_has_its_labels() -> None:
    matrix = emovid.confusion_table(emovid.analyze(emovid.read_responses(REFERENCE)))
    assert matrix.loc["surprise", "happiness"] == 5  # perceived surprise of the video of happiness, Table III
    assert matrix.loc["happiness", "surprise"] == 8
    assert list(matrix.columns) == list(matrix.index)


def test_study_is_planned_and_its_kit_built(tmp_path) -> None:
    assert emovid.plan_study(rate=0.5).n == emovid.plan_study(0.5, 6, 6, 0.05, 0.8).n
    with pytest.raises(emovid.InputError, match="not above the chance"):
        emovid.plan_study(rate=0.1)
    built = emovid.build_kit(write_study(tmp_path), tmp_path / "kit", participants=6, seed=5)
    assert built.participants == 6
    assert (tmp_path / "kit" / "public").is_dir()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: emovid.load_scene("anger", ["robot.l=0.01"]), "expected settings as in"),
        (lambda: emovid.load_scene("anger", "robot.l=0.01"), "expected settings as in"),
        (lambda: emovid.load_scene(None), "expected the name of an emotion, or of a scene file"),
        (lambda: emovid.render_video("anger", "a.mp4"), "'anger' is not a trajectory"),
        (lambda: emovid.plan_study(rate="0.5"), "rate: '0.5': expected a share from 0 to 1"),
        (lambda: emovid.plan_study(rate=50), "rate: 50: expected a share from 0 to 1"),
        (lambda: emovid.plan_study(choices=1), "choices: 1: expected at least 2"),
        (lambda: emovid.simulate_responses(accuracy=50), "accuracy: 50: expected a share from 0 to 1"),
        (lambda: emovid.simulate_responses(participants=0), "participants: 0: expected at least 1"),
    ],
)
def test_invalid_arguments_raise_an_input_error(call, message) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert message in str(caught.value)
