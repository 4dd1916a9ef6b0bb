"""The order in which a set of videos is shown: random, and the same for the same seed."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from emovid.atomic_io import writing
from emovid.csv_writer import csv_text

NAME = "presentation_order.csv"


def write_presentation_order(folder: Path, videos: Mapping[str, str], seed: int) -> None:
    """Write `presentation_order.csv` (position,emotion,video), a random order of the videos.

    Args:
        folder: of the videos.
        videos: from emotion to file name.
        seed: of the order.
    """
    order = np.random.default_rng(seed).permutation(list(videos)).tolist()
    rows = ((position, emotion, videos[emotion]) for position, emotion in enumerate(order, start=1))
    with writing(folder / NAME) as file:
        file.write(csv_text(("position", "emotion", "video"), rows).encode())
