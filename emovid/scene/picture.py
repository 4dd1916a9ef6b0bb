"""Pictures of a scene: read once, then part of the scene, so that a run needs no other file."""

import re
import warnings
from base64 import b64decode, b64encode
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from emovid.errors import SourceError, reason
from emovid.yaml_source import KeyPath, Places, place_of

MAX_SIDE = 128  # pixels kept: finer than any smoothing
MAX_BYTES = 32_000_000
_TEXT = re.compile(r"([1-9][0-9]{0,2})x([1-9][0-9]{0,2}) ([A-Za-z0-9+/]+=*)")
_GREY_MODES = ("1", "L", "LA", "P", "RGB", "RGBA")


class Grey(NamedTuple):
    """A grayscale picture.

    Attributes:
        width, height: in pixels.
        values: row by row from the top, 0 black to 255 white.
    """

    width: int
    height: int
    values: bytes

    @property
    def is_dark(self) -> bool:
        """True if any pixel is darker than white."""
        return min(self.values, default=255) < 255


def read_pictures(data: Any, folder: Path, places: Places) -> None:
    """Read the pictures of the densities in `data`, the keys of a scene, into their `pixels`.

    Args:
        data: plain values as read from YAML, valid or not; changed in place.
        folder: that file names are relative to.
        places: of the keys.

    Raises:
        SourceError: for a file that cannot be read or is not a grayscale PNG.
    """
    path: KeyPath = ("behaviour", "density")
    density = _inside(_inside(data, "behaviour"), "density")
    parts = _inside(density, "parts")
    found = [(path, density)]
    for i, part in enumerate(parts if isinstance(parts, list) else ()):
        found.append(((*path, "parts", i, "density"), _inside(part, "density")))
    for path, keys in found:
        name = _inside(keys, "file")
        if _inside(keys, "kind") != "image" or _inside(keys, "pixels") is not None or not isinstance(name, str):
            continue
        try:
            keys["pixels"] = _text(_read(folder / name))
        except _UnusableError as error:
            key = (*path, "file")
            raise SourceError(place_of(key, places), f"{name}: {error}", key=".".join(map(str, key))) from None


def picture_of(pixels: str) -> Grey | None:
    """Return the picture in the text of a scene's `pixels`; None if it is invalid."""
    found = _TEXT.fullmatch(pixels)
    if not found:
        return None
    try:
        picture = Grey(int(found[1]), int(found[2]), b64decode(found[3], validate=True))
    except ValueError:
        return None
    return picture if len(picture.values) == picture.width * picture.height else None


class _UnusableError(Exception):
    pass


def _inside(keys: Any, key: str) -> Any:
    return keys.get(key) if isinstance(keys, dict) else None


def _text(picture: Grey) -> str:
    return f"{picture.width}x{picture.height} {b64encode(picture.values).decode()}"


def _read(path: Path) -> Grey:
    """Return a PNG in gray, on white where it is transparent, with at most `MAX_SIDE` pixels a side."""
    from PIL import Image, UnidentifiedImageError  # noqa: PLC0415 - few scenes have a picture

    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise _UnusableError(f"too large: more than {MAX_BYTES // 1_000_000} MB")
        with warnings.catch_warnings(action="error"), Image.open(BytesIO(data), formats=["PNG"]) as opened:
            if opened.mode not in _GREY_MODES:
                raise _UnusableError("expected a PNG of 8 bits a channel")
            colours = opened.convert("RGBA")
    except OSError as error:
        if isinstance(error, UnidentifiedImageError):
            raise _UnusableError("not a PNG: expected a gray-scale picture") from None
        raise _UnusableError(f"cannot be read: {reason(error)}") from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise _UnusableError("too large: more pixels than any density needs") from None
    except (ValueError, SyntaxError, UserWarning):
        raise _UnusableError("a broken PNG") from None
    white = Image.new("RGBA", colours.size, "white")
    grey = Image.alpha_composite(white, colours).convert("L")
    shrink = max(1.0, max(grey.size) / MAX_SIDE)
    width, height = (max(1, round(side / shrink)) for side in grey.size)
    grey = grey.resize((width, height), Image.Resampling.BOX)
    return Grey(width, height, grey.tobytes())
