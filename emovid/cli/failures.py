"""What a command says of the items that it could not make."""

from collections.abc import Collection

import typer

from emovid.errors import EmovidError

_REMEDY = "run again to make what is missing"


def raise_failures(failures: Collection[EmovidError], count: int, items: str = "items") -> None:
    """Print why each of some items failed, and raise an error that says how many of `count`, if any."""
    if failures and count == 1:
        raise EmovidError(f"{next(iter(failures))}; {_REMEDY}")
    for failure in failures:
        typer.echo(str(failure), err=True)
    if failures:
        raise EmovidError(f"{len(failures)} of {count} {items} failed: {_REMEDY}")
