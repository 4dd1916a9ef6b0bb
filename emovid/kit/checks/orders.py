"""The orders: whether everybody sees what they should, and how well it is balanced."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from emovid.kit.checks.finding import Finding
from emovid.kit.orders import Order, balance_of, largest_spread
from emovid.kit.read import Kit
from emovid.responses.responses import Responses

_FILE = "orders.csv"


def check_orders(kit: Kit) -> Iterator[Finding]:
    """Check that everybody sees every video of their set once, and that orders are as balanced as their scheme says."""
    if not kit.folder.orders.exists():
        yield Finding("orders", _FILE, "missing")
        return
    shown = kit.manifest.videos_shown
    codes = set(kit.manifest.codes)
    if len(kit.orders) != kit.manifest.participants:
        yield Finding("orders", _FILE, f"{len(kit.orders)} participants; the manifest says {kit.manifest.participants}")
    for name, order in kit.orders.items():
        if unknown := set(order) - codes:
            yield Finding("orders", _FILE, f"{name} sees {sorted(unknown)[0]}, which is no video of the kit")
        if len(set(order)) != len(order) or len(order) != shown:
            yield Finding("orders", _FILE, f"{name} sees {len(set(order))} videos in {len(order)} places, not {shown}")
    for videos, orders in sets_of(kit.orders.values()).items():
        places, pairs = largest_spread(kit.manifest.order_scheme, len(videos), len(orders))
        balance = balance_of(orders, videos, shown)
        for what, spread, largest in (
            ("places", balance.places_spread, places),
            ("neighbours", balance.pairs_spread, pairs),
        ):
            if largest is not None and spread > largest:
                message = (
                    f"counts of {what} differ by {spread}; {kit.manifest.order_scheme} orders by {largest} at most"
                )
                yield Finding("orders", _FILE, message)


def sets_of(orders: Iterable[Order]) -> dict[Order, list[Order]]:
    """Return the orders by the set of videos that they show."""
    found: dict[Order, list[Order]] = {}
    for order in orders:
        found.setdefault(tuple(sorted(order)), []).append(order)
    return found


def planned_balance(kit: Kit) -> dict[str, Any]:
    """Return the balance of the orders, over all sets of videos."""
    return _summary(list(kit.orders.values()), kit)


def left_balance(kit: Kit, responses: Responses) -> dict[str, Any]:
    """Return the balance that the answers have: what dropouts left of the plan.

    Positions are those that the answers state; where none do, those planned for the participant.
    """
    seen: dict[str, list[str]] = {}
    unknown = 0
    for participant, rows in responses.answers.groupby("participant", sort=False):
        name = str(participant)
        order = [""] * kit.manifest.videos_shown
        planned = {code: place for place, code in enumerate(kit.orders.get(name, ()), start=1)}
        for video, position in zip(rows["video"], rows["position"].fillna(0), strict=True):
            place = int(position) or planned.get(str(video), 0)
            if 1 <= place <= len(order):
                order[place - 1] = str(video)
            else:
                unknown += 1
        seen[name] = order
    complete = Counter(all(order) for order in seen.values())[True]
    facts = {"participants": len(seen), "complete": complete, "answers": len(responses.answers)}
    return facts | {"answers_without_position": unknown} | _summary(list(seen.values()), kit)


def _summary(orders: Sequence[Sequence[str]], kit: Kit) -> dict[str, Any]:
    balance = balance_of(orders, kit.manifest.codes, kit.manifest.videos_shown)
    (places_least, places_most), (pairs_least, pairs_most) = balance.places_range, balance.pairs_range
    return {
        "videos": list(balance.videos),
        "places": balance.places.tolist(),
        "neighbours": balance.pairs.tolist(),
        "places_least": places_least,
        "places_most": places_most,
        "neighbours_least": pairs_least,
        "neighbours_most": pairs_most,
    }
