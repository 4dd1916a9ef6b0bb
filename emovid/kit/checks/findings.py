"""Findings of an audit, and the words that reveal an emotion."""

import re
from collections.abc import Iterable
from typing import NamedTuple

from emovid.kit.folder import Kit
from emovid.responses.labels import NONE, Labels, plain
from emovid.scene.emotions import EMOTIONS

_WHOLE_WORDS = 4  # shorter words than this are searched only as complete words: "sad" is in "crusade"


class Finding(NamedTuple):
    """Something that could reveal an emotion, or a defect of the kit.

    Attributes:
        check: name of the check.
        where: a file, or a part of one.
        message: the defect, without emotions, so that the auditor can stay blind.
        emotions: the emotions that it reveals.
    """

    check: str
    where: str
    message: str
    emotions: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.check}: {self.where}: {self.message}"

    @property
    def unblinded(self) -> str:
        """The finding with the emotions that it reveals."""
        return f"{self}: {', '.join(self.emotions)}" if self.emotions else str(self)


class Hints:
    """Finds emotions in text: labels, their texts, synonyms, and names of scenes.

    Args:
        kit: the kit with labels, texts and scenes.
    """

    def __init__(self, kit: Kit) -> None:
        words = dict(Labels(kit.labels).words())
        words |= {plain(answer.text): answer.label for answer in kit.manifest.choices.labels}
        words |= {name: name for name in EMOTIONS if name not in words}
        for stimulus in kit.study.stimuli if kit.study else ():
            name = plain((stimulus.scene or stimulus.video or "").rsplit("/", 1)[-1].rsplit(".", 1)[0])
            words.setdefault(name, stimulus.emotion or name)
        # A number, as in 3.mp4, reveals nothing: positions and sizes are numbers too.
        self._words = {word: label for word, label in words.items() if label != NONE and re.search(r"[^\W\d]", word)}
        self.labels = frozenset(kit.labels)

    def in_text(self, text: str) -> set[str]:
        """Return the emotions that a text names."""
        letters = plain(text)
        words = set(letters.split())
        long = {label for word, label in self._words.items() if len(word) >= _WHOLE_WORDS and word in letters}
        return long | {label for word, label in self._words.items() if word in words}

    def in_bytes(self, data: bytes) -> set[str]:
        """Return the emotions that the readable parts of some bytes name."""
        return self.in_texts(run.decode() for run in re.findall(rb"[ -~]{3,}", data))

    def in_texts(self, texts: Iterable[str]) -> set[str]:
        """Return the emotions that any of the texts names."""
        return {label for text in texts for label in self.in_text(text)}
