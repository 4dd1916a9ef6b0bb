"""Looking into PDF files, as far as our tests need."""

import re
import zlib


def objects(pdf: bytes) -> bytes:
    """Return a PDF with its compressed streams spelled out after it."""
    packed = re.findall(rb"/FlateDecode.*?stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    # Not zlib.decompress: a stream that happens to end in a carriage return has lost that here.
    return pdf + b"".join(zlib.decompressobj().decompress(data) for data in packed)


def page_box(pdf: bytes) -> list[float]:
    """Return left, bottom, right and top [pt] of the only page."""
    (box,) = re.findall(rb"/MediaBox \[ ?([\d. ]+?) ?\]", pdf)
    return [float(number) for number in box.split()]


def font_sizes(pdf: bytes) -> set[float]:
    """Return the sizes [pt] in which text is set."""
    return {round(float(size), 3) for size in re.findall(rb"/F\d+ ([\d.]+) Tf", objects(pdf))}


def all_fonts_are_embedded_truetype(pdf: bytes) -> bool:
    """Say whether every font is TrueType and comes with its outlines."""
    inside = objects(pdf)
    kinds = set(re.findall(rb"/Subtype /(Type[013]|TrueType|CIDFontType\d)\b", inside))
    described = len(re.findall(rb"/Type /FontDescriptor", inside))
    return kinds <= {b"TrueType", b"CIDFontType2", b"Type0"} and inside.count(b"/FontFile2") == described >= 1
