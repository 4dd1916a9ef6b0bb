"""The audit of a kit: what of it could tell a participant the emotion, and whether it is whole and balanced."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from emovid.errors import InputError
from emovid.kit.checks.files import check_files, check_names, check_rights, check_times
from emovid.kit.checks.finding import Finding
from emovid.kit.checks.hints import Hints
from emovid.kit.checks.key import check_key
from emovid.kit.checks.orders import check_orders, left_balance, planned_balance
from emovid.kit.checks.pages import check_manifest, check_pages, check_secrets
from emovid.kit.checks.scenes import check_scenes
from emovid.kit.checks.videos import check_alike, check_content, check_decoding
from emovid.kit.mp4 import content_size
from emovid.kit.read import Kit, open_kit
from emovid.responses.read import read_responses

Check = Callable[[], Iterator[Finding]]


@dataclass(frozen=True)
class Audit:
    """What an audit came to.

    Attributes:
        checks: what was checked, in words, with the number of findings.
        findings: of all checks.
        sizes: of the videos, a row for each: what cannot be hidden is reported.
        orders: the balance of the orders.
        left: the balance of the answers, where there are some.
    """

    checks: dict[str, int]
    findings: tuple[Finding, ...]
    sizes: tuple[dict[str, Any], ...]
    orders: dict[str, Any] | None
    left: dict[str, Any] | None

    def facts(self, *, unblind: bool) -> dict[str, Any]:
        """Return all of it in plain types; without what tells emotions, and the sizes that could, unless `unblind`."""
        hidden = () if unblind else ("emotions",)
        findings = [{k: v for k, v in each._asdict().items() if k not in hidden} for each in self.findings]
        sizes = {"sizes": list(self.sizes)} if unblind else {}
        return {"checks": self.checks, "findings": findings} | sizes | {"orders": self.orders, "left": self.left}


def audit(
    path: Path,
    key: Path | None = None,
    responses: Sequence[Path] = (),
    on_check: Callable[[str], None] = lambda _: None,
) -> Audit:
    """Audit a kit.

    Args:
        path: of the kit.
        key: published beside its salt, for a kit without its private folder.
        responses: exports of the survey, for the balance that is left.
        on_check: hears what is checked next.

    Raises:
        InputError: for a folder that is no kit, and for responses that cannot be read.
    """
    kit = open_kit(path, key)
    found: dict[str, list[Finding]] = {}
    for name, check in _checks(kit, key).items():
        on_check(name)
        found[name] = list(check())
    return Audit(
        checks={name: len(findings) for name, findings in found.items()},
        findings=tuple(finding for findings in found.values() for finding in findings),
        sizes=tuple(sizes(kit)),
        orders=planned_balance(kit) if kit.orders else None,
        left=_left(kit, key, responses) if responses else None,
    )


def sizes(kit: Kit) -> Iterator[dict[str, Any]]:
    """Yield the sizes of the videos, by the bytes that are needed: the rest of a file is room to make all equal."""
    rows: list[dict[str, Any]] = []
    for video in kit.manifest.videos:
        path = kit.folder.public / video.file
        try:
            data = path.read_bytes()
            needed = content_size(data)
        except (OSError, ValueError):
            continue
        rate = round(8 * needed / video.duration / 1000, 1)
        facts: dict[str, Any] = {"emotion": kit.key.get(video.code, ""), "video_code": video.code, "bytes": len(data)}
        rows.append(facts | {"content_bytes": needed, "kbit_per_s": rate})
    yield from sorted(rows, key=lambda row: row["content_bytes"])


def _checks(kit: Kit, key: Path | None) -> dict[str, Check]:
    hints = Hints(kit)
    return {
        "files: nothing but manifest and videos is public": lambda: check_files(kit),
        "names: codes are random, no name tells": lambda: check_names(kit, hints),
        "times: all files have the same": lambda: check_times(kit),
        "rights: what is private is the owner's alone": lambda: check_rights(kit),
        "manifest: no key that it should not have": lambda: check_manifest(kit),
        "pages: no text puts an emotion beside a code": lambda: check_pages(kit, hints),
        "secrets: no seed, salt or digest is public": lambda: check_secrets(kit),
        "content: videos without metadata and readable hints": lambda: check_content(kit, hints),
        "videos: all decode and are those of the manifest": lambda: check_decoding(kit),
        "alike: equal length, size, rate and encoding; no copies": lambda: check_alike(kit),
        "scenes: no video is that of a public scene": lambda: check_scenes(kit),
        "key: fits, and is the one committed to": lambda: check_key(kit, key),
        "orders: complete and balanced": lambda: check_orders(kit),
    }


def _left(kit: Kit, key: Path | None, responses: Sequence[Path]) -> dict[str, Any]:
    file = key or kit.folder.key
    if not file.is_file():
        raise InputError(f"{file}: no such file; expected the key, to read the responses with")
    mapping = kit.folder.map if kit.folder.map.is_file() else None
    return left_balance(kit, read_responses(list(responses), key=file, mapping=mapping))
