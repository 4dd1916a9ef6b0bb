"""What is wrong with the files of a study, said in one line."""

from emovid.errors import InputError


class StudyError(InputError):
    """A file that cannot be meant: which, where in it, what stands there, and what is expected.

    Attributes:
        file: as given; alone, the whole message.
        row: its line, counted from 1, or 0 for the file as a whole.
        cell: the column or the key, or "".
        message: what was found, and after a semicolon what is expected.
    """

    def __init__(self, file: str, message: str = "", row: int = 0, cell: str = "") -> None:
        parts = (f"{file}:{row}" if row else file, _short(cell), message)
        line = " ".join(": ".join(part for part in parts if part).split())
        super().__init__("".join(mark if mark.isprintable() else "?" for mark in line))
        self.file, self.row, self.cell, self.message = file, row, cell, message

    def __reduce__(self) -> tuple[type["StudyError"], tuple[str, str, int, str]]:
        # An exception is rebuilt from its `args` when it crosses to another process; ours takes four.
        return StudyError, (self.file, self.message, self.row, self.cell)


def quoted(text: str, longest: int = 40) -> str:
    """Return text in quotes for a message, cut where it is long."""
    return f"'{_short(text, longest)}'"


def _short(text: str, longest: int = 60) -> str:
    text = " ".join(text.split())
    return text if len(text) <= longest else f"{text[: longest - 1]}…"
