"""Folders of the shipped files, and reading of text files."""

from pathlib import Path

from emovid.errors import SourceError, reason

MAX_BYTES = 32_000_000  # a scene with the poses of 100 000 robots has 5 MB

_PACKAGE = Path(__file__).parent.parent
_ABOVE = _PACKAGE if (_PACKAGE / "configs").is_dir() else _PACKAGE.parent  # in a checkout, beside the package
CONFIGS = _ABOVE / "configs"
STUDIES = _ABOVE / "studies"


def read_text(path: Path, what: str = "scene", most: int = MAX_BYTES) -> str:
    """Return the text of a file of at most `most` bytes; `what` names its expected contents in messages.

    Raises:
        SourceError: if it cannot be read, is too large or is not UTF-8.
    """
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
        if len(data) > most:
            raise SourceError(str(path), f"too large for a {what}: more than {most // 1_000_000} MB")
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise SourceError(f"{path}:{line}", "not UTF-8 text") from None
    except OSError as error:
        raise SourceError(str(path), f"cannot be read: {reason(error)}") from None
