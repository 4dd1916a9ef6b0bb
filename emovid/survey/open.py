"""A kit and the database of its answers, without the kit's private folder."""

from pathlib import Path

from emovid.errors import InputError
from emovid.kit.folders import KitFolder
from emovid.kit.read import Kit, open_public
from emovid.survey.store import Store


def database_of(path: Path, *, pilot: bool) -> Path:
    """Return where the answers to a kit are; those of a pilot are in a file of their own."""
    return KitFolder(path).answers / ("pilot.sqlite" if pilot else "answers.sqlite")


def open_survey(path: Path, *, pilot: bool, begin: bool = False) -> tuple[Kit, Store]:
    """Return a kit and the store of the answers to it.

    Args:
        path: of the kit.
        pilot: whether pilot answers are meant.
        begin: whether a store that is not there is made.

    Raises:
        InputError: for a folder that is no finished kit, a kit without orders or whose videos are not those of its
            manifest, and a store that is not there or not of this kit.
        EmovidError: if the store cannot be opened.
    """
    kit = open_public(path)
    file = database_of(path, pilot=pilot)
    if begin:
        _check_whole(kit)
    elif not file.is_file():
        raise InputError(f"{file}: no such file; expected answers: emovid study serve{' --pilot' * pilot} records them")
    return kit, Store(file, kit.manifest.key_commitment)


def _check_whole(kit: Kit) -> None:
    kit.need_orders()
    for video in kit.manifest.videos:
        path = kit.folder.video(video.code)
        if not path.is_file() or path.stat().st_size != video.bytes:
            raise InputError(
                f"{path}: not the video of the manifest; expected {video.bytes} bytes: build the kit again"
            )
    known = set(kit.manifest.codes)
    for name, order in kit.orders.items():
        if not set(order) <= known:
            message = f"{name} has videos that the manifest has not; expected the orders of this kit: build it again"
            raise InputError(f"{kit.folder.orders}: {message}")
