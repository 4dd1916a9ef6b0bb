"""Which of the labels an answer means, however it is spelled."""

import re
import unicodedata
from collections.abc import Mapping, Sequence

from emovid.errors import SourceError, quoted
from emovid.responses.responses import EMOTIONS

NONE = "none"
FEWEST, MOST = 2, 12

# Words for one feeling: nouns, adjectives, what surveys call them. The one that is a label stands for the rest.
_FEELINGS = (
    ("happiness", "happy", "joy", "joyful"),
    ("surprise", "surprised"),
    ("anger", "angry"),
    ("fear", "fearful", "afraid", "scared", "frightened"),
    ("disgust", "disgusted"),
    ("sadness", "sad"),
    ("contempt", "contemptuous"),
    ("neutral", "neutrality"),
    ("calm", "calmness"),
    ("excitement", "excited"),
    ("boredom", "bored"),
    ("amusement", "amused"),
    ("pride", "proud"),
    ("shame", "ashamed"),
    ("guilt", "guilty"),
    ("anxiety", "anxious"),
    ("relief", "relieved"),
)
_NONE_OF_THESE = (NONE, "none of these", "none of the above", "none of them", "none of these emotions", "no emotion")


class Labels:
    """The answers that participants may give.

    Attributes:
        signalled: the labels that videos may stand for.
        offers_none: whether "none of these" is named among the labels.
    """

    def __init__(self, names: Sequence[str] = EMOTIONS, answers: Mapping[str, str | None] | None = None) -> None:
        """Take the labels in order, and words in `answers` for some of them (None: counts as no answer).

        Raises:
            SourceError: unless there are 2 to 12 different labels.
        """
        cleaned = [_canonical(name) for name in names]
        self.offers_none = any(plain(name) in _NONE_OF_THESE for name in cleaned)
        self.signalled = tuple(name for name in cleaned if plain(name) not in _NONE_OF_THESE)
        _check(self.signalled)
        self._words = _words(self.signalled)
        self._answers: dict[str, str] = {}
        for word, label in (answers or {}).items():
            self._answers[_key(word)] = "" if label is None else self._meant(word, label)

    def _meant(self, word: str, label: str) -> str:
        found = self.find(label)
        if not found:
            raise SourceError(
                "answers", f"{quoted(label)} is no label; expected {', '.join(self.signalled)} or none", 0, word
            )
        return found

    def find(self, text: str) -> str | None:
        """Return the label that an answer means, "" for an answer that counts as missing, None if it is no label."""
        given = self._answers.get(_key(text))
        if given is not None:
            return given
        word = plain(text)
        if word in self._words or not word:
            return self._words.get(word, "")
        meant = {self._words.get(part) for part in word.split() if not part.isdigit()}
        return meant.pop() if len(meant) == 1 else None

    def is_label(self, text: str) -> bool:
        """Return whether a cell holds one of the labels."""
        return bool(self.find(text))

    def words(self) -> Mapping[str, str]:
        """Return the label that each known word stands for, words as in `plain`."""
        return self._words


def plain(text: str) -> str:
    """Return text in lower case, with one space for each run of other marks than letters and digits."""
    folded = unicodedata.normalize("NFKC", text).casefold()
    return " ".join(re.sub(r"[\W_]+", " ", folded).split())


def number(text: str) -> str:
    """Return a whole number without its decimals (LimeSurvey's 24.0000000000 as 24), any other text stripped.

    After a comma three zeros are thousands.
    """
    found = re.fullmatch(r"\s*([+-]?\d{1,15})(?:\.0+|,0{1,2}|,0{4,})\s*", text)
    return found[1] if found else text.strip()


def _key(text: str) -> str:
    """Return what answers of a map are compared by: `plain`, but where nothing remains of it, as in "+" or "-1"."""
    text = number(text)
    return text if re.fullmatch(r"\W*|[+-]\d+", text) else plain(text)


def _canonical(name: str) -> str:
    """Return a label as it is written in tables: the six emotions as everywhere, others as given."""
    return plain(name) if plain(name) in EMOTIONS else " ".join(name.split())


def _words(names: Sequence[str]) -> dict[str, str]:
    words = dict.fromkeys(_NONE_OF_THESE, NONE)
    for feeling in _FEELINGS:
        labels = [name for name in names if plain(name) in feeling]
        if len(labels) == 1:  # where "joy" and "happiness" are two labels, neither stands for "happy"
            words |= dict.fromkeys(feeling, labels[0])
    return words | {plain(name): name for name in names}


def _check(names: Sequence[str]) -> None:
    if not FEWEST <= len(names) <= MOST:
        raise SourceError("labels", f"{len(names)} given; expected {FEWEST} to {MOST}")
    words = [plain(name) for name in names]
    for name, word in zip(names, words, strict=True):
        if not word or words.count(word) > 1:
            raise SourceError("labels", f"{quoted(name)} is {'given twice' if word else 'no word'}; expected words")
