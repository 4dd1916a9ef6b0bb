"""Checks of a kit's files: names, times, permissions, and the key."""

import stat
from collections.abc import Iterator
from pathlib import Path

from emovid.kit.checks.findings import Finding, Hints
from emovid.kit.folder import Kit
from emovid.kit.seeded_random import commitment, is_code

_OTHER_TIME = "has another time than the other files; copy the kit with cp -a, or build it again with its seed"


def check_files(kit: Kit) -> Iterator[Finding]:
    """Check that the public folder holds only the manifest and the videos that it lists."""
    public = kit.folder.public
    expected = {
        kit.folder.manifest,
        kit.folder.videos,
        *(public / video.file for video in kit.manifest.all_videos.values()),
    }
    for path in sorted(public.rglob("*")):
        where = kit.folder.inside(path)
        if path.is_symlink():
            yield Finding("files", where, "a link: its target is visible")
        elif path not in expected:
            yield Finding("files", where, "not part of the kit")
    for path in sorted(expected):
        if not path.exists():
            yield Finding("files", kit.folder.inside(path), "missing")


def check_names(kit: Kit, hints: Hints) -> Iterator[Finding]:
    """Check that no public file, folder or code is named after an emotion, and that codes are random."""
    for path in sorted(kit.folder.public.rglob("*")):
        if named := hints.in_text(path.name):
            yield Finding("names", kit.folder.inside(path), "names an emotion", tuple(sorted(named)))
    for code in kit.manifest.codes:
        if not is_code(code):
            yield Finding("names", code, "not a random code of emovid")
    if kit.manifest.codes != sorted(kit.manifest.codes):
        yield Finding("names", "public/manifest.json", "lists the videos in another order than their codes")


def check_times(kit: Kit) -> Iterator[Finding]:
    """Check that all public files and folders have the same modification time."""
    paths = [kit.folder.public, *sorted(kit.folder.public.rglob("*"))]
    times = {path: path.stat().st_mtime_ns for path in paths if path.exists()}
    usual = max(set(times.values()), key=list(times.values()).count)
    for path, time in times.items():
        if time != usual:
            yield Finding("times", kit.folder.inside(path), _OTHER_TIME)


def check_permissions(kit: Kit) -> Iterator[Finding]:
    """Check that only the owner can read private files."""
    if not kit.folder.private.is_dir():
        return
    for path in [kit.folder.private, *sorted(kit.folder.private.iterdir())]:
        mode = stat.S_IMODE(path.stat().st_mode)
        if mode & 0o077:
            yield Finding("permissions", kit.folder.inside(path), f"others can read it: mode {mode:04o}")


def check_key(kit: Kit, key: Path | None) -> Iterator[Finding]:
    """Check that the key, with the salt beside it, matches the commitment, and that it lists every video."""
    file = key or kit.folder.key
    salt = file.with_name(kit.folder.salt.name)
    if not file.is_file():
        return
    if not salt.is_file():
        yield Finding("key", str(salt), "missing: the commitment to the key cannot be checked without it")
    elif commitment(salt.read_bytes(), file.read_bytes()) != kit.manifest.key_commitment:
        yield Finding("key", str(file), "not the key to which the manifest commits")
    if set(kit.key) != set(kit.manifest.codes):
        yield Finding("key", str(file), "does not have the codes of the manifest")
