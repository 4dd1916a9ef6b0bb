"""`emovid study new`, `build`, `audit` and `export`: blinded kits for user studies."""

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich import box
from rich.console import Console
from rich.table import Table

from emovid.cli import completion
from emovid.cli.options import Force, Json, Quiet, output_folder
from emovid.cli.terminal import counting, show_table
from emovid.kit.audit import Audit
from emovid.kit.audit import audit as audit_kit
from emovid.kit.build import build as build_kit
from emovid.kit.export import TOOLS, check_export, is_possible
from emovid.kit.export import export as export_kit
from emovid.kit.exports.design import DesignPart
from emovid.kit.folder import open_kit
from emovid.kit.load import load_study, start_study
from emovid.kit.orders import Balance
from emovid.kit.seeded_random import GUESSABLE
from emovid.kit.update import update as update_kit

KitPath = Annotated[Path, typer.Argument(metavar="KIT", help="Folder of a kit.")]
Responses = Annotated[
    list[Path] | None,
    typer.Option("--responses", help="An export of the survey; repeat for several.", show_default=False),
]


def new(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder of the study, created if missing.")],
    quiet: Quiet = False,
) -> None:
    """Create a study file that follows the paper's procedure.

    The file study.yaml explains every key; edit it to make the study your own.

    Example: emovid study new my-study/
    """
    file = start_study(output_folder(folder, given=str(folder)))
    if not quiet:
        typer.echo(f"{file}: the paper's study; edit it, then run emovid study build {folder} -o kit/", err=True)


