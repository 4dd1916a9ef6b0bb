from collections import Counter
from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.kit.orders import balance_of, largest_spread, presentation_orders, square_size, williams_square

SCHEMES = st.sampled_from(["random", "latin", "williams"])
SEEDS = st.integers(0, 2**64)


def counts(rows) -> tuple[Counter, Counter]:
    """Count positions of videos and ordered pairs independently."""
    places = Counter((place, video) for row in rows for place, video in enumerate(row))
    pairs = Counter(pair for row in rows for pair in pairwise(row))
    return places, pairs


@pytest.mark.parametrize("n", [2, 4, 6, 8, 10, 12])
def test_williams_square_of_even_size_has_each_position_and_ordered_pair_once(n) -> None:
    rows = williams_square(n)
    places, pairs = counts(rows)
    assert len(rows) == n
    assert places == {(place, video): 1 for place in range(n) for video in range(n)}
    assert pairs == dict.fromkeys(permutations(range(n), 2), 1)


@pytest.mark.parametrize("n", [3, 5, 7, 9, 11])
def test_odd_number_gives_a_pair_of_squares_with_each_ordered_pair_twice(n) -> None:
    rows = williams_square(n)
    places, pairs = counts(rows)
    assert len(rows) == 2 * n
    assert places == {(place, video): 2 for place in range(n) for video in range(n)}
    assert pairs == dict.fromkeys(permutations(range(n), 2), 2)
    for half in (rows[:n], rows[n:]):
        assert set(counts(half)[0].values()) == {1}


@given(SCHEMES, st.integers(1, 9), st.integers(1, 70), SEEDS)
def test_orders_follow_their_scheme_for_any_number_of_participants(scheme, n, participants, seed) -> None:
    videos = [f"v{i}" for i in range(n)]
    orders = presentation_orders(scheme, videos, participants, seed)
    assert [sorted(order) for order in orders] == participants * [sorted(videos)]
    places, pairs = counts(orders)
    in_places = [places[place, video] for place in range(n) for video in videos]
    following = [pairs[pair] for pair in permutations(videos, 2)] or [0]
    found = balance_of(orders, videos)
    assert found.places_spread == max(in_places) - min(in_places)
    assert found.pairs_spread == max(following) - min(following)
    most_places, most_pairs = largest_spread(scheme, n, participants)
    assert most_places is None or found.places_spread <= most_places <= 1
    assert most_pairs is None or found.pairs_spread <= most_pairs <= 1 + n % 2
    if scheme == "williams" and participants % square_size(scheme, n) == 0:
        assert (found.places_spread, found.pairs_spread) == (0, 0)


@given(SCHEMES, st.integers(1, 8), st.integers(1, 40), st.integers(1, 40), SEEDS)
def test_orders_of_more_participants_begin_with_those_of_fewer(scheme, n, fewer, more, seed) -> None:
    orders = presentation_orders(scheme, [str(i) for i in range(n)], fewer + more, seed)
    assert orders[:fewer] == presentation_orders(scheme, [str(i) for i in range(n)], fewer, seed)


def test_orders_of_two_seeds_differ() -> None:
    videos = list("abcdef")
    assert presentation_orders("williams", videos, 12, 1) != presentation_orders("williams", videos, 12, 2)


def test_random_orders_use_all_permutations() -> None:
    seen = Counter(presentation_orders("random", "abc", 3000, 1))
    assert len(seen) == 6
    assert min(seen.values()) > 400


def test_balance_counts_remaining_positions_after_dropouts() -> None:
    found = balance_of([("a", "b", "c"), ("b", "a", ""), ("", "c", "a")], "abc")
    assert found.places.tolist() == [[1, 1, 1], [1, 1, 0], [0, 1, 1]]
    assert found.pairs.tolist() == [[0, 1, 0], [1, 0, 1], [1, 0, 0]]
    assert (found.places_spread, found.pairs_spread) == (1, 1)


def test_balance_without_videos_or_orders() -> None:
    assert balance_of([], "ab", 2).places.tolist() == [[0, 0], [0, 0]]
    assert np.array_equal(balance_of([("a",)], "a").places, [[1]])
    assert balance_of([], "a").pairs_range == balance_of([], "").places_range == (0, 0)


def test_balance_of_orders_longer_than_planned() -> None:
    assert balance_of([("a", "b", "a"), ("b",)], "ab", 2).places.tolist() == [[1, 0, 1], [1, 1, 0]]
