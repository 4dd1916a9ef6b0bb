"""Options that several commands share, and the scenes, settings and files they select."""

import re
from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli import completion
from emovid.errors import InputError, nearest
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import Setting
from emovid.scene.model import Scene as ValidScene
from emovid.workflows.outputs import STDOUT


def whole(option: str, least: int | None = None, most: int | None = None) -> Callable[[str | int], int]:
    """Return a parser of whole numbers within bounds for an option."""

    def parse(text: str | int) -> int:
        value = number(option, least, most, "a whole number")(text)
        if value != round(value) or (isinstance(text, str) and not re.fullmatch(r"\s*[-+]?\d+\s*", text)):
            raise InputError(f"{option} {text}: expected a whole number (did you mean {round(value)}?)")
        return int(text)

    return parse


def number(
    option: str, least: float | None = None, most: float | None = None, kind: str = "a number"
) -> Callable[[str | float], float]:
    """Return a parser of numbers within bounds for an option; where 1 is the most, it suggests 0.5 for 50."""

    def parse(text: str | float) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        bounds = [f"{word} {bound:g}" for word, bound in (("at least", least), ("at most", most)) if bound is not None]
        if not isfinite(value):
            raise InputError(f"{option} {text}: expected {', '.join([kind, ' and '.join(bounds)]).removesuffix(', ')}")
        nearest = max(value if least is None else least, min(value, value if most is None else most))
        if value != nearest:
            hint = value / 100 if most == 1 and 1 < value <= 100 else nearest
            raise InputError(f"{option} {text}: expected {kind}, {' and '.join(bounds)} (did you mean {hint:g}?)")
        return value

    return parse


_FILE_SUFFIX = re.compile(
    r"\.(?!v\d)([A-Za-z][A-Za-z0-9]{1,7}|m|R)"
)  # not of a folder such as results.v2 or 2024.11.30

_KEYS = {"from": "begin", "to": "end"}  # of `video`, for options with another name

