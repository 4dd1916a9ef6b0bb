"""Style and file formats of all figures: the same bytes in every run, independent of the user's matplotlibrc."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from fontTools import subset
from matplotlib.backends import backend_ps
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextToPath

from emovid.atomic_io import writing
from emovid.errors import InputError
from emovid.signals import held_signals

SINGLE_COLUMN, DOUBLE_COLUMN = 3.5, 7.16  # widths [in]; source: IEEE Author Center, "Resolution and Size"
TEXT = 8.0  # size of all text [pt]: figures are printed at their own size
POINTS = 72.0  # per inch
NONE = "none"  # the answer "none of these"

# About eleven steps of lightness (CIE L*) apart, so that they differ in gray; under protanopia, deuteranopia and
# tritanopia (Machado et al. 2009, severity 1) any two are 17 or more apart in CIE Lab.
EMOTION_COLOURS = {
    "happiness": "#f7ce12",
    "surprise": "#45bdf2",
    "disgust": "#33a868",
    "anger": "#c9501c",
    "fear": "#8436a0",
    "sadness": "#0f4068",
}
INK, QUIET, FAINT, NONE_COLOUR = "#1a1a1a", "#666666", "#b0b0b0", "#9c9c9c"

_STYLE: Any = {
    "font.family": ["DejaVu Sans"],  # part of matplotlib
    "font.size": TEXT,
    **dict.fromkeys(("axes.labelsize", "axes.titlesize", "xtick.labelsize", "ytick.labelsize"), TEXT),
    **dict.fromkeys(("legend.fontsize", "figure.labelsize", "figure.titlesize"), TEXT),
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.6),
    **dict.fromkeys(("xtick.major.size", "ytick.major.size"), 2.5),
    "text.parse_math": False,  # a label may contain dollar signs
    "legend.frameon": False,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,  # TrueType, embedded: publishers refuse type 3
    "ps.fonttype": 42,
    "svg.hashsalt": "emovid",  # the same ids in every run
}
# Metadata that would differ between runs or machines is left out.
_LEFT_OUT = {"pdf": "CreationDate", "png": "Software", "svg": "Date"}
_EPS_DATE = re.compile(rb"^%%CreationDate: [^\n]*\n", re.MULTILINE)  # the EPS backend always writes it
FORMATS = (*_LEFT_OUT, "eps")
_SUBJECTS = {"pdf": "Subject", "png": "Description", "svg": "Description"}
_LAYOUT_TABLES = ("GSUB", "GPOS", "GDEF", "kern")  # of fonts


@contextmanager
def in_style() -> Iterator[None]:
    """Draw in the style of all figures; restore the user's settings afterward."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


@in_style()
@held_signals()  # matplotlib's compiled parts would replace the exception of a signal by an error of their own
def encoded(figure: Figure, format: str, subject: str = "") -> bytes:
    """Return a figure as a file of the format: pdf, png (300 dpi), svg or eps; a subject is part of its metadata."""
    buffer = BytesIO()
    with _fonts_prepared_fast():
        if format == "eps":
            figure.savefig(buffer, format=format)
            return _EPS_DATE.sub(b"", buffer.getvalue(), count=1)
        metadata = {_LEFT_OUT[format]: None} | ({_SUBJECTS[format]: subject} if subject else {})
        figure.savefig(buffer, format=format, metadata=metadata)
    return buffer.getvalue()


@contextmanager
def _fonts_prepared_fast() -> Iterator[None]:
    """Embed fonts without tables for shaping text, and with the bounding box that the font file states.

    Glyphs stand where matplotlib puts them, so that the tables, which the default subset keeps, have no use: reading
    them takes a quarter of the time of a study's figures. For an EPS file matplotlib draws all 6,000 glyphs to find the
    same box, which takes longer than the figure.
    """
    load: Any = subset.load_font
    bounds: Any = getattr(backend_ps, "_bounds", None)

    def load_for_drawing(*arguments: Any, **options: Any) -> Any:
        font = load(*arguments, **options)
        for table in _LAYOUT_TABLES:
            if table in font:
                del font[table]
        return font

    subset.load_font = load_for_drawing
    backend_ps._bounds = lambda font: tuple(getattr(font["head"], side) for side in ("xMin", "yMin", "xMax", "yMax"))
    try:
        yield
    finally:
        subset.load_font = load
        backend_ps._bounds = bounds


def save(figure: Figure, path: Path) -> None:
    """Write a figure as a complete file in the format of its suffix.

    Raises:
        InputError: if the suffix is none of .pdf, .png, .svg, .eps.
        EmovidError: if the file cannot be written.
    """
    format = path.suffix.lower().removeprefix(".")
    if format not in FORMATS:
        raise InputError(f"{path}: expected a name that ends in .pdf, .png, .svg or .eps")
    data = encoded(figure, format)
    with writing(path) as file:
        file.write(data)


def settle(figure: Figure) -> Figure:
    """Fix the layout of a figure: matplotlib would compute it again, with another result, each time it saves."""
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()
        figure.set_layout_engine(None)  # "none" leaves an empty engine, for which matplotlib draws twice to save
    return figure


def label_colours(labels: Sequence[str]) -> dict[str, str]:
    """Return a color for each label: that of the emotion, or steps of viridis if any label is not one of the six."""
    named = [label for label in labels if label != NONE]
    colours = EMOTION_COLOURS
    if not set(named) <= set(EMOTION_COLOURS):
        colours = dict(zip(named, steps(len(named)), strict=True))
    return {label: colours.get(label, NONE_COLOUR) for label in labels}


def steps(count: int, colours: str = "viridis") -> list[str]:
    """Return `count` colors from dark to light, color-blind-safe and readable in gray."""
    ends = {"viridis": (0.08, 0.95), "Blues": (0.75, 0.2)}[colours]
    return [to_hex(colour) for colour in matplotlib.colormaps[colours](np.linspace(*ends, count))]


def text_on(colour: str) -> str:
    """Return the text color with the higher contrast on `colour`: dark ink or white."""
    channels = np.array(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]  # WCAG 2: contrast is (lighter + 0.05) / (darker + 0.05)
    return INK if (luminance + 0.05) ** 2 > 1.05 * 0.06 else "white"


def heading(label: str) -> str:
    """Return a label with its first letter in upper case, as in the paper's tables."""
    return label[:1].upper() + label[1:]


def text_width(texts: Iterable[str]) -> float:
    """Return the width of the widest text [pt]."""
    font = FontProperties(family="DejaVu Sans", size=TEXT)
    measure = TextToPath().get_text_width_height_descent
    return max((measure(text, font, ismath=False)[0] for text in texts), default=0.0)


def wrapped(text: str, width: float) -> list[str]:
    """Return the text in lines no wider than `width` [pt], unless a word is."""
    lines: list[str] = []
    for word in text.split(" ") if text else []:
        if lines and text_width([f"{lines[-1]} {word}"]) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines
