"""Which row of the orders a new participant gets."""

from collections.abc import Mapping, Sequence


def next_row(rows: Sequence[str], taken: Mapping[str, int]) -> str:
    """Return the row that fewest participants have, the first of these in the orders' own sequence.

    Rows in sequence fill one square after the other, so the balance of places and neighbours holds at any number.

    Args:
        rows: all, in the sequence of orders.csv.
        taken: how many participants who have finished or are under way have each row; rows not named have none.
    """
    return min(rows, key=lambda row: taken.get(row, 0))
