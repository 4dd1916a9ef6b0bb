"""The order in which a set of videos is shown: random, and the same for the same seed."""

import csv
import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from emovid.atomic_io import writing

NAME = "presentation_order.csv"


def write_presentation_order(folder: Path, videos: Mapping[str, str], seed: int) -> None:
    """Write `presentation_order.csv` (position,emotion,video), a random order of the videos.

    Args:
        folder: that holds the videos.
        videos: from emotion to file name.
        seed: of the order.
    """
    emotions = list(videos)
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(("position", "emotion", "video"))
    for position, i in enumerate(np.random.default_rng(seed).permutation(len(emotions)), start=1):
        rows.writerow((position, emotions[i], videos[emotions[i]]))
    with writing(folder / NAME) as file:
        file.write(text.getvalue().encode())
