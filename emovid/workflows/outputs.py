"""Writing the files of commands: a file with other content is never replaced unasked."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO

from emovid.atomic_io import file_digest, make_folder, whole_file, writing
from emovid.errors import InputError

STDOUT = Path("-")


def write_outputs(files: Mapping[Path, bytes], *, force: bool) -> None:
    """Write files of the given contents, or none of them if one exists with other content, unless with `force`.

    Results are reproducible: the same input gives the same bytes, so that repeating a command changes nothing.

    Raises:
        InputError: for an existing file with other content, or a folder in its place.
        EmovidError: if a file cannot be written.
    """
    for target, data in files.items():
        if target.is_dir():
            raise InputError(f"{target}: is a folder; expected a file that can be replaced")
        if target.exists() and not force and target.read_bytes() != data:
            raise _exists(target)
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
            raise _exists(target)


def _exists(target: Path) -> InputError:
    return InputError(f"{target} exists with other content; use --force to overwrite it, or -o")
