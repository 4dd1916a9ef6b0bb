"""A minimal reader of PDF files."""

import re
import zlib


def objects(pdf: bytes) -> bytes:
    """Return a PDF with its decompressed streams appended."""
    packed = re.findall(rb"/FlateDecode.*?stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    # Not zlib.decompress: the pattern above removes a final carriage return of a stream.
    return pdf + b"".join(zlib.decompressobj().decompress(data) for data in packed)


def page_box(pdf: bytes) -> list[float]:
    """Return left, bottom, right and top [pt] of the only page."""
    (box,) = re.findall(rb"/MediaBox \[ ?([\d. ]+?) ?\]", pdf)
    return [float(number) for number in box.split()]


def font_sizes(pdf: bytes) -> set[float]:
    """Return the sizes [pt] in which text is set."""
    return {round(float(size), 3) for size in re.findall(rb"/F\d+ ([\d.]+) Tf", objects(pdf))}


def all_fonts_are_embedded_truetype(pdf: bytes) -> bool:
    """Return whether every font is TrueType and embedded."""
    inside = objects(pdf)
    kinds = set(re.findall(rb"/Subtype /(Type[013]|TrueType|CIDFontType\d)\b", inside))
    described = len(re.findall(rb"/Type /FontDescriptor", inside))
    return kinds <= {b"TrueType", b"CIDFontType2", b"Type0"} and inside.count(b"/FontFile2") == described >= 1
