"""Participants' codes, which let them in, and the tokens that show that a form comes from one of our pages."""

import hashlib
import hmac
import secrets

# No vowels, so that no words appear, and no characters that people confuse with each other.
_ALPHABET = "23456789bcdfghjkmnpqrstvwxyz"
_LENGTH, _GROUP = 24, 4  # 28^24 is 2^115


def fresh_code() -> str:
    """Return a new participant code; its 115 random bits cannot be guessed."""
    return "".join(secrets.choice(_ALPHABET) for _ in range(_LENGTH))


def readable(code: str) -> str:
    """Return a code in groups of four characters, easy to copy."""
    return "-".join(code[i : i + _GROUP] for i in range(0, len(code), _GROUP))


def normalized(text: str) -> str:
    """Return the code that somebody typed, without spaces, hyphens and capitals; "" if it is not a code."""
    code = "".join(text[: 4 * _LENGTH].split()).replace("-", "").lower()
    return code if len(code) == _LENGTH and set(code) <= set(_ALPHABET) else ""


def digest(code: str) -> str:
    """Return the digest that the database stores: a reader of the database cannot log in with it."""
    return hashlib.sha256(f"emovid survey/{code}".encode()).hexdigest()


def recruit_digest(code: str) -> str:
    """Return the digest of a participant among recruits; only the code itself leads to both digests."""
    return hashlib.sha256(f"emovid recruit/{code}".encode()).hexdigest()


def status_token(secret: bytes) -> str:
    """Return the token of the page for researchers."""
    return readable(_letters(hmac.digest(secret, b"status", "sha256"), _LENGTH))


def is_status_token(given: str, secret: bytes) -> bool:
    """Return whether somebody gave the token of the page for researchers."""
    return hmac.compare_digest(normalized(given).encode(), normalized(status_token(secret)).encode())


def site_name(secret: bytes) -> str:
    """Return five characters that distinguish the participants of one database from those of others."""
    return _letters(hashlib.sha256(b"emovid site/" + secret).digest(), 5)


def _letters(data: bytes, length: int) -> str:
    number = int.from_bytes(data)
    return "".join(_ALPHABET[number // len(_ALPHABET) ** i % len(_ALPHABET)] for i in range(length))


def form_token(secret: bytes, code: str) -> str:
    """Return the token that every form must send; pages of other sites cannot know it."""
    return hmac.digest(secret, code.encode(), "sha256").hex()


def is_form_token(given: str, secret: bytes, code: str) -> bool:
    """Return whether a form sent the right token; the comparison takes the same time for every wrong one."""
    return hmac.compare_digest(given.encode(), form_token(secret, code).encode())
