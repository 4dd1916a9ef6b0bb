"""What a descriptor is: a number with a name, a unit, a definition and a source."""

from typing import NamedTuple


class Descriptor(NamedTuple):
    """One row of docs/descriptors.md.

    Attributes:
        name: in snake_case, the key of its value.
        unit: SI, or what it is a multiple of: "diagonals" of the stage, "share" of a whole, "1" for a bare number.
        definition: in words; over the robots and the window unless it says otherwise.
        source: who defined it, "" for a plain mean or count.
    """

    name: str
    unit: str
    definition: str
    source: str = ""
