"""A study of six very small videos, for tests."""

import struct
from pathlib import Path
from unittest.mock import patch

from emovid.kit.build import Built, build
from emovid.kit.folder import Kit, open_kit
from emovid.kit.load import load_study

LABELS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")
SEED = 2**80 + 7

STUDY = """\
title: Small robots
question: Which emotion best described the movement of the robots in the video?
labels: {happiness: Happiness, surprise: Surprise, anger: Anger, fear: Fear, disgust: Disgust, sadness: Sadness}
stimuli:
  - scene: happiness
  - scene: surprise
  - scene: anger
  - scene: fear
  - scene: disgust
  - scene: sadness
set: {robots: 6}
video: {size: 160x90, fps: 10, duration: 1}
demographics:
  - {name: gender, question: "What is your gender?", choices: [Woman, Man, Another gender]}
consent: {text: You can stop at any time., version: "1"}
instructions: Watch each video to its end.
thanks: {text: Thank you.}
"""


class Silent:
    """A reporter that keeps its reports."""

    def __init__(self) -> None:
        self.made: list[str] = []
        self.kept: list[str] = []

    def advanced(self, frames: int) -> None:
        pass

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        (self.made if made else self.kept).append(video.stem)


def write_study(folder: Path, text: str = STUDY) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.yaml").write_text(text)
    return folder


def make_kit(folder: Path, text: str = STUDY, participants: int = 12, seed: int | None = SEED, **how) -> Built:
    """Build a kit at `folder`/kit of the study at `folder`/study."""
    loaded = load_study(write_study(folder / "study", text))
    return build(loaded, folder / "kit", participants, seed, how.pop("report", Silent()), **how)


def make_kit_of_placeholders(folder: Path, text: str = STUDY, participants: int = 12, seed: int = SEED) -> Kit:
    """Build a kit as `make_kit` does, whose videos are MP4 boxes with the code of the video, and open it."""

    def write(stimulus, look, target, seed, on_frame) -> None:
        content = stimulus.code.encode()
        target.write_bytes(struct.pack(">I4s", 8 + len(content), b"mdat") + content)

    with patch("emovid.kit.build.make", write):
        make_kit(folder, text, participants, seed)
    return open_kit(folder / "kit")
