"""Random numbers from the private seed of a kit: the same on every machine and in every version.

Each is a keyed hash (HMAC-SHA256) of its purpose. Without the seed they cannot be distinguished from chance; with it,
any program can check them.
"""

import hashlib
import hmac
import secrets
from collections.abc import Sequence
from typing import TypeVar

Element = TypeVar("Element")

GUESSABLE = 2**64  # a smaller seed can be found by trial

# No vowels, to avoid words; none of 0, o, 1, i, l, 5, s, 2, z, which are easily confused. A letter comes first, because
# survey tools require it of the names of questions.
_LETTERS = "bcdfghjkmnpqrtvwx"
_CHARACTERS = _LETTERS + "346789"
_LENGTH = 6


def fresh_seed() -> int:
    """Return a new seed of 256 random bits."""
    return secrets.randbits(256)


def draw(seed: int, *purpose: object) -> int:
    """Return an integer from 0 to 2^256 - 1 for a purpose."""
    return int.from_bytes(_digest(seed, *purpose))


def share(seed: int, *purpose: object) -> float:
    """Return a number in [0, 1) for a purpose."""
    return (draw(seed, *purpose) >> 203) / 2**53


def flip(seed: int, *purpose: object) -> bool:
    """Return a fair coin toss for a purpose."""
    return draw(seed, *purpose) % 2 == 1


def shuffled(items: Sequence[Element], seed: int, *purpose: object) -> list[Element]:
    """Return the items in random order for a purpose, all orders equally likely."""
    places = sorted(range(len(items)), key=lambda i: _digest(seed, *purpose, i))
    return [items[i] for i in places]


def salt(seed: int) -> str:
    """Return the salt of the commitment to the key, in hexadecimal."""
    return _digest(seed, "salt").hex()


def commitment(salt_text: bytes, key_text: bytes) -> str:
    """Return the SHA-256 of both files, as ``cat salt.txt key.csv | sha256sum`` does."""
    return hashlib.sha256(salt_text + key_text).hexdigest()


def video_codes(seed: int, count: int) -> list[str]:
    """Return different codes of six characters."""
    found: dict[str, None] = {}
    attempt = 0
    while len(found) < count:
        found[_code(draw(seed, "code", attempt))] = None
        attempt += 1
    return list(found)


def is_code(text: str) -> bool:
    """Return whether a text has the form of a code."""
    return len(text) == _LENGTH and text[0] in _LETTERS and set(text) <= set(_CHARACTERS)


def _code(number: int) -> str:
    number, first = divmod(number, len(_LETTERS))
    characters = [_LETTERS[first]]
    for _ in range(_LENGTH - 1):
        number, place = divmod(number, len(_CHARACTERS))
        characters.append(_CHARACTERS[place])
    return "".join(characters)


def _digest(seed: int, *purpose: object) -> bytes:
    text = "/".join(map(str, purpose))
    return hmac.digest(str(seed).encode(), f"emovid kit/{text}".encode(), "sha256")
