"""The audit of a kit: what could reveal an emotion to participants, and whether the kit is complete and balanced."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from emovid.errors import InputError
from emovid.kit.checks.files import check_files, check_key, check_names, check_permissions, check_times
from emovid.kit.checks.findings import Finding, Hints
from emovid.kit.checks.texts import check_manifest, check_pages, check_secrets
from emovid.kit.checks.videos import check_alike, check_content, check_decoding, check_scenes
from emovid.kit.folder import Kit, open_kit
from emovid.kit.mp4 import content_size
from emovid.kit.orders import Balance, balance_of, largest_spread, sets_of
from emovid.responses.read import read_responses
from emovid.responses.responses import Responses

Check = Callable[[], Iterator[Finding]]
_ORDERS = "orders.csv"


@dataclass(frozen=True)
class VideoSize:
    """Size of a video, which the encoder makes follow the motion.

    Attributes:
        emotion: the emotion; "" without a key.
        video_code: the code.
        bytes: size of the file, equal for all videos.
        content_bytes: size without the padding at the end.
        kbit_per_s: bit rate of the content.
    """

    emotion: str
    video_code: str
    bytes: int
    content_bytes: int
    kbit_per_s: float


@dataclass(frozen=True)
class Answered:
    """Answers so far: participants, those who answered all videos, answers, and answers without a position."""

    participants: int
    complete: int
    answers: int
    answers_without_position: int
    balance: Balance

    def facts(self) -> dict[str, Any]:
        """Return everything in plain types."""
        return {name: value for name, value in vars(self).items() if name != "balance"} | self.balance.facts()


@dataclass(frozen=True)
class Audit:
    """Result of an audit.

    Attributes:
        checks: number of findings of each check.
        findings: findings of all checks.
        sizes: sizes of the videos, sorted; bit rates cannot be hidden, so they are reported.
        orders: balance of the planned orders; None without orders.
        left: balance of the answers, if there are any.
    """

    checks: dict[str, int]
    findings: tuple[Finding, ...]
    sizes: tuple[VideoSize, ...]
    orders: Balance | None
    left: Answered | None

    def facts(self, *, unblind: bool) -> dict[str, Any]:
        """Return everything in plain types; emotions, and sizes that could reveal them, only if `unblind`."""
        hidden = () if unblind else ("emotions",)
        findings = [{k: v for k, v in each._asdict().items() if k not in hidden} for each in self.findings]
        sizes = {"sizes": list(map(asdict, self.sizes))} if unblind else {}
        orders, left = self.orders and self.orders.facts(), self.left and self.left.facts()
        return {"checks": self.checks, "findings": findings} | sizes | {"orders": orders, "left": left}


def audit(
    path: Path,
    key: Path | None = None,
    responses: Sequence[Path] = (),
    on_check: Callable[[str], None] = lambda _: None,
) -> Audit:
    """Audit a kit.

    Args:
        path: the kit.
        key: a published key with its salt beside it, for a kit without its private folder.
        responses: exports of the survey, to report the balance after dropouts.
        on_check: called with the name of each check before it runs.

    Raises:
        InputError: for a folder that is not a kit, and for invalid responses.
    """
    kit = open_kit(path, key)
    found: dict[str, list[Finding]] = {}
    for name, check in _checks(kit, key).items():
        on_check(name)
        found[name] = list(check())
    return Audit(
        checks={name: len(findings) for name, findings in found.items()},
        findings=tuple(finding for findings in found.values() for finding in findings),
        sizes=tuple(sorted(sizes(kit), key=lambda size: size.content_bytes)),
        orders=_balance(list(kit.orders.values()), kit) if kit.orders else None,
        left=_left(kit, key, responses) if responses else None,
    )


def sizes(kit: Kit) -> Iterator[VideoSize]:
    """Yield the sizes of the videos that can be read."""
    for video in kit.manifest.videos:
        try:
            data = (kit.folder.public / video.file).read_bytes()
            needed = content_size(data)
        except (OSError, ValueError):
            continue
        rate = round(8 * needed / video.duration / 1000, 1)
        yield VideoSize(kit.key.get(video.code, ""), video.code, len(data), needed, rate)


def _checks(kit: Kit, key: Path | None) -> dict[str, Check]:
    hints = Hints(kit)
    return {
        "files: only the manifest and the videos are public": lambda: check_files(kit),
        "names: random codes, no name of an emotion": lambda: check_names(kit, hints),
        "times: the same for all files": lambda: check_times(kit),
        "permissions: only the owner can read private files": lambda: check_permissions(kit),
        "manifest: no unknown key": lambda: check_manifest(kit),
        "pages: no text names an emotion next to a code": lambda: check_pages(kit, hints),
        "secrets: no seed, salt or digest is public": lambda: check_secrets(kit),
        "content: no metadata and no readable hint in videos": lambda: check_content(kit, hints),
        "videos: all decode and match the manifest": lambda: check_decoding(kit),
        "alike: equal length, size, rate and encoding; no copies": lambda: check_alike(kit),
        "scenes: no video shows the run of a public scene": lambda: check_scenes(kit),
        "key: complete, and matches the commitment": lambda: check_key(kit, key),
        "orders: complete and balanced": lambda: check_orders(kit),
    }


def check_orders(kit: Kit) -> Iterator[Finding]:
    """Check that each participant sees each video of a set once, and that orders are as balanced as their scheme."""
    if not kit.folder.orders.exists():
        yield Finding("orders", _ORDERS, "missing")
        return
    manifest, codes = kit.manifest, set(kit.manifest.codes)
    if len(kit.orders) != manifest.participants:
        yield Finding("orders", _ORDERS, f"{len(kit.orders)} participants; the manifest has {manifest.participants}")
    for name, order in kit.orders.items():
        if unknown := set(order) - codes:
            yield Finding("orders", _ORDERS, f"{name} sees {sorted(unknown)[0]}, which is not in the kit")
        if len(set(order)) != len(order) or len(order) != manifest.videos_shown:
            count = f"{len(set(order))} videos in {len(order)} positions, not {manifest.videos_shown}"
            yield Finding("orders", _ORDERS, f"{name} sees {count}")
    for videos, orders in sets_of(kit.orders.values()).items():
        positions, pairs = largest_spread(manifest.order_scheme, len(videos), len(orders))
        balance = balance_of(orders, videos, manifest.videos_shown)
        found = (("positions", balance.places_spread, positions), ("neighbors", balance.pairs_spread, pairs))
        for what, spread, largest in found:
            if largest is not None and spread > largest:
                message = f"counts of {what} differ by {spread}; expected at most {largest} for {manifest.order_scheme}"
                yield Finding("orders", _ORDERS, message)


def _left(kit: Kit, key: Path | None, responses: Sequence[Path]) -> Answered:
    file = key or kit.folder.key
    if not file.is_file():
        raise InputError(f"{file}: no such file; expected the key, to read the responses with")
    mapping = kit.folder.map if kit.folder.map.is_file() else None
    return _answered(kit, read_responses(list(responses), key=file, mapping=mapping))


def _answered(kit: Kit, responses: Responses) -> Answered:
    """Return the balance of the answers, by their own positions or else by those planned for the participant."""
    orders: list[list[str]] = []
    unknown = 0
    for participant, rows in responses.answers.groupby("participant", sort=False):
        order = [""] * kit.manifest.videos_shown
        planned = {code: place for place, code in enumerate(kit.orders.get(str(participant), ()), start=1)}
        for video, position in zip(rows["video"], rows["position"].fillna(0), strict=True):
            place = int(position) or planned.get(str(video), 0)
            if 1 <= place <= len(order):
                order[place - 1] = str(video)
            else:
                unknown += 1
        orders.append(order)
    complete = sum(map(all, orders))
    return Answered(len(orders), complete, len(responses.answers), unknown, _balance(orders, kit))


def _balance(orders: Sequence[Sequence[str]], kit: Kit) -> Balance:
    return balance_of(orders, kit.manifest.codes, kit.manifest.videos_shown)
