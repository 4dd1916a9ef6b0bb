"""Completions that a shell offers for the word that is being typed: emotions, scene files, finished runs."""

from collections.abc import Callable, Iterable
from pathlib import Path

from emovid.scene.emotions import EMOTIONS

Complete = Callable[[str], list[str]]
VIDEOS = (".mp4", ".webm", ".gif")


def starting(incomplete: str, known: Iterable[str]) -> list[str]:
    """Return the known words that start with the typed text."""
    return [word for word in known if word.startswith(incomplete)]


def words(*known: str) -> Complete:
    """Return a completion of a few fixed words."""
    return lambda incomplete: starting(incomplete, known)


def emotions(incomplete: str) -> list[str]:
    """Return the matching emotions."""
    return starting(incomplete, EMOTIONS)


def scenes(incomplete: str) -> list[str]:
    """Return the matching emotions and scene files."""
    return emotions(incomplete) + files(incomplete, ".yaml", ".yml")


def runs(incomplete: str) -> list[str]:
    """Return the matching emotions, scene files and finished runs."""
    return scenes(incomplete) + files(incomplete, ".npz")


def files(incomplete: str, *suffixes: str) -> list[str]:
    """Return the matching folders, and the matching files that end in one of `suffixes`."""
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
    except (OSError, RuntimeError):  # a folder that cannot be read, the home of an unknown user
        return []
