"""Names, times and rights of a kit's files."""

import stat
from collections.abc import Iterator

from emovid.kit.checks.finding import Finding
from emovid.kit.checks.hints import Hints
from emovid.kit.read import Kit
from emovid.kit.seeded_random import is_code

_OTHER_TIME = "has another time than the other files; copy a kit with cp -a, or build it again with its seed"


def check_files(kit: Kit) -> Iterator[Finding]:
    """Check that the public folder holds the manifest and the videos it lists, and nothing else."""
    public = kit.folder.public
    expected = {kit.folder.manifest, kit.folder.videos, *(public / video.file for video in kit.manifest.videos)}
    for path in sorted(public.rglob("*")):
        where = str(path.relative_to(kit.folder.path))
        if path.is_symlink():
            yield Finding("files", where, "a link: where it leads could be seen")
        elif path not in expected:
            yield Finding("files", where, "not of the kit")
    for path in sorted(expected):
        if not path.exists():
            yield Finding("files", str(path.relative_to(kit.folder.path)), "missing")


def check_names(kit: Kit, hints: Hints) -> Iterator[Finding]:
    """Check that no public file, folder or code is called by an emotion, and that codes are random ones."""
    for path in sorted(kit.folder.public.rglob("*")):
        if named := hints.in_text(path.name):
            yield Finding("names", str(path.relative_to(kit.folder.path)), "names an emotion", tuple(sorted(named)))
    for code in kit.manifest.codes:
        if not is_code(code):
            yield Finding("names", code, "not one of emovid's random codes")
    if kit.manifest.codes != sorted(kit.manifest.codes):
        yield Finding("names", "public/manifest.json", "lists the videos in another order than that of their codes")


def check_times(kit: Kit) -> Iterator[Finding]:
    """Check that all public files and folders have one and the same time."""
    paths = [kit.folder.public, *sorted(kit.folder.public.rglob("*"))]
    times = {path: path.stat().st_mtime_ns for path in paths if path.exists()}
    usual = max(set(times.values()), key=list(times.values()).count)
    for path, time in times.items():
        if time != usual:
            yield Finding("times", str(path.relative_to(kit.folder.path)), _OTHER_TIME)


def check_rights(kit: Kit) -> Iterator[Finding]:
    """Check that only the owner can read what is private."""
    if not kit.folder.private.is_dir():
        return
    for path in [kit.folder.private, *sorted(kit.folder.private.iterdir())]:
        mode = stat.S_IMODE(path.stat().st_mode)
        if mode & 0o077:
            yield Finding("rights", str(path.relative_to(kit.folder.path)), f"can be read by others: mode {mode:04o}")
