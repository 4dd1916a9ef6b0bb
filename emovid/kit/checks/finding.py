"""What an audit finds."""

from typing import NamedTuple


class Finding(NamedTuple):
    """Something that could tell an emotion, or that is not as it should be.

    Attributes:
        check: that found it.
        where: a file, or part of one.
        message: what it is.
    """

    check: str
    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.check}: {self.where}: {self.message}"
