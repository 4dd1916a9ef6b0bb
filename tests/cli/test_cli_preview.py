import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from emovid.cli.main import main

# A test run in the background may ignore SIGINT, and child processes inherit that.
LISTENING = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from emovid.cli.main import run; run()"
)
SHORT = ["--set", "duration=1"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def names() -> list[str]:
    return sorted(str(path) for path in Path().rglob("*") if path.is_file())


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], "previews/fear.gif"),
        (["--format", "webm"], "previews/fear.webm"),
        (["--format", "png"], "previews/fear.png"),
        (["-o", "x.mp4"], "x.mp4"),
        (["-o", "a/b", "--format", "mp4"], "a/b/fear.mp4"),
    ],
)
def test_preview_is_written_only_to_the_reported_path(capsys, arguments, expected) -> None:
    assert main(["preview", "--emotion", "fear", *SHORT, *arguments]) == 0
    assert capsys.readouterr().err.startswith(f"{expected}: 1 s, made in ")
    assert names() == [expected]


def test_output_suffix_that_contradicts_the_format_is_refused(tmp_path, capsys) -> None:
    assert main(["preview", "fear", *SHORT, "-o", "x.gif", "--format", "png"]) == 2
    assert capsys.readouterr().err == "-o x.gif: cannot write .gif; expected .png, or a folder\n"
    assert list(tmp_path.iterdir()) == []


def test_gif_preview_is_small_and_loops() -> None:
    assert main(["preview", "fear", *SHORT, "-o", "x.gif", "-q"]) == 0
    with Image.open("x.gif") as loop:
        assert (loop.size, loop.n_frames, loop.info["loop"]) == ((320, 180), 10, 0)


def test_a_contact_sheet_shows_the_start_and_the_end_of_a_run() -> None:
    settings = ["duration=4", "video.trails={robots: 5, seconds: null, fade: false}", "video.colours.trails=[theme]"]
    said = [word for setting in settings for word in ("--set", setting)]
    assert main(["preview", "happiness", *said, "-o", "x.png", "-q"]) == 0
    sheet = np.asarray(Image.open("x.png").convert("RGB"), dtype=int)
    top = int(np.flatnonzero((sheet != 255).any(axis=(1, 2)))[0])
    left = int(np.flatnonzero((sheet != 255).any(axis=(0, 2)))[0])
    pictures = [sheet[top : top + 180, left + i * 326 : left + i * 326 + 320] for i in range(3)]
    coloured = [int((np.ptp(picture, axis=2) > 60).sum()) for picture in pictures]  # pixels of trails
    assert coloured[0] < coloured[1] < coloured[2]


def test_unknown_format_gives_one_line_and_writes_no_file(capsys) -> None:
    assert main(["preview", "fear", "--format", "wemb"]) == 2
    assert capsys.readouterr().err == "--format wemb: expected one of gif, webm, mp4, png (did you mean webm?)\n"
    assert main(["preview", "fear", "-o", "x.avi"]) == 2
    assert (
        capsys.readouterr().err == "-o x.avi: cannot write .avi; expected .gif or .webm or .mp4 or .png, or a folder\n"
    )
    assert names() == []


class Watched:
    """`emovid preview my.yaml --watch` and its output."""

    def __init__(self) -> None:
        command = [sys.executable, "-u", "-c", LISTENING, "preview", "my.yaml", "--watch", "-o", "my.gif", *SHORT]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ | {"CI": "1"})

    def says(self) -> str:
        assert self.process.stderr
        return self.process.stderr.readline()


@pytest.fixture
def watched() -> Iterator[Watched]:
    main(["scene", "new", "my.yaml", "--from", "fear"])
    watched = Watched()
    yield watched
    watched.process.kill()
    watched.process.communicate()


def test_watching_continues_after_errors_until_interrupted(watched) -> None:
    scene = Path("my.yaml")
    good = scene.read_text()
    assert watched.says() == "watching my.yaml: Ctrl-C ends it\n"
    assert watched.says().startswith("my.gif: 1 s, made in ")
    first = Path("my.gif").read_bytes()

    scene.write_text(good.replace("robots: 15", "robots: many"))
    line = good[: good.index("robots: 15")].count("\n") + 1
    said = watched.says()
    assert said.startswith(f"my.yaml:{line}: robots: ")
    assert Path("my.gif").read_bytes() == first

    aside = Path("my.yaml~")  # as editors save
    aside.write_text(good.replace("robots: 15", "robots: 4"))
    scene.unlink()
    time.sleep(0.3)  # longer than the interval of checks for the file
    aside.rename(scene)
    assert watched.says().startswith("my.gif: 1 s, made in ")
    assert Path("my.gif").read_bytes() != first

    watched.process.send_signal(signal.SIGINT)
    assert watched.process.wait(30) == 130
    assert names() == ["emovid-scene.schema.json", "my.gif", "my.yaml"]


class _EnoughError(Exception):
    """An exception that ends watching, instead of Ctrl-C."""


def test_watching_can_be_quiet(monkeypatch, capsys) -> None:
    main(["scene", "new", "my.yaml", "--from", "fear", "--quiet"])

    def sleep(_: float) -> None:
        raise _EnoughError

    monkeypatch.setattr("emovid.workflows.preview.time", SimpleNamespace(perf_counter=time.perf_counter, sleep=sleep))
    with pytest.raises(_EnoughError):
        main(["preview", "my.yaml", *SHORT, "-o", "my.gif", "--watch", "--quiet"])
    assert names() == ["emovid-scene.schema.json", "my.gif", "my.yaml"]
    assert capsys.readouterr() == ("", "")


def test_watching_a_missing_file_ends_at_once(capsys) -> None:
    assert main(["preview", "no.yaml", "--watch"]) == 2
    assert capsys.readouterr().err == "no.yaml: no such file or emotion\n"
