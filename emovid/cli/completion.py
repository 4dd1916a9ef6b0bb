"""What a shell offers for a word that is being typed: emotions, files, names of figures.

A shell runs the whole command for every Tab, so that nothing is imported before it is needed; it matches the words to
what is typed itself where these functions do not.
"""

from collections.abc import Callable, Iterable
from pathlib import Path

Complete = Callable[[str], list[str]]
VIDEOS = (".mp4", ".webm", ".gif")


def words(*known: str) -> Complete:
    """Return what completes one of a few words."""

    def complete(incomplete: str) -> list[str]:
        return _starting(incomplete, known)

    return complete


def emotions(incomplete: str) -> list[str]:
    """Return the emotions that start so."""
    from emovid.scene.emotions import EMOTIONS

    return _starting(incomplete, EMOTIONS)


def scenes(incomplete: str) -> list[str]:
    """Return the emotions and scene files that start so."""
    return emotions(incomplete) + files(incomplete, ".yaml", ".yml")


def runs(incomplete: str) -> list[str]:
    """Return the emotions, scene files and finished runs that start so."""
    return scenes(incomplete) + files(incomplete, ".npz")


def descriptors(incomplete: str) -> list[str]:
    """Return the descriptors that start so, after those that are typed already."""
    from emovid.measure.describe import DESCRIPTORS

    before, comma, last = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in _starting(last, DESCRIPTORS)]


def figure_names(incomplete: str) -> list[str]:
    """Return the names of figures that start so, and after them what `frames` and `contact-sheet` may be given."""
    from emovid.figures.catalogue import CATALOGUE

    return (
        _starting(incomplete, ("all", "frames", "contact-sheet", "gallery", *CATALOGUE))
        + runs(incomplete)
        + files(incomplete, *VIDEOS)
    )


def tools(incomplete: str) -> list[str]:
    """Return the tools that a kit can be written for."""
    from emovid.kit.export import TOOLS

    return _starting(incomplete, TOOLS)


def files(incomplete: str, *suffixes: str) -> list[str]:
    """Return the files that start so and end in one of `suffixes`, and the folders that start so."""
    folder, _, name = incomplete.rpartition("/")
    typed = f"{folder}/" if "/" in incomplete else ""
    try:
        inside = sorted(Path(typed or ".").expanduser().iterdir())
        shown = [path for path in inside if path.name.startswith(name) and not path.name.startswith(".")]
        return [
            f"{typed}{path.name}{'/' * path.is_dir()}"
            for path in shown
            if path.is_dir() or path.suffix.lower() in suffixes
        ]
    except (OSError, RuntimeError):  # a folder that cannot be read or searched, the home of nobody
        return []


def _starting(incomplete: str, known: Iterable[str]) -> list[str]:
    return [word for word in known if word.startswith(incomplete)]
