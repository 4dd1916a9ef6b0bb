"""Checks of text that participants could see: the manifest, pages, preload lists, exported surveys."""

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from emovid.kit.checks.findings import Finding, Hints
from emovid.kit.folder import Kit
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene, scene_digest
from emovid.swarm.simulate import simulate

_TEXT = (
    ".html", ".htm", ".js", ".mjs", ".css", ".json", ".csv", ".tsv", ".txt", ".md", ".xml", ".svg", ".yaml", ".vtt",
)  # fmt: skip
_SHORTEST_CODE = 4  # characters; shorter words could be anything
_NEAR = 200  # characters of a line, on each side, that belong to a code in it
_GROUP = 600  # the same of a group in braces, brackets or a tag


def check_manifest(kit: Kit) -> Iterator[Finding]:
    """Check that the manifest has no unknown key."""
    for key in kit.unknown:
        yield Finding("manifest", "public/manifest.json", f"unknown key {key}")


def check_pages(kit: Kit, hints: Hints) -> Iterator[Finding]:
    """Check that no text names an emotion next to a code, or lists codes in an order that could reveal emotions."""
    codes = re.compile("|".join(map(re.escape, kit.manifest.codes)))
    for path in _texts(kit):
        where = kit.folder.inside(path)
        text = path.read_text(encoding="utf-8", errors="replace")
        found = list(codes.finditer(text))
        told: dict[str, set[str]] = {}
        for match in found:
            for part in (_line(text, match), _group(text, match)):
                named = hints.in_text(part)
                if named and not hints.labels <= named:  # all labels together are the list of choices
                    told.setdefault(match[0], set()).update(named)
        for code, named in told.items():
            yield Finding("pages", where, f"names an emotion next to {code}", tuple(sorted(named)))
        first = list(dict.fromkeys(match[0] for match in found))
        is_order = path.suffix == ".csv" and "position" in text.partition("\n")[0].split(",")
        if first != sorted(first) and not is_order:
            yield Finding("pages", where, "lists the videos in another order than their codes")


def check_secrets(kit: Kit) -> Iterator[Finding]:
    """Check that no public file contains the seed, the salt, the digest of a public scene or run, or a paid code."""
    yield from _completion_codes(kit)
    private = {name: _content(path) for name, path in (("seed", kit.folder.seed), ("salt", kit.folder.salt))}
    secrets: dict[str, tuple[str, tuple[str, ...]]] = {
        text: (f"contains the private {name}", ()) for name, text in private.items() if len(text) >= 8
    }
    for emotion in EMOTIONS:
        scene, run = _digests(emotion)
        secrets[scene] = "contains the digest of a public scene", (emotion,)
        secrets[run] = "contains the digest of the run of a public scene", (emotion,)
    for path in sorted(path for path in _shown(kit) if path.is_file()):
        data = path.read_bytes()
        for text, (message, emotions) in secrets.items():
            if text.encode() in data:
                yield Finding("secrets", kit.folder.inside(path), message, emotions)


def _completion_codes(kit: Kit) -> Iterator[Finding]:
    """Check that no file that everybody can read has a completion code or a return link, which services pay for."""
    words = [word for back in (kit.server.complete, kit.server.declined, kit.server.failed) for _, word in back if word]
    pages = [path for path in (kit.folder.exports / "jspsych").rglob("*") if path.suffix in (".html", ".js")]
    for path in sorted(path for path in (*kit.folder.public.rglob("*"), *pages) if path.is_file()):
        if path.suffix == ".mp4":
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        if any(re.search(rf"(?<!\w){re.escape(word)}(?!\w)", text) for word in words if len(word) >= _SHORTEST_CODE):
            message = "contains a completion code or a return link: anyone can read it and be paid"
            yield Finding("secrets", kit.folder.inside(path), message)


@cache
def _digests(emotion: str) -> tuple[str, str]:
    """Return the digests of a public scene and of its run."""
    scene = load_scene(emotion)
    return scene_digest(scene), simulate(scene).digest()


def _shown(kit: Kit) -> list[Path]:
    return [*kit.folder.public.rglob("*"), *kit.folder.exports.rglob("*")]


def _texts(kit: Kit) -> list[Path]:
    return sorted(path for path in _shown(kit) if path.is_file() and path.suffix.lower() in _TEXT)


def _content(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""


def _line(text: str, match: "re.Match[str]") -> str:
    """Return the text near a match on its line."""
    before = text[max(match.start() - _NEAR, 0) : match.start()].rpartition("\n")[2]
    return f"{before} {text[match.end() : match.end() + _NEAR].partition(chr(10))[0]}"


def _group(text: str, match: "re.Match[str]") -> str:
    """Return the content of the innermost braces, brackets or tag around a match, or ""."""
    before, after = text[max(match.start() - _GROUP, 0) : match.start()], text[match.end() : match.end() + _GROUP]
    found = []
    for opening, closing in ("{}", "[]", "<>"):
        left, right = _unmatched(before[::-1], closing, opening), _unmatched(after, opening, closing)
        if left is not None and right is not None:
            found.append(f"{before[len(before) - left :]} {after[:right]}")
    return min(found, key=len, default="")


def _unmatched(text: str, up: str, down: str) -> int | None:
    """Return the index of the first `down` without a matching `up` before it."""
    depth = 0
    for place, mark in enumerate(text):
        depth += (mark == up) - (mark == down)
        if depth < 0:
            return place
    return None