Source = Annotated[
    str | None,
    typer.Argument(
        metavar="[SCENE]",
        help="A scene file (.yaml), or the name of an emotion.",
        show_default=False,
        autocompletion=completion.scenes,
    ),
]
Scene = Annotated[
    str,
    typer.Argument(metavar="SCENE", help="A scene file, or the name of an emotion.", autocompletion=completion.scenes),
]
Emotion = Annotated[
    str | None,
    typer.Option(
        "--emotion",
        "-e",
        help="One of the six shipped scenes.",
        show_default=False,
        autocompletion=completion.emotions,
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Replace a key of the scene, as in robot.l=0.002.", show_default=False
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(
        "--seed", metavar="INTEGER", help="Replace the scene's seed.", show_default=False, parser=whole("--seed", 0)
    ),
]
Duration = Annotated[
    str | None,
    typer.Option("--duration", metavar="SECONDS", help="Replace the length of the run.", show_default=False),
]
RandomSeed = Annotated[int, typer.Option("--seed", metavar="INTEGER", help="Random seed.", parser=whole("--seed", 0))]
Jobs = Annotated[
    int | None,
    typer.Option(
        "--jobs",
        "-j",
        metavar="INTEGER",
        help="Parallel processes.",
        show_default="one per core",
        parser=whole("--jobs", 1),
    ),
]
View = Annotated[
    str | None,
    typer.Option(
        help="overhead or perspective.",
        show_default=False,
        autocompletion=completion.words("overhead", "perspective"),
    ),
]
Platform = Annotated[
    str | None,
    typer.Option(
        "--platform",
        "-p",
        help="Scenes for a testbed: robotarium or robotarium-today.",
        show_default="simulation",
        autocompletion=completion.words(*PLATFORMS),
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Force = Annotated[bool, typer.Option("--force", "-f", help="Overwrite existing results.")]


def one_source(source: str | None, emotion: str | None) -> str:
    """Return the requested scene, given as an argument or by `--emotion`."""
    if (source is None) == (emotion is None):
        raise InputError("expected one scene: a file, or --emotion and one of " + ", ".join(EMOTIONS))
    if emotion is not None:
        check_emotion(emotion)
    return source or emotion or ""


def check_emotion(emotion: str) -> None:
    """Raise an `InputError` unless `emotion` is one of the six."""
    if emotion not in EMOTIONS:
        raise InputError(f"--emotion {emotion}: expected one of {', '.join(EMOTIONS)}{nearest(emotion, EMOTIONS)}")


def checked_platform(platform: str) -> str:
    """Return the platform, or raise an `InputError` for an unknown one."""
    if platform not in PLATFORMS:
        expected = f"expected {' or '.join(PLATFORMS)}{nearest(platform, PLATFORMS)}"
        raise InputError(f"--platform {platform}: {expected}")
    return platform


def on_platform(source: str, platform: str | None) -> str:
    """Return the name of an emotion's scene for a platform; without a platform, the source unchanged."""
    if platform is None:
        return source
    checked_platform(platform)
    if source not in EMOTIONS:
        raise InputError(f"--platform {platform}: {source} is not an emotion; expected one of {', '.join(EMOTIONS)}")
    return f"{platform}/{source}"


def settings(
    pairs: Sequence[str] | None,
    seed: int | None = None,
    look: Mapping[str, str | int | float | None] | None = None,
    duration: str | None = None,
) -> list[Setting]:
    """Return the keys of the scene that options replace, in the order in which they apply.

    Args:
        pairs: the values of `--set`.
        seed: of the scene.
        look: options of their own for keys of `video`, with their values; None for an option not given.
        duration: of the run [s], as given.
    """
    made = []
    for pair in pairs or ():
        key, equals, value = pair.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {pair}: expected KEY=VALUE, as in robot.l=0.002")
        made.append(Setting(key.strip(), value.strip(), f"--set {pair[:60]}"))
    if seed is not None:
        made.append(Setting("seed", seed, f"--seed {seed}"))
    if duration is not None:
        made.append(Setting("duration", duration, f"--duration {duration}"))
    for key, option in (look or {}).items():
        if option is not None:
            made.append(Setting(f"video.{_KEYS.get(key, key)}", option, f"--{key} {option}"))
    return made


def warn_of(scene: ValidScene, *, quiet: bool) -> None:
    """Print the warning about a scene, if there is one."""
    if scene.warning and not quiet:
        typer.echo(f"warning: {scene.warning}", err=True)


def check_file(file: Path, given: str, suffixes: Sequence[str]) -> None:
    """Raise an `InputError` if a file to write, `given` as in ``-o x.csv``, is a folder or clearly of another kind.

    Args:
        file: to write; `STDOUT` and names without a suffix are valid, too.
        given: its name in the message.
        suffixes: of the files that can be written.
    """
    if file != STDOUT and file.is_dir():
        raise InputError(f"{given}: is a folder; expected a file")
    if _FILE_SUFFIX.fullmatch(file.suffix) and file.suffix.lower() not in suffixes:
        raise InputError(f"{given}: cannot write {file.suffix}; expected {' or '.join(suffixes)}")


def refuse_with(option: str, others: Mapping[str, Path | float | str | Sequence[str] | None]) -> None:
    """Raise an `InputError` if one of the `others`, which cannot be combined with an option, is given."""
    for name, value in others.items():
        if value not in (None, []):
            raise InputError(f"{option}: cannot be combined with {name}")


def output_file(output: Path | None, name: str, default: str, suffixes: Sequence[str]) -> Path:
    """Return the file that `-o` names: itself if it ends in one of `suffixes`, else `name` in that folder.

    Args:
        output: as given.
        name: of the file, with its suffix.
        default: the folder without `-o`.
        suffixes: of the files that can be written.
    """
    chosen = output or Path(default)
    if chosen.suffix.lower() in suffixes:
        check_file(chosen, f"-o {chosen}", suffixes)
        return chosen
    return output_folder(chosen, suffixes) / name


def output_folder(folder: Path, suffixes: Sequence[str] = (), given: str = "") -> Path:
    """Return the folder that `-o` names; an `InputError` is raised for a file, or a name that is clearly one.

    Args:
        folder: as given.
        suffixes: of the files that could be given instead.
        given: its name in messages, by default as in ``-o x``.
    """
    given = given or f"-o {folder}"
    if folder.name.lower() in suffixes:
        raise InputError(f"{given}: expected a name before {folder.name}")
    expected = f"{' or '.join(suffixes)}, or a folder" if suffixes else "a folder"
    if folder == STDOUT:
        raise InputError(f"{given}: writes files only; expected {expected}")
    if folder.exists() and not folder.is_dir():
        other = f", or a name that ends in {' or '.join(suffixes)}" if suffixes else ""
        raise InputError(f"{given}: is a file; expected a folder{other}")
    if not folder.exists() and _FILE_SUFFIX.fullmatch(folder.suffix):
        raise InputError(f"{given}: cannot write {folder.suffix}; expected {expected}")
    return folder
