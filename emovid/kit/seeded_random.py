"""What is drawn from a kit's private seed: the same for the same seed, on every machine and with every version.

Everything is a keyed hash (HMAC-SHA256) of what it is for. Without the seed nothing of it can be told from chance; with
it, all of it can be checked by other means than this program.
"""

import hashlib
import hmac
import secrets
from collections.abc import Sequence
from typing import TypeVar

Item = TypeVar("Item")

GUESSABLE = 2**64  # a smaller seed can be found by trying

# No vowels, so that no words arise; no 0, o, 1, i, l, 5, s, 2, z, which are taken for each other. A letter comes first:
# survey tools want names of questions to begin with one.
_LETTERS = "bcdfghjkmnpqrtvwx"
_MARKS = _LETTERS + "346789"
_LENGTH = 6


def fresh_seed() -> int:
    """Return a seed that nobody can guess."""
    return secrets.randbits(256)


def draw(seed: int, *purpose: object) -> int:
    """Return a whole number from 0 to 2^256 - 1 for a purpose."""
    return int.from_bytes(_digest(seed, *purpose))


def share(seed: int, *purpose: object) -> float:
    """Return a number from 0 to below 1 for a purpose."""
    return (draw(seed, *purpose) >> 203) / 2**53


def flip(seed: int, *purpose: object) -> bool:
    """Return the toss of a coin for a purpose."""
    return draw(seed, *purpose) % 2 == 1


def shuffled(items: Sequence[Item], seed: int, *purpose: object) -> list[Item]:
    """Return the items in an order for a purpose, each order as likely as the others."""
    places = sorted(range(len(items)), key=lambda i: _digest(seed, *purpose, i))
    return [items[i] for i in places]


def salt(seed: int) -> str:
    """Return what makes a commitment to the key say nothing of the key, in hexadecimal."""
    return _digest(seed, "salt").hex()


def commitment(salt_text: bytes, key_text: bytes) -> str:
    """Return the SHA-256 of the salt's file followed by the key's, as in ``cat salt.txt key.csv | sha256sum``."""
    return hashlib.sha256(salt_text + key_text).hexdigest()


def video_codes(seed: int, count: int) -> list[str]:
    """Return codes of six marks, all different."""
    found: dict[str, None] = {}
    attempt = 0
    while len(found) < count:
        found[_code(draw(seed, "code", attempt))] = None
        attempt += 1
    return list(found)


def is_code(text: str) -> bool:
    """Return whether a text could be one of our codes."""
    return len(text) == _LENGTH and text[0] in _LETTERS and set(text) <= set(_MARKS)


def _code(number: int) -> str:
    number, first = divmod(number, len(_LETTERS))
    marks = [_LETTERS[first]]
    for _ in range(_LENGTH - 1):
        number, place = divmod(number, len(_MARKS))
        marks.append(_MARKS[place])
    return "".join(marks)


def _digest(seed: int, *purpose: object) -> bytes:
    text = "/".join(map(str, purpose))
    return hmac.digest(str(seed).encode(), f"emovid kit/{text}".encode(), "sha256")
