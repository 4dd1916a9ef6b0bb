"""Any text for a scene or sweep gives a valid video, or exit code 2 and one line. `make chaos` tries more texts."""

import os
import tempfile
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emovid.cli.main import main
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene, shipped_scene
from emovid.video.ffmpeg import count_frames

EXAMPLES = int(os.environ.get("EMOVID_EXAMPLES", "30"))
# For every text, the run is short and the video is small.
TINY = ["--size", "64x64", "--fps", "5", "--set", "duration=0.4", "--set", "robots=3", "--set", "control_period=0.1"]
SWEEP = """only: measure
scenes: [anger, sadness]
set: {duration: 0.2, robots: 3, video.size: 64x64, video.fps: 5}
list:
  - {robot.l: 0.01}
grid:
  robot.K: {from: 1, to: 9, count: 2, log: true}
seeds: [1, 2]
"""
WORDS = st.sampled_from(
    [
        *("0", "1", "-1", "0.5", "1e-300", "1e300", "nan", ".inf", "9" * 50, "0x1F", "1:30", "null", "true", "", "x"),
        *("anger", "contour", "coverage", "circle", "gaussian", "stage", "region", "gritsbot", "webm", "gif", "dark"),
        *(
            "[]",
            "{}",
            "[1, 2]",
            "{x: 1}",
            '"#12345"',
            "'",
            '"',
            "&a",
            "*a",
            "!!str",
            "|",
            "---",
            "\t",
            "\x00",
            "\u00e9",
        ),
    ]
)


@st.composite
def damaged(draw, texts: list[str]) -> str:
    """Draw one of the texts with some of its lines removed, doubled, moved, or changed."""
    lines = draw(st.sampled_from(texts)).splitlines()
    for _ in range(draw(st.integers(0, 4))):
        i = draw(st.integers(0, len(lines) - 1))
        line = lines[i]
        match draw(st.sampled_from(["cut", "double", "indent", "value", "value", "value", "key", "insert"])):
            case "cut" if len(lines) > 1:
                del lines[i]
            case "double":
                lines.insert(i, line)
            case "indent":
                lines[i] = " " * draw(st.integers(0, 5)) + line.lstrip()
            case "value":
                lines[i] = f"{line.partition(':')[0]}: {draw(WORDS)}"
            case "key":
                lines[i] = f"{draw(WORDS)}:{line.partition(':')[2]}"
            case _:
                at = draw(st.integers(0, len(line)))
                lines[i] = line[:at] + draw(st.text(max_size=5)) + line[at:]
    return "\n".join(lines) + "\n"


def run(command: list[str], file: Path) -> tuple[int, list[str]]:
    said = StringIO()
    with redirect_stderr(said):
        code = main([*command, "-o", str(file.parent / "out"), "--jobs", "1", "--quiet"])
    return code, said.getvalue().splitlines()


def check_render(command: list[str], file: Path, stem: str) -> None:
    """Run a command that makes a video of two frames if its input is valid."""
    code, said = run(command, file)
    if code == 0:
        made = [path for path in (file.parent / "out").iterdir() if path.stem == stem]
        assert [path.is_dir() or count_frames(path) for path in made] in ([True], [2])
        assert said == []
    else:
        assert code == 2, said
        assert len(said) == 1, said
        assert not (file.parent / "out").exists()


SCENES = [shipped_scene(emotion).read_text() for emotion in EMOTIONS]
ANY = [HealthCheck.too_slow, HealthCheck.data_too_large]


@given(damaged(SCENES) | st.text(max_size=40))
@settings(max_examples=EXAMPLES, suppress_health_check=ANY)
def test_any_scene_gives_a_video_or_a_one_line_message(text) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_bytes(text.encode("utf-8", "surrogatepass"))
        check_render(["render", str(file), *TINY], file, "scene")


def leaves(keys: dict, path: str = "") -> list[str]:
    """Return the dotted names of the keys of a scene."""
    return [
        name
        for key, value in keys.items()
        for name in (leaves(value, f"{path}{key}.") if isinstance(value, dict) else [f"{path}{key}"])
    ]


SIZES_AND_TIMES = ("duration", "robots", "control_period", "video.size", "video.fps")  # set by TINY
KEYS = {
    emotion: [key for key in leaves(load_scene(emotion).resolved()) if key not in SIZES_AND_TIMES]
    for emotion in EMOTIONS
}
VALUES = st.one_of(st.floats(0.001, 3).map("{:.3g}".format), st.floats(), st.integers(), st.booleans(), WORDS)


@given(
    st.sampled_from(list(EMOTIONS)).flatmap(
        lambda name: st.tuples(
            st.just(name), st.dictionaries(st.sampled_from(KEYS[name]), VALUES, min_size=1, max_size=4)
        )
    )
)
@settings(max_examples=EXAMPLES, suppress_health_check=ANY)
def test_any_values_of_a_scene_give_a_video_or_a_one_line_message(scene) -> None:
    emotion, values = scene
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        assignments = [part for key, value in values.items() for part in ("--set", f"{key}={value}")]
        check_render(["render", emotion, *TINY, *assignments], file, emotion)


@pytest.mark.parametrize(
    "command",
    [
        ["render", "{}"],
        ["render", "anger", "-o", "{}/x.mp4"],
        ["sweep", "{}"],
        ["sweep", "look_ahead_and_gain", "-o", "{}"],
        ["status", "{}"],
        ["verify", "{}"],
        ["simulate", "anger", "-o", "{}/x.npz"],
    ],
    ids=" ".join,
)
def test_too_long_file_name_gives_a_one_line_message(command, capsys) -> None:
    assert main([part.format("x" * 300) for part in command]) == 2
    said = capsys.readouterr().err
    assert "xxx" in said
    assert said.endswith("file name too long\n")
    assert said.count("\n") == 1


@given(damaged([SWEEP]) | st.text(max_size=40))
@settings(max_examples=EXAMPLES, suppress_health_check=ANY)
def test_any_sweep_gives_a_table_or_a_one_line_message(text) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sweep.yaml"
        file.write_bytes(text.encode("utf-8", "surrogatepass"))
        code, said = run(["sweep", str(file), "--shard", "1/4"], file)
        if code == 0:
            assert len((file.parent / "out" / "results.csv").read_text().splitlines()) >= 2
        else:
            assert code == 2, said
            assert len(said) == 1, said
            assert not (file.parent / "out").exists()
