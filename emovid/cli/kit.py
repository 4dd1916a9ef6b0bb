"""`emovid study new`, `build`, `audit` and `export`: a blinded kit of stimuli, and what labs need of it."""

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from emovid.cli import completion
from emovid.cli.options import Force, Json, Quiet
from emovid.cli.progress import counting
from emovid.errors import InputError, nearest

if TYPE_CHECKING:
    from emovid.kit.audit import Audit

KitPath = Annotated[Path, typer.Argument(metavar="KIT", help="The folder of a kit.")]
Responses = Annotated[
    list[Path] | None,
    typer.Option("--responses", help="An export of the survey; more than once for several.", show_default=False),
]


def new(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder of the study, made if missing.")],
    quiet: Quiet = False,
) -> None:
    """Create a study file that follows the paper's procedure.

    The file study.yaml explains every key; edit it to make the study your own.

    Example: emovid study new my-study/
    """
    from emovid.atomic_io import make_folder, writing
    from emovid.kit.load import NAME
    from emovid.scene.resources import STUDIES, read_text

    file = folder / NAME
    if folder.suffix.lower() in (".yaml", ".yml") or (folder.exists() and not folder.is_dir()):
        raise InputError(f"{folder}: expected a folder, to write {NAME} into")
    if file.exists():
        raise InputError(f"{file}: exists; expected another folder")
    text = read_text(STUDIES / "example" / NAME, "study")
    make_folder(folder)
    with writing(file) as target:
        target.write(text.encode())
    if not quiet:
        typer.echo(f"{file}: the paper's study; make it yours, then emovid study build {folder} -o kit/", err=True)


def build(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="A study.yaml, or the folder that holds one.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder of the kit, made if missing.")] = Path(
        "kit"
    ),
    participants: Annotated[
        int | None, typer.Option(min=1, max=100_000, help="Orders to make.", show_default="as the study says")
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="What all is drawn from, to make a kit again.", show_default="a fresh secret"),
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Build a kit: videos under random codes, orders, the key.

    Existing files of the same study and seed are kept.

    Examples: emovid study build my-study/ -o kit/ · emovid study build my-study/ -o kit/ --participants 60
    """
    from emovid.kit.build import build as make
    from emovid.kit.load import load_study
    from emovid.kit.seeded_random import GUESSABLE

    loaded = load_study(study)
    orders = participants or loaded.study.participants
    with counting("frames", quiet=quiet) as told:
        report = _Report(len(loaded.exemplars), loaded.study.video.frames, told, quiet)
        made = make(loaded, output, orders, seed, report, force=force)
    if quiet:
        return
    print(f"{output}: {len(made.codes)} videos, orders for {made.participants} participants", file=sys.stderr)
    print("public/ is for everybody; private/ for nobody before the answers are in", file=sys.stderr)
    if made.seed < GUESSABLE:
        warning = "this seed can be guessed, and the key with it: for a real study leave --seed out"
        print(warning, file=sys.stderr)


class _Report:
    """Says when a video is done, and how many frames of all are.

    Args:
        videos: to be made.
        frames: of each.
        told: hears of frames; None where nobody watches.
        quiet: whether to say nothing.
    """

    def __init__(self, videos: int, frames: int, told: Callable[[int, int], None] | None, quiet: bool) -> None:
        self.done, self.frames, self.total = 0, frames, videos * frames
        self.told, self.quiet = told, quiet

    def advanced(self, frames: int) -> None:
        if self.told:
            self.told(self.done + frames, self.total)

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        self.done = number * self.frames
        if not self.quiet:
            print(f"[{number}/{count}] {video}: {'made' if made else 'up to date'}", file=sys.stderr, flush=True)


def audit(
    kit: KitPath,
    key: Annotated[
        Path | None,
        typer.Option("--key", help="A published key, its salt.txt beside it.", show_default="the private one"),
    ] = None,
    responses: Responses = None,
    unblind: Annotated[
        bool, typer.Option("--unblind", help="Say emotions, too, and the bit rates that could tell them.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Search a kit for anything that reveals an emotion to participants.

    Prints a line for each finding; exit with 1 if there is any.

    Examples: emovid study audit kit/ · emovid study audit kit/ --responses answers.csv
    """
    from emovid.kit.audit import audit as run

    found = run(kit, key, responses or [])
    if as_json:
        typer.echo(json.dumps(found.facts(unblind=unblind), indent=2))
    else:
        _show(found, unblind)
    if found.findings:
        raise typer.Exit(1)


