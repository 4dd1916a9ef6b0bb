"""What lets a participant in, and what shows that a form is from one of our pages."""

import hashlib
import hmac
import secrets

# No vowels, so that no words arise, and no marks that are taken for each other.
_MARKS = "23456789bcdfghjkmnpqrstvwxyz"
_LENGTH, _GROUP = 24, 4  # 28^24 is 2^115


def fresh_code() -> str:
    """Return a participant's code, which nobody can guess: 115 bits."""
    return "".join(secrets.choice(_MARKS) for _ in range(_LENGTH))


def readable(code: str) -> str:
    """Return a code in groups of four, to be copied."""
    return "-".join(code[i : i + _GROUP] for i in range(0, len(code), _GROUP))


def normal(text: str) -> str:
    """Return a code as it was drawn from how somebody wrote it, "" if it cannot be one."""
    code = "".join(text[: 4 * _LENGTH].split()).replace("-", "").lower()
    return code if len(code) == _LENGTH and set(code) <= set(_MARKS) else ""


def digest(code: str) -> str:
    """Return what is stored of a code: who reads the database cannot come in with it."""
    return hashlib.sha256(f"emovid survey/{code}".encode()).hexdigest()


def form_token(secret: bytes, code: str) -> str:
    """Return what a form must bring along: nobody else's page can know it."""
    return hmac.digest(secret, code.encode(), "sha256").hex()


def is_form_token(given: str, secret: bytes, code: str) -> bool:
    """Return whether a form brought the right token, in a time that does not tell how much of it is right."""
    return hmac.compare_digest(given.encode(), form_token(secret, code).encode())