def build(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="A study.yaml, or a folder with one.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder of the kit, created if missing.")] = Path(
        "kit"
    ),
    participants: Annotated[
        int | None, typer.Option(min=1, max=100_000, help="Number of orders.", show_default="that of the study")
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Random seed, to build the same kit again.", show_default="a new secret one"),
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Build a kit: videos under random codes, orders, the key.

    Existing files of the same study and seed are kept.

    Examples: emovid study build my-study/ -o kit/ · emovid study build my-study/ -o kit/ --participants 60
    """
    output_folder(output)
    loaded = load_study(study)
    orders = participants or loaded.study.participants
    with counting("frames", quiet=quiet) as watch:
        progress = _Progress(len(loaded.exemplars) + len(loaded.extras), loaded.study.video.frames, watch, quiet)
        made = build_kit(loaded, output, orders, seed, progress, force=force)
    if quiet:
        return
    print(f"{output}: {len(made.codes)} videos, orders for {made.participants} participants", file=sys.stderr)
    print("Anyone may see public/; keep private/ closed until the data are complete", file=sys.stderr)
    if made.seed < GUESSABLE:
        print("warning: this seed, and with it the key, can be guessed; omit --seed for a real study", file=sys.stderr)


def update(
    kit: KitPath,
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="The corrected study.yaml, or a folder with one.")],
    quiet: Quiet = False,
) -> None:
    """Correct texts of a finished kit, as a new version.

    Videos, orders, key and answers stay. Other changes are refused.

    Examples: emovid study update kit/ my-study/
    """
    done = update_kit(load_study(study), kit)
    if quiet:
        return
    if not done.changed:
        print(f"{kit}: nothing to update; version {done.version}", file=sys.stderr)
        return
    print(f"{kit}: version {done.version}; changed: {', '.join(done.changed)}", file=sys.stderr)
    print("Restart emovid study serve to show it; repeat exports to other tools", file=sys.stderr)


class _Progress:
    """Prints finished videos, and counts frames.

    Args:
        videos: number of videos.
        frames: number of frames of each.
        watch: receives finished and all frames; None without a terminal.
        quiet: whether to print nothing.
    """

    def __init__(self, videos: int, frames: int, watch: Callable[[int, int], None] | None, quiet: bool) -> None:
        self.done, self.frames, self.total = 0, frames, videos * frames
        self.watch, self.quiet = watch, quiet

    def advanced(self, frames: int) -> None:
        if self.watch:
            self.watch(self.done + frames, self.total)

    def finished(self, video: Path, number: int, count: int, *, made: bool) -> None:
        self.done = number * self.frames
        if not self.quiet:
            print(f"[{number}/{count}] {video}: {'made' if made else 'up to date'}", file=sys.stderr, flush=True)


def audit(
    kit: KitPath,
    key: Annotated[
        Path | None,
        typer.Option(
            "--key", help="A published key, with its salt.txt in the same folder.", show_default="the private one"
        ),
    ] = None,
    responses: Responses = None,
    unblind: Annotated[bool, typer.Option("--unblind", help="Show emotions, and bit rates that reveal them.")] = False,
    as_json: Json = False,
) -> None:
    """Search a kit for anything that reveals an emotion to participants.

    Prints a line for each finding; exits with 1 if there is any.

    Examples: emovid study audit kit/ · emovid study audit kit/ --responses answers.csv
    """
    found = audit_kit(kit, key, responses or [])
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
            autocompletion=completion.words(*TOOLS),
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Output folder.", show_default="KIT/exports/TOOL")
    ] = None,
    video_url: Annotated[
        str, typer.Option("--video-url", help="Address of the videos for Qualtrics or LimeSurvey.")
    ] = "videos",
    responses: Responses = None,
    mapping: Annotated[
        Path | None, typer.Option("--map", help="A map.yaml of --responses.", show_default="that of the kit")
    ] = None,
    check: Annotated[
        bool,
        typer.Option("--check", help="Only print which parts of this kit the tool supports; exit with 1 if too few."),
    ] = False,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Export a kit to a survey tool, as a data set or a draft.

    Drafts of a preregistration and a reporting checklist are filled in from the kit.

    Examples: emovid study export kit/ --to jspsych · emovid study export kit/ --to limesurvey --check
    """
    if check:
        parts = check_export(open_kit(kit), to)
        _show_parts(parts)
        raise typer.Exit(0 if is_possible(parts) else 1)
    if output:
        output_folder(output)
    written = export_kit(open_kit(kit), to, output, video_url, responses or [], mapping, force=force)
    if quiet:
        return
    names = [path.name for path in written.files]
    start = "README.md" if "README.md" in names else names[0]
    print(f"{output or kit / 'exports' / to}: {len(names)} files; start with {start}", file=sys.stderr)
    for warning in written.warnings:
        print(f"warning: {warning}", file=sys.stderr)


def _show_parts(parts: Sequence[DesignPart]) -> None:
    table = Table("part", "in this kit", "in the tool", "note", box=box.SIMPLE)
    for part in parts:
        table.add_row(part.name, part.value, part.support.status.value, part.support.note)
    show_table(table)


def _show(found: Audit, unblind: bool) -> None:
    """Print findings, checks, sizes and balance; emotions, and sizes that reveal them, only if `unblind`."""
    console = Console(highlight=False, markup=False)
    for finding in found.findings:
        console.print(finding.unblinded if unblind else str(finding), soft_wrap=True)
    checks = Table("check", "findings", box=box.SIMPLE)
    for name, count in found.checks.items():
        checks.add_row(name, str(count or "none"))
    show_table(checks)
    if unblind:
        sizes = Table("emotion", "code", "bytes", "without padding", "kbit/s", box=box.SIMPLE)
        for size in found.sizes:
            sizes.add_row(size.emotion, size.video_code, *map(str, (size.bytes, size.content_bytes, size.kbit_per_s)))
        show_table(sizes, heads=2)
    where = "" if unblind else "; --unblind lists it"
    lines = [f"All files have equal size. The bit rate inside follows the motion and cannot be hidden{where}."]
    if found.orders:
        lines.append(_balance("Orders", found.orders))
    if left := found.left:
        lines += [f"Answers: {left.participants} participants, {left.complete} with all videos, {left.answers} answers"]
        lines.append(_balance("Answers", left.balance))
    for line in lines:
        console.print(line, soft_wrap=True)


def _balance(what: str, balance: Balance) -> str:
    positions = "{} to {} times in each position".format(*balance.places_range)
    pairs = "{} to {} times immediately after each other video".format(*balance.pairs_range)
    return f"{what}: each video {positions}, {pairs}"
