import tracemalloc
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from emovid.figures.contact import contact_figure
from emovid.figures.style import encoded

RNG = np.random.default_rng(0)


def saved(figure) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(encoded(figure, "png"))).convert("RGB"))


def places(sheet: np.ndarray, picture: np.ndarray) -> list[tuple[int, int]]:
    """Return the (row, column) of all pixels of a picture in a sheet."""
    height, width = picture.shape[:2]
    corners = np.argwhere((sheet[: -height + 1, : -width + 1] == picture[0, 0]).all(axis=-1))
    return [(y, x) for y, x in corners.tolist() if np.array_equal(sheet[y : y + height, x : x + width], picture)]


@pytest.mark.parametrize("labelled", [True, False])
def test_each_picture_is_placed_exactly(labelled) -> None:
    pictures = RNG.integers(0, 256, (2, 3, 90, 160, 3), np.uint8)
    labels = {"rows": ["anger", "fear"], "columns": ["1", "2", "3"], "row_title": "scene", "column_title": "seed"}
    sheet = saved(contact_figure(pictures, **labels if labelled else {"captions": [f"seed {i}" for i in range(6)]}))
    found = [[places(sheet, picture) for picture in row] for row in pictures]
    assert all(len(place) == 1 for row in found for place in row)
    ys, xs = np.array(found)[:, :, 0].transpose(2, 0, 1)
    assert (np.ptp(ys, axis=1) == 0).all()
    assert (np.ptp(xs, axis=0) == 0).all()
    assert (np.diff(xs[0]) == 166).all()
    assert ys[1, 0] - ys[0, 0] >= 96


def test_labels_and_pictures_must_agree() -> None:
    with pytest.raises(ValueError, match="2 x 3 pictures, 1 x 3 labels"):
        contact_figure(np.zeros((2, 3, 4, 4, 3), np.uint8), ["a"], ["1", "2", "3"])


def test_long_labels_are_inside_the_sheet() -> None:
    pictures = np.zeros((1, 2, 90, 160, 3), np.uint8)
    sheet = saved(
        contact_figure(pictures, ["a rather long label of a row"], ["a rather long label, too"] * 2, "r", "c")
    )
    edges = np.concatenate([sheet[:5].reshape(-1, 3), sheet[:, :5].reshape(-1, 3), sheet[:, -5:].reshape(-1, 3)])
    assert (edges == 255).all()


def test_a_sheet_of_many_rows_takes_little_more_memory_than_its_pixels() -> None:
    # A sweep of ten thousand runs makes a sheet of 130 million pixels; as one image it would take 16 GB.
    pictures = np.zeros((40, 3, 90, 160, 3), np.uint8)
    tracemalloc.start()
    encoded(contact_figure(pictures, captions=[str(i) for i in range(120)]), "png")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 30 * pictures.size / 3
