import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emovid.swarm import voronoi
from emovid.swarm.voronoi import pairs_within

# A coarse grid makes coincident points, and distances of exactly the limit, likely.
POINT = st.tuples(st.integers(-8, 8), st.integers(-8, 8))


@pytest.mark.parametrize("few", [0, 100])
@given(points=st.lists(POINT, max_size=60), distance=st.integers(0, 12))
def test_pairs_are_exactly_those_within_the_distance(points: list[tuple[int, int]], distance: int, few: int) -> None:
    expected = [
        (i, j)
        for i, (x, y) in enumerate(points)
        for j, (other_x, other_y) in enumerate(points)
        if i < j and (x - other_x) ** 2 + (y - other_y) ** 2 <= distance**2
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(voronoi, "_FEW_POINTS", few)
        i, j = pairs_within(np.array(points, dtype=float).reshape(-1, 2), float(distance))
    assert list(zip(i.tolist(), j.tolist(), strict=True)) == expected
