"""Rows of bubbles that lead away from crosses in a plane: as large as they can be without meeting. All in points."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from emovid.figures.style import TEXT, text_width

Array = NDArray[np.float64]

CROSS = 7.0  # from tip to tip
_GAP = 1.0  # between neighbors
_FAN = np.radians(29)  # least angle between two rows, where there is room for it
_HALVINGS = 30  # of the interval in which the scale is sought
_MUCH = 1.6  # times larger bubbles are worth rows that do not begin at their crosses


class Row(NamedTuple):
    """The bubbles of one cross, from the inside out, and the position of its name."""

    cross: Array  # (2,)
    along: Array  # (2,) unit vector
    centres: Array  # (bubbles, 2)
    radii: Array  # (bubbles,)
    name: Array  # (2,) center


def largest_rows(crosses: Array, sizes: Sequence[Array], names: Sequence[str], width: float) -> list[Row]:
    """Return rows with the largest bubbles for which no two things meet and all stay within the width.

    Rows begin at their crosses. Where that makes bubbles small, since crosses lie close together, they begin around
    the plane instead.

    Args:
        crosses: (rows, 2) about the middle of the page.
        sizes: diameters of each row's bubbles, to one scale.
        names: written beside the rows.
        width: of the page.
    """
    angles = fan(np.arctan2(crosses[:, 1], crosses[:, 0]), _FAN)
    around = (np.linalg.norm(crosses, axis=1).max() + CROSS) * _directions(angles)
    halves = [np.array([text_width([name]), TEXT]) / 2 for name in names]
    scale, rows = _largest(crosses, crosses, angles, sizes, halves, width)
    other_scale, other_rows = _largest(crosses, around, angles, sizes, halves, width)
    return other_rows if other_scale > _MUCH * scale else rows


def fan(angles: Array, gap: float) -> Array:
    """Return the angles (N,) [rad], pushed apart to at least `gap` from each other, their order around kept.

    Where N gaps do not fit into a turn, they share it evenly.
    """
    order = np.argsort(angles, kind="stable")
    spread = angles[order].astype(float)
    gap = min(gap, 2 * np.pi / len(angles))
    for _ in range(500):
        after = np.roll(spread, -1)
        after[-1] += 2 * np.pi
        push = np.maximum(gap - (after - spread), 0) / 2
        spread += np.roll(push, 1) - push
    result = np.empty_like(spread)
    result[order] = spread
    return result


def _largest(
    crosses: Array, starts: Array, angles: Array, sizes: Sequence[Array], halves: Sequence[Array], width: float
) -> tuple[float, list[Row]]:
    """Return the largest scale at which everything has its place, by halving, and the rows at that scale."""
    best = _rows(crosses, starts, angles, sizes, 0.0)
    low, high = 0.0, width / max(1.0, *(size.sum() for size in sizes))
    for _ in range(_HALVINGS):
        scale = (low + high) / 2
        rows = _rows(crosses, starts, angles, sizes, scale)
        if _are_apart(rows, width) and len(named := list(_named(rows, halves, width))) == len(rows):
            low, best = scale, named
        else:
            high = scale
    return low, best


def _directions(angles: Array) -> Array:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def _rows(crosses: Array, starts: Array, angles: Array, sizes: Sequence[Array], scale: float) -> list[Row]:
    """Return rows at a scale, with names at their starts."""
    rows = []
    for cross, start, along, size in zip(crosses, starts, _directions(angles), sizes, strict=True):
        diameters = scale * size
        ahead = CROSS / 2 + np.cumsum(diameters + _GAP) - diameters / 2
        rows.append(Row(cross, along, start + ahead[:, None] * along, diameters / 2, start))
    return rows


def _discs(row: Row) -> tuple[Array, Array]:
    """Return centers and radii of the parts of a row, the cross first."""
    return np.vstack([row.cross, row.centres]), np.concatenate([[CROSS / 2], row.radii])


def _are_apart(rows: list[Row], width: float) -> bool:
    """Say whether no row meets the bubbles or the cross of another, nor the edges of the page."""
    discs = [_discs(row) for row in rows]
    for i, (centres, radii) in enumerate(discs):
        if (abs(centres[:, 0]) + radii).max() > width / 2:
            return False
        for others, sizes in discs[:i]:
            meet = np.linalg.norm(centres[:, None] - others, axis=-1) < radii[:, None] + sizes + _GAP
            meet[0, 0] = False  # crosses lie where they lie
            if meet.any():
                return False
    return True


def _named(rows: list[Row], halves: Sequence[Array], width: float) -> Iterator[Row]:
    """Yield the rows with their names in free places, up to the first that has none."""
    centres, radii = (np.concatenate(part) for part in zip(*map(_discs, rows), strict=True))
    taken: list[tuple[Array, Array]] = []
    for row, half in zip(rows, halves, strict=True):
        for place in _places(row, half):
            beyond = np.linalg.norm(np.maximum(abs(centres - place) - half, 0), axis=1)
            on_page = abs(place[0]) + half[0] <= width / 2
            hidden = any((abs(place - other) < half + size + _GAP).all() for other, size in taken)
            if on_page and not hidden and (beyond > radii).all():
                taken.append((place, half))
                yield row._replace(name=place)
                break
        else:
            return


def _places(row: Row, half: Array) -> Iterator[Array]:
    """Yield places for a name of half the size `half`: at the row's end, then beside its bubbles, last first."""
    discs = list(zip(*_discs(row), strict=True))[::-1]
    across = np.array([-row.along[1], row.along[0]])
    for (centre, radius), direction in [(discs[0], row.along), *product(discs, (across, -across))]:
        with np.errstate(divide="ignore"):
            clear = ((half + radius + _GAP) / abs(direction)).min()
        yield centre + clear * direction
