"""Words that tell an emotion: labels, their texts, other words for the feeling, names of scenes."""

import re
from collections.abc import Iterable

from emovid.kit.read import Kit
from emovid.responses.labels import NONE, Labels, plain
from emovid.scene.emotions import EMOTIONS

_WHOLE_WORDS = 4  # letters below which a hint counts as a word of its own alone: "sad" is in "crusade"


class Hints:
    """Finds emotions in text.

    Args:
        kit: whose labels, texts and scenes are looked for.
    """

    def __init__(self, kit: Kit) -> None:
        words = dict(Labels(kit.labels).words())
        words |= {plain(answer.text): answer.label for answer in kit.manifest.choices.labels}
        words |= {name: name for name in EMOTIONS if name not in words}
        for stimulus in kit.study.stimuli if kit.study else ():
            name = plain((stimulus.scene or stimulus.video or "").rsplit("/", 1)[-1].rsplit(".", 1)[0])
            words.setdefault(name, stimulus.emotion or name)
        # A number, as of 3.mp4, tells nothing: places and sizes are numbers, too.
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
