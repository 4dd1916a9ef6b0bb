"""`emovid figures contact-sheet`: frames of any video, scene or run."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from emovid.cli.main import main
from emovid.scene.load import load_scene
from emovid.swarm.simulate import simulate
from emovid.video.painter import Painter

SHORT = ["--set", "duration=2"]
LEFT = TOP = 25  # pixels around the sheet
GAP, LINE = 6, 50  # pixels between pictures, and for the time under each


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def sheet(name: str, columns: int) -> np.ndarray:
    """Return the pictures of a sheet with some columns, row by row (K, height, width, 3)."""
    with Image.open(f"figures/{name}-contact-sheet.png") as opened:
        page = np.asarray(opened.convert("RGB"))
    width = (page.shape[1] - 2 * LEFT - (columns - 1) * GAP) // columns
    height = round(width * 720 / 1280)
    rows = round((page.shape[0] - 2 * TOP + GAP) / (height + LINE + GAP))
    tops = TOP + (height + LINE + GAP) * np.arange(rows)
    lefts = LEFT + (width + GAP) * np.arange(columns)
    return np.array([page[top : top + height, left : left + width] for top in tops for left in lefts])


def test_scene_is_shown_at_sixteen_times_from_start_to_end() -> None:
    assert main(["figures", "contact-sheet", "anger", *SHORT, "--set", "video.theme=dark", "--quiet"]) == 0
    shown = sheet("anger", 4)
    scene = load_scene("anger")
    video = scene.video.model_copy(update={"theme": "dark", "size": f"{shown.shape[2]}x{shown.shape[1]}"})
    painter = Painter(simulate(scene.model_copy(update={"duration": 2.0})), video)
    assert len(shown) == 16
    for picture, t in zip(shown, np.linspace(0, 2, 16), strict=True):
        assert np.array_equal(picture, painter.frame(t)[..., :3])


def test_contact_sheet_of_a_video_equals_that_of_its_scene() -> None:
    main(["render", "fear", *SHORT, "--fps", "10", "-o", "clip.mp4", "--quiet"])
    for source in ("clip.mp4", "fear"):
        keys = SHORT if source == "fear" else []
        arguments = ["--times", "0,1.5,0.5", "--format", "png", "--quiet", *keys]
        assert main(["figures", "contact-sheet", source, *arguments]) == 0
    clip, fear = sheet("clip", 3).astype(float), sheet("fear", 3).astype(float)
    assert clip.shape == fear.shape == (3, *clip.shape[1:])
    for i, picture in enumerate(clip):
        off = np.abs(fear - picture).mean(axis=(1, 2, 3))
        assert np.argmin(off) == i
        assert off[i] < 2


def test_finished_run_in_one_column() -> None:
    main(["simulate", "fear", "--set", "duration=1", "-o", "run.npz", "--quiet"])
    arguments = ["--count", "5", "--style", "one-column", "--format", "png", "--quiet"]
    assert main(["figures", "contact-sheet", "run.npz", *arguments]) == 0
    shown = sheet("run", 2)
    with Image.open("figures/run-contact-sheet.png") as page:
        assert page.width == 3.5 * 300
    assert len(shown) == 6
    assert [(picture == 255).all() for picture in shown] == [False] * 5 + [True]


def test_the_same_video_gives_the_same_bytes() -> None:
    main(["render", "fear", *SHORT, "--size", "160x96", "-o", "a.webm", "--quiet"])
    for folder in ("one", "two"):
        assert main(["figures", "contact-sheet", "a.webm", "-o", folder, "--format", "pdf", "--quiet"]) == 0
    assert Path("one/a-contact-sheet.pdf").read_bytes() == Path("two/a-contact-sheet.pdf").read_bytes()


def test_pictures_of_a_very_tall_video_are_narrow() -> None:
    assert main(["render", "fear", *SHORT, "--size", "64x4096", "-o", "tall.mp4", "--quiet"]) == 0
    for source, keys in (("tall.mp4", []), ("fear", [*SHORT, "--set", "video.size=64x4096"])):
        assert main(["figures", "contact-sheet", source, *keys, "--count", "4", "--format", "png", "--quiet"]) == 0
        with Image.open(f"figures/{Path(source).stem}-contact-sheet.png") as page:
            assert page.height < page.width == 2148  # four in a row, each as high as three are wide


EXPECTED = "expected one video file, scene (.yaml), finished run (.npz) or emotion"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], f"contact-sheet: {EXPECTED}"),
        (["a.mp4", "b.mp4"], f"contact-sheet: {EXPECTED}"),
        (["none.mp4"], "none.mp4: cannot be read: no such file or directory"),
        (["folder.mp4"], f"folder.mp4: is a folder; {EXPECTED}"),
        (["folder"], f"folder: is a folder; {EXPECTED}"),
        (["text.mp4"], "text.mp4: cannot be read as a video"),
        (["feer"], "feer: no such file or emotion (did you mean fear?)"),
        (["small.gif", "--times", "0,3"], "--times 0,3: 3 s is outside the run of 0 to 0.1 s"),
        (["small.gif", "--times", "0", "--count", "2"], "--times and --count: expected one of them"),
        (["small.gif", "--set", "seed=3"], "--set seed=3: small.gif is a video; only scenes have keys to replace"),
        (["small.gif", "--seed", "3"], "--seed 3: small.gif is a video; only scenes have keys to replace"),
        (["fear", "--times", "0,16"], "--times 0,16: 16 s is outside the run of 0 to 15 s"),
        (
            ["fear", "--count", "101"],
            "--count 101: expected a whole number, at least 1 and at most 100 (did you mean 100?)",
        ),
    ],
)
def test_invalid_input_gives_one_line_and_writes_no_file(capsys, arguments, message) -> None:
    Path("folder.mp4").mkdir()
    Path("folder").mkdir()
    Path("text.mp4").write_text("no video")
    Image.new("L", (64, 64)).save("small.gif")
    assert main(["figures", "contact-sheet", *arguments]) == 2
    assert capsys.readouterr().err == message + "\n"
    assert not Path("figures").exists()


def test_emotion_name_takes_precedence_over_a_folder_of_that_name() -> None:
    Path("fear").mkdir()  # such as an image sequence rendered in this folder
    assert main(["figures", "contact-sheet", "fear", *SHORT, "--format", "png", "--quiet"]) == 0
    assert Path("figures/fear-contact-sheet.png").exists()