def export(
    kit: KitPath,
    to: Annotated[
        str,
        typer.Option(
            "--to",
            metavar="TOOL",
            help="jspsych, psychopy, qualtrics, limesurvey, psych-ds, prereg, checklist.",
            autocompletion=completion.tools,
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The folder to write into.", show_default="KIT/exports/TOOL")
    ] = None,
    video_url: Annotated[
        str, typer.Option("--video-url", help="Where Qualtrics or LimeSurvey finds the videos.")
    ] = "videos",
    responses: Responses = None,
    quiet: Quiet = False,
) -> None:
    """Export a kit to a survey tool, as a data set or a draft.

    Drafts of a preregistration and a reporting checklist are filled in from the kit.

    Example: emovid study export kit/ --to jspsych
    """
    from emovid.kit.export import TOOLS
    from emovid.kit.export import export as run
    from emovid.kit.read import open_kit

    if to not in TOOLS:
        raise InputError(f"--to {to}: expected one of {', '.join(TOOLS)}{nearest(to, TOOLS)}")
    if output is not None and output.exists() and not output.is_dir():
        raise InputError(f"-o {output}: is a file; expected a folder")
    if responses and to != "psych-ds":
        raise InputError(f"--responses: no answers go into {to}; expected --to psych-ds")
    written = run(open_kit(kit), to, output, video_url, responses or [])
    if not quiet:
        folder = output or kit / "exports" / to
        print(f"{folder}: {len(written)} files; start with {_first(written)}", file=sys.stderr)


def _first(written: list[Path]) -> str:
    names = [path.name for path in written]
    return "README.md" if "README.md" in names else names[0]


def _show(found: "Audit", unblind: bool) -> None:
    """Print the findings, what was checked, the sizes and the balance; what tells emotions only to `unblind`."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from emovid.cli.tables import show_table

    console = Console(highlight=False, markup=False)
    for finding in found.findings:
        console.print(finding.unblinded if unblind else str(finding), soft_wrap=True)
    checks = Table("check", "findings", box=box.SIMPLE)
    for name, count in found.checks.items():
        checks.add_row(name, str(count or "none"))
    show_table(checks)
    if unblind:
        sizes = Table("emotion", "code", "bytes", "of them needed", "kbit/s", box=box.SIMPLE)
        for row in found.sizes:
            cells = (row["emotion"], row["video_code"], row["bytes"], row["content_bytes"], row["kbit_per_s"])
            sizes.add_row(*map(str, cells))
        show_table(sizes, heads=2)
    where = "" if unblind else ": --unblind lists it"
    equal = f"Files are made equally long; the bit rate inside follows the motion, and cannot be hidden{where}."
    console.print(equal, soft_wrap=True)
    if found.orders:
        console.print(_balance("Orders", found.orders), soft_wrap=True)
    if found.left:
        facts = found.left
        people = f"{facts['participants']} participants, {facts['complete']} with all videos"
        console.print(f"Answers: {people}, {facts['answers']} answers", soft_wrap=True)
        console.print(_balance("Answers", facts), soft_wrap=True)


def _balance(what: str, facts: Mapping[str, Any]) -> str:
    places = f"{facts['places_least']} to {facts['places_most']} times in each place"
    after = f"{facts['neighbours_least']} to {facts['neighbours_most']} times right after each other one"
    return f"{what}: each video {places}, {after}"
