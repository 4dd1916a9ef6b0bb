"""Writing the files of commands: a file with other content is never replaced unasked."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO

from emovid.atomic_io import check_existing, file_digest, make_folder, other_content, whole_file, writing

STDOUT = Path("-")


def write_outputs(files: Mapping[Path, bytes], *, force: bool) -> None:
    """Write files of the given contents, or none of them if one exists with other content, unless with `force`.

    Results are reproducible: the same input gives the same bytes, so that repeating a command changes nothing.

    Raises:
        InputError: for an existing file with other content, or a folder in its place.
        EmovidError: if a file cannot be written.
    """
    check_existing(files, force=force)
    for target, data in files.items():
        if target == STDOUT:
            sys.stdout.buffer.write(data)
            sys.stdout.buffer.flush()
        else:
            make_folder(target.parent)
            with writing(target) as file:
                file.write(data)


def write_output(target: Path, write: Callable[[IO[bytes]], None], *, force: bool) -> None:
    """Write one file, or to stdout, with a function that takes the open file. See `write_outputs`."""
    if target == STDOUT:
        write(sys.stdout.buffer)
        sys.stdout.buffer.flush()
        return
    make_folder(target.parent)
    with whole_file(target) as part:
        with part.open("wb") as file:
            write(file)
        if target.exists() and not force and file_digest(target) != file_digest(part):
            raise other_content(target)
