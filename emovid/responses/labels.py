"""Labels: the answers that participants can give, and the texts that count as each of them."""

import re
import unicodedata
from collections.abc import Mapping, Sequence
from functools import lru_cache

from emovid.errors import SourceError, quoted
from emovid.responses.responses import EMOTIONS

NONE = "none"
FEWEST, MOST = 2, 12

# Words for one feeling: nouns, adjectives, and synonyms in surveys. The word that is a label represents the others.
_FEELINGS = (
    ("happiness", "happy", "joy", "joyful", "joyous", "glad", "cheerful"),
    ("surprise", "surprised", "astonished", "astonishment"),
    ("anger", "angry", "angered", "furious"),
    ("fear", "fearful", "afraid", "scared", "frightened", "terrified"),
    ("disgust", "disgusted"),
    ("sadness", "sad", "unhappy", "sorrow"),
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
# Codes of a missing answer: R, pandas, MATLAB, SPSS, SAS, experiments that time out.
_MISSING = frozenset(
    (
        "na",
        "n a",
        "nan",
        "null",
        "missing",
        "timeout",
        "time out",
        "timed out",
        "no response",
        "no answer",
        "not answered",
    )
)
_MISSING_NUMBER = re.compile(r"-(9|99|999|66|77)")


class Labels:
    """The answers that participants can give.

    Attributes:
        signalled: labels of videos.
        offers_none: whether "none of these" is among the labels.
    """

    def __init__(self, names: Sequence[str] = EMOTIONS, answers: Mapping[str, str | None] | None = None) -> None:
        """Take the labels in order, and the label of each text in `answers` (None for a missing answer).

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
                "answers", f"{quoted(label)} is not a label; expected {', '.join(self.signalled)} or none", 0, word
            )
        return found

    def find(self, text: str) -> str | None:
        """Return the label of an answer, "" for a missing answer, None for any other text."""
        given = self._answers.get(_key(text))
        if given is not None:
            return given
        word = plain(text)
        if word in self._words:
            return self._words[word]
        if not word or word in _MISSING or _MISSING_NUMBER.fullmatch(number(text)):
            return ""
        meant = {self._words.get(part) for part in word.split() if not part.isdigit()}
        return meant.pop() if len(meant) == 1 else None

    def is_label(self, text: str) -> bool:
        """Return whether a text counts as one of the labels."""
        return bool(self.find(text))

    def is_declared(self, text: str) -> bool:
        """Return whether the map declares the label of a text."""
        return _key(text) in self._answers

    def words(self) -> Mapping[str, str]:
        """Return the label of each known word, words as in `plain`."""
        return self._words


@lru_cache(maxsize=10_000)
def plain(text: str) -> str:
    """Return text in lower case, with one space instead of each run of characters other than letters and digits."""
    folded = unicodedata.normalize("NFKC", text).casefold()
    return " ".join(re.sub(r"[\W_]+", " ", folded).split())


def number(text: str) -> str:
    """Return a whole number without its decimals (LimeSurvey's 24.0000000000 as 24), any other text stripped.

    Three zeros after a comma are thousands.
    """
    found = re.fullmatch(r"\s*([+-]?\d{1,15})(?:\.0+|,0{1,2}|,0{4,})\s*", text)
    return found[1] if found else text.strip()


def _key(text: str) -> str:
    """Return the form in which answers of a map are compared: `plain`, except for signs and signed numbers."""
    text = number(text)
    return text if re.fullmatch(r"\W*|[+-]\d+", text) else plain(text)


def _canonical(name: str) -> str:
    """Return a label as tables show it: the six emotions in lower case, others as given."""
    return plain(name) if plain(name) in EMOTIONS else " ".join(name.split())


def _words(names: Sequence[str]) -> dict[str, str]:
    words = dict.fromkeys(_NONE_OF_THESE, NONE)
    for feeling in _FEELINGS:
        labels = [name for name in names if plain(name) in feeling]
        if len(labels) == 1:  # where "joy" and "happiness" are two labels, neither represents "happy"
            words |= dict.fromkeys(feeling, labels[0])
    return words | {plain(name): name for name in names}


def _check(names: Sequence[str]) -> None:
    if not FEWEST <= len(names) <= MOST:
        raise SourceError("labels", f"{len(names)} given; expected {FEWEST} to {MOST}")
    words = [plain(name) for name in names]
    for name, word in zip(names, words, strict=True):
        if not word or words.count(word) > 1:
            raise SourceError("labels", f"{quoted(name)} is {'given twice' if word else 'not a word'}; expected words")
