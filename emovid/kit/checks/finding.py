"""What an audit finds."""

from typing import NamedTuple


class Finding(NamedTuple):
    """Something that could tell an emotion, or that is not as it should be.

    Attributes:
        check: that found it.
        where: a file, or part of one.
        message: what it is, without the emotions: who reads it may have to stay blind.
        emotions: that it tells.
    """

    check: str
    where: str
    message: str
    emotions: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.check}: {self.where}: {self.message}"

    @property
    def unblinded(self) -> str:
        """The finding with the emotions that it tells."""
        return f"{self}: {', '.join(self.emotions)}" if self.emotions else str(self)
