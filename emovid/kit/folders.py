"""Where things are in a kit's folder."""

import csv
import io
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from emovid.atomic_io import writing

# Of all public files and folders: 2000-01-01T00:00:00Z. When a video was made could tell which took long to make.
TIME = 946_684_800


@dataclass(frozen=True)
class KitFolder:
    """The paths of a kit."""

    path: Path

    @property
    def public(self) -> Path:
        """What a server may give to anybody."""
        return self.path / "public"

    @property
    def videos(self) -> Path:
        """The stimuli, CODE.mp4."""
        return self.public / "videos"

    @property
    def manifest(self) -> Path:
        """What the pages of a survey need; written last: a kit without it is unfinished."""
        return self.public / "manifest.json"

    @property
    def orders(self) -> Path:
        """Who sees which code in which place."""
        return self.path / "orders.csv"

    @property
    def map(self) -> Path:
        """What `study analyze --map` takes: the labels, and the texts that stand for them."""
        return self.path / "map.yaml"

    @property
    def exports(self) -> Path:
        """What was exported, a folder for each tool."""
        return self.path / "exports"

    @property
    def answers(self) -> Path:
        """What the survey recorded."""
        return self.path / "answers"

    @property
    def private(self) -> Path:
        """What nobody may see before the answers are in."""
        return self.path / "private"

    @property
    def key(self) -> Path:
        """The emotion of each code."""
        return self.private / "key.csv"

    @property
    def salt(self) -> Path:
        """What the key's commitment is salted with."""
        return self.private / "salt.txt"

    @property
    def seed(self) -> Path:
        """The seed that all was drawn from."""
        return self.private / "seed.txt"

    @property
    def study(self) -> Path:
        """The study as it was read, every key spelled out, and its digest."""
        return self.private / "study.json"

    @property
    def stimuli(self) -> Path:
        """How each stimulus was made."""
        return self.private / "stimuli.csv"

    def video(self, code: str) -> Path:
        """The file of a stimulus."""
        return self.videos / f"{code}.mp4"


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def write_text(path: Path, text: str, mode: int | None = None) -> None:
    """Write a file whole, readable by its owner alone if `mode` says so. Raises as `writing`."""
    with writing(path) as file:
        if mode is not None:
            os.fchmod(file.fileno(), mode)
        file.write(text.encode())


def set_times(folder: Path) -> None:
    """Give a folder and all in it one and the same time."""
    for path in [*folder.rglob("*"), folder]:
        os.utime(path, (TIME, TIME))
