"""A study of six very small videos, for the survey's tests."""

from pathlib import Path

from emovid.kit.build import build
from emovid.kit.load import load_study

STUDY = """\
title: Small robots
question: Which emotion best described the movement of the robots in the video?
labels: {happiness: Happiness, surprise: Surprise, anger: Anger, fear: Fear, disgust: Disgust, sadness: Sadness}
stimuli: [{scene: happiness}, {scene: surprise}, {scene: anger}, {scene: fear}, {scene: disgust}, {scene: sadness}]
set: {robots: 6}
choices: random
video: {size: 96x64, fps: 5, duration: 1}
demographics:
  - {name: gender, question: "What is your gender?", choices: [Woman, Man, Another gender]}
  - {name: country, question: "Where do you live?", required: false}
consent: {text: You can stop at any time., version: "1"}
instructions: Watch each video to its end.
thanks: {text: Thank you., code: C0MPLETE, link: "https://example.org/back?study=1&done=yes"}
"""
# Parts that a study may have besides.
PARTS = """\
practice: {scene: happiness}
checks:
  - {name: shape, scene: sadness, question: "Which shape?", choices: [Circle, Star], answer: Circle, after: 3}
questions_after:
  - {name: comments, question: "Comments?", long: true, required: false}
  - {name: age, question: "Age?", number: {low: 18, high: 99}}
  - {name: tools, question: "Tools?", choices: [A, B, C], several: true, required: false}
debriefing: This was about motion.
"""
LABELS = ("happiness", "surprise", "anger", "fear", "disgust", "sadness")


class _Silent:
    def advanced(self, frames: int) -> None:
        pass

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        pass


def small_kit(folder: Path, text: str = STUDY, participants: int = 12, seed: int = 2**80 + 7) -> Path:
    """Build the kit of a study, and return where it is."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.yaml").write_text(text)
    build(load_study(folder / "study.yaml"), folder / "kit", participants, seed, _Silent())
    return folder / "kit"
