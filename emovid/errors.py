"""Errors, each with a message of one line.

Every error that a user can cause is an `EmovidError`. Its text is the whole message; its `exit_code` is that of the
command line, which catches these errors in one place, `emovid.cli.main`.
"""

import errno
import re
import sys
import warnings
from collections.abc import Iterable
from difflib import get_close_matches
from typing import TextIO

MORE_FILES = "raise the limit on open files (ulimit -n)"
# matplotlib warns about each glyph, each time.
_MISSING_GLYPH = re.compile(r"Glyph (\d+) .* missing from font\(s\) (.*?)\.?$")
_fonts_told: set[str] = set()


class EmovidError(Exception):
    """An error that ends the command with one line on stderr; exit code 1, a failure not due to the input."""

    exit_code = 1


class InputError(EmovidError):
    """Invalid input: exit code 2; nothing has been written."""

    exit_code = 2


class SourceError(InputError):
    """Invalid content of a file or an option.

    Attributes:
        where: the file or the option; if given alone, the whole message.
        message: the given value, and after a semicolon the expected one.
        line: the line in the file, counted from 1, or 0 for the file as a whole.
        key: the key or the column, or "".
    """

    def __init__(self, where: str, message: str = "", line: int = 0, key: str = "") -> None:
        parts = (f"{where}:{line}" if line else where, shortened(key), message)
        text = " ".join(": ".join(part for part in parts if part).split())
        super().__init__("".join(char if char.isprintable() else "?" for char in text))
        self.where, self.message, self.line, self.key = where, message, line, key

    def __reduce__(self) -> tuple[type["SourceError"], tuple[str, str, int, str]]:
        # An exception sent to another process is rebuilt from its `args`; this one takes four.
        return SourceError, (self.where, self.message, self.line, self.key)


class RenderError(EmovidError):
    """A video that could not be made: the encoder failed, or the file is incomplete."""


def nearest(word: str, known: Iterable[str]) -> str:
    """Return ` (did you mean X?)` for the known word closest to `word`, upper and lower case alike, or ``""``."""
    by_lower = {name.lower(): name for name in known}
    close = get_close_matches(word.lower(), by_lower, n=1, cutoff=0.6)
    return f" (did you mean {by_lower[close[0]]}?)" if close else ""


def reason(error: OSError) -> str:
    """Return the system's description of an error, in lower case, with a remedy for too many open files."""
    text = (error.strerror or str(error)).lower()
    return f"{text}: {MORE_FILES}" if error.errno == errno.EMFILE else text


def quoted(text: str, longest: int = 40) -> str:
    """Return text in quotes for a message, cut where it is long."""
    return f"'{shortened(text, longest)}'"


def shortened(text: str, longest: int = 60) -> str:
    """Return text on one line, cut where it is long."""
    text = " ".join(text.split())
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def say_warnings_in_one_line() -> None:
    """Print the warnings of this process in one line on stderr; only one for all missing glyphs of a font."""
    warnings.showwarning = _show_warning


def _show_warning(
    message: Warning | str,
    category: type[Warning],  # noqa: ARG001
    filename: str,  # noqa: ARG001
    lineno: int,  # noqa: ARG001
    file: TextIO | None = None,
    line: str | None = None,  # noqa: ARG001
) -> None:
    text = str(message)
    if glyph := _MISSING_GLYPH.match(text):
        code, font = glyph.groups()
        if font in _fonts_told:
            return
        _fonts_told.add(font)
        text = (
            f"{font}, the font of figures, lacks {chr(int(code))} and maybe other characters: they are drawn as boxes"
        )
    print(f"warning: {text}", file=file or sys.stderr)
