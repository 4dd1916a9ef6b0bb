"""Options that several commands share, and the scene settings they make."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli import completion
from emovid.errors import InputError, nearest

if TYPE_CHECKING:
    from emovid.scene.load import Setting

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
Seed = Annotated[int | None, typer.Option("--seed", help="Replace the scene's seed.", show_default=False)]
RandomSeed = Annotated[int, typer.Option("--seed", min=0, help="Of all that is random here.")]
Jobs = Annotated[
    int | None, typer.Option("--jobs", "-j", min=1, help="How many are made at once.", show_default="one a core")
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
        autocompletion=completion.words("robotarium", "robotarium-today"),
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Force = Annotated[bool, typer.Option("--force", "-f", help="Make it again, whatever is there.")]


def one_source(source: str | None, emotion: str | None) -> str:
    """Return the scene that is meant, given as an argument or by `--emotion`."""
    from emovid.scene.emotions import EMOTIONS

    if (source is None) == (emotion is None):
        raise InputError("expected one scene: a file, or --emotion and one of " + ", ".join(EMOTIONS))
    if emotion is not None:
        check_emotion(emotion)
    return source or emotion or ""


def check_emotion(emotion: str) -> None:
    """Raise an `InputError` unless `emotion` is one of the six."""
    from emovid.scene.emotions import EMOTIONS

    if emotion not in EMOTIONS:
        raise InputError(f"--emotion {emotion}: expected one of {', '.join(EMOTIONS)}{nearest(emotion, EMOTIONS)}")


def checked_platform(platform: str) -> str:
    """Return the platform, or raise an `InputError` for one that is none of ours."""
    from emovid.scene.emotions import PLATFORMS

    if platform not in PLATFORMS:
        expected = f"expected {' or '.join(PLATFORMS)}{nearest(platform, PLATFORMS)}"
        raise InputError(f"--platform {platform}: {expected}")
    return platform


def on_platform(source: str, platform: str | None) -> str:
    """Return the name of an emotion's scene for a platform; without a platform, the source as it is."""
    from emovid.scene.emotions import EMOTIONS

    if platform is None:
        return source
    checked_platform(platform)
    if source not in EMOTIONS:
        raise InputError(f"--platform {platform}: {source} is no emotion; expected one of {', '.join(EMOTIONS)}")
    return f"{platform}/{source}"


def settings(
    pairs: Sequence[str] | None, seed: int | None = None, look: Mapping[str, object] | None = None
) -> "list[Setting]":
    """Return the keys that options replace, the special ones last.

    Args:
        pairs: as given to `--set`.
        seed: of the scene.
        look: keys of `video` that have an option of their own, with its value; None is not given.
    """
    from emovid.scene.load import Setting

    made = []
    for pair in pairs or ():
        key, equals, value = pair.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {pair}: expected KEY=VALUE, as in robot.l=0.002")
        made.append(Setting(key.strip(), value.strip(), f"--set {pair[:60]}"))
    if seed is not None:
        made.append(Setting("seed", seed, f"--seed {seed}"))
    for key, option in (look or {}).items():
        if option is not None:
            made.append(Setting(f"video.{key}", option, f"--{key} {option}"))
    return made


def is_run(source: str) -> bool:
    """Return whether a source is a finished run, by its name."""
    return source.lower().endswith(".npz")


def check_file(file: Path, given: str) -> None:
    """Raise an `InputError` if a file to write, `given` as in ``-o x.csv``, is a folder."""
    if file.is_dir():
        raise InputError(f"{given}: is a folder; expected a file")


def refuse_beside(option: str, others: Mapping[str, object]) -> None:
    """Raise an `InputError` if one of the `others`, which say nothing beside an option, is given all the same."""
    for name, value in others.items():
        if value not in (None, []):
            raise InputError(f"{option}: expected no {name} beside it")


def output_file(
    output: Path | None, name: str, default: str, suffixes: Sequence[str], others: Sequence[str] = ()
) -> Path:
    """Return the file an `-o` means: itself if it ends in one of `suffixes`, else `name` in that folder.

    Args:
        output: as given.
        name: of the file, with its suffix.
        default: the folder if nothing was given.
        suffixes: of the files we can write.
        others: suffixes that clearly mean a file, but one we cannot write.
    """
    chosen = output or Path(default)
    expected = f"{' or '.join(suffixes)}, or a folder" if suffixes else "a folder"
    if chosen.suffix.lower() in suffixes:
        check_file(chosen, f"-o {chosen}")
        return chosen
    if chosen.suffix.lower() in others and not chosen.is_dir():
        raise InputError(f"-o {chosen}: cannot write {chosen.suffix}; expected {expected}")
    if chosen.exists() and not chosen.is_dir():
        other = f", or a name that ends in {' or '.join(suffixes)}" if suffixes else ""
        raise InputError(f"-o {chosen}: is a file; expected a folder{other}")
    return chosen / name
