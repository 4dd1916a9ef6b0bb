"""Text as LaTeX shows it."""

_ESCAPES = str.maketrans(
    {mark: f"\\{mark}" for mark in "&%$#_{}"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
)


def latex_text(text: str) -> str:
    """Return text with the marks escaped that LaTeX would take for commands."""
    return text.translate(_ESCAPES)
