import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from emovid.video.canvas import Change
from emovid.video.pixel_formats import PALETTE_SIZE, PaletteIndices, frequent_colours
from tests.helpers.reference import all_changed

PICTURES = arrays.arrays(np.uint8, (5, 4, 4), elements=st.sampled_from([0, 3, 77, 200, 255]))


def shown(data: np.ndarray, height: int, width: int) -> np.ndarray:
    """Return the colors (height, width, 3) that the indexed data of a picture encode."""
    index, table = np.split(data, [height * width])
    return table.reshape(256, 4)[index.reshape(height, width)][..., 2::-1]


def convert(picture: np.ndarray, colours: np.ndarray) -> np.ndarray:
    height, width = picture.shape[:2]
    return PaletteIndices(width, height, colours).convert(picture, all_changed(picture))


@given(PICTURES)
def test_pictures_with_few_colors_are_exact(picture) -> None:
    assert np.array_equal(shown(convert(picture, frequent_colours([picture])), 5, 4), picture[..., :3])


@given(arrays.arrays(np.uint8, (5, 4, 4)), st.lists(st.integers(0, 2**24 - 1), min_size=1, max_size=9, unique=True))
def test_every_pixel_gets_the_nearest_palette_color(picture, colours) -> None:
    table = np.array([[c & 255, c >> 8 & 255, c >> 16] for c in colours])
    found = shown(convert(picture, np.array(colours, np.uint32)), 5, 4).astype(int)
    wanted = picture[..., :3].astype(int)
    least = ((wanted[..., None, :] - table) ** 2).sum(axis=-1).min(axis=-1)
    assert np.array_equal(((wanted - found) ** 2).sum(axis=-1), least)


@given(PICTURES, PICTURES)
def test_partial_conversion_equals_full_conversion(first, second) -> None:
    colours = frequent_colours([first, second])
    follower = PaletteIndices(4, 5, colours)
    follower.convert(first, all_changed(first))
    both = first.copy()
    both[1:3, 2:] = second[1:3, 2:]
    where = np.flatnonzero((first != both).any(axis=2))
    change = Change(where, all_changed(both).pixels[where])
    assert np.array_equal(follower.convert(both, change), convert(both, colours))


def test_palette_keeps_the_most_frequent_colors() -> None:
    picture = np.zeros((32, 32, 4), np.uint8)
    picture.view(np.uint32)[..., 0] = np.arange(1024).reshape(32, 32)
    picture[:16] = 9
    kept = frequent_colours([picture, picture])
    assert kept[0] == 0x090909
    assert len(kept) == PALETTE_SIZE == 255  # one entry is left for pixels that stay as they are
