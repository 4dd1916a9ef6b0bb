"""The key: whether it fits the videos, and the commitment to it."""

from collections.abc import Iterator
from pathlib import Path

from emovid.kit.checks.finding import Finding
from emovid.kit.read import Kit
from emovid.kit.seeded_random import commitment


def check_key(kit: Kit, key: Path | None) -> Iterator[Finding]:
    """Check that the key, with the salt beside it, is the one committed to, and that it knows every video."""
    file = key or kit.folder.key
    salt = file.with_name(kit.folder.salt.name)
    if not file.is_file():
        return
    if not salt.is_file():
        yield Finding("key", str(salt), "missing: without it nobody can check the key's commitment")
    elif commitment(salt.read_bytes(), file.read_bytes()) != kit.manifest.key_commitment:
        yield Finding("key", str(file), "not the key that the manifest commits to")
    if set(kit.key) != set(kit.manifest.codes):
        yield Finding("key", str(file), "does not have the codes of the manifest")
