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


def site_name(secret: bytes) -> str:
    """Return five characters that tell the participants of one database from those of every other one."""
    number = int.from_bytes(hashlib.sha256(b"emovid site/" + secret).digest())
    return "".join(_ALPHABET[number // len(_ALPHABET) ** i % len(_ALPHABET)] for i in range(5))


def form_token(secret: bytes, code: str) -> str:
    """Return the token that every form must send; pages of other sites cannot know it."""
    return hmac.digest(secret, code.encode(), "sha256").hex()


def is_form_token(given: str, secret: bytes, code: str) -> bool:
    """Return whether a form sent the right token; the comparison takes the same time for every wrong one."""
    return hmac.compare_digest(given.encode(), form_token(secret, code).encode())
