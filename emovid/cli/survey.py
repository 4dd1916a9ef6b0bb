"""`emovid study serve`, `responses`, `progress` and `withdraw`: the web survey of a kit."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli.kit import KitPath
from emovid.cli.options import Json, Quiet, check_file
from emovid.errors import EmovidError, InputError

if TYPE_CHECKING:
    from emovid.survey.progress import SurveyProgress

Pilot = Annotated[bool, typer.Option("--pilot", help="Pilot answers, which are kept in a file of their own.")]
Release = Annotated[
    float, typer.Option("--release-after", min=1, help="Minutes without a sign until a participant counts as gone.")
]


def serve(
    kit: KitPath,
    port: Annotated[int, typer.Option(min=0, max=65535, help="To listen at; 0 takes a free one.")] = 8000,
    host: Annotated[str, typer.Option(help="To listen at.")] = "127.0.0.1",
    pilot: Pilot = False,
    https: Annotated[bool, typer.Option("--https", help="A proxy in front speaks TLS: cookies by TLS only.")] = False,
    release_after: Release = 120,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but the address and errors.")] = False,
) -> None:
    """Serve a kit as a web survey until Ctrl-C.

    Answers are stored in KIT/answers/.

    Examples: emovid study serve kit/ · emovid study serve kit/ --pilot --port 8001
    """
    try:
        from emovid.survey.serve import serve as run
    except ModuleNotFoundError as error:
        raise EmovidError(f"{error.name} is missing: pip install 'emovid[serve]'") from None

    def started(host: str, port: int) -> None:
        where = f"http://{f'[{host}]' if ':' in host else host}:{port}/"
        print(f"{where}: {'pilot' if pilot else 'survey'} of {kit}; Ctrl-C ends it", file=sys.stderr, flush=True)
        if (kit / "private").exists() and not quiet:
            print(f"{kit / 'private'} is not needed here: keep it elsewhere while the study runs", file=sys.stderr)

    run(kit, host, port, pilot=pilot, https=https, release=60 * release_after, started=started)


def responses(
    kit: KitPath,
    output: Annotated[Path, typer.Option("--output", "-o", help="The file to write.")] = Path("responses.csv"),
    pilot: Pilot = False,
    release_after: Release = 120,
    quiet: Quiet = False,
) -> None:
    """Write the answers of a web survey as a table.

    The survey may be running. study analyze reads the table.

    Examples: emovid study responses kit/ -o responses.csv
    """
    from emovid.atomic_io import make_folder, writing
    from emovid.survey.export import responses_csv
    from emovid.survey.open import open_survey

    check_file(output, f"-o {output}")
    opened, store = open_survey(kit, pilot=pilot)
    text = responses_csv(store, opened.manifest, pilot=pilot, release=60 * release_after)
    store.close()
    make_folder(output.parent)
    with writing(output) as file:
        file.write(text.encode())
    if not quiet:
        print(f"{output}: {text.count(chr(10)) - 1} answers", file=sys.stderr)


def progress(kit: KitPath, pilot: Pilot = False, release_after: Release = 120, as_json: Json = False) -> None:
    """Show how many participants enrolled, finished and left.

    Also shows the balance of the orders.

    Examples: emovid study progress kit/ · emovid study progress kit/ --json
    """
    from dataclasses import asdict

    from emovid.survey.open import open_survey
    from emovid.survey.progress import progress_of

    opened, store = open_survey(kit, pilot=pilot)
    opened.need_orders()
    people = [person for person, _ in store.participants()]
    rows, codes = list(opened.orders), opened.manifest.codes
    found = progress_of(people, store.withdrawals(), rows, codes, store.clock(), 60 * release_after)
    store.close()
    typer.echo(json.dumps(asdict(found) | {"enrolled": found.enrolled}, indent=2) if as_json else _table(found))


def withdraw(
    kit: KitPath,
    code: Annotated[str, typer.Argument(metavar="CODE", help="The participant's own code.")],
    pilot: Pilot = False,
    quiet: Quiet = False,
) -> None:
    """Delete the data of a participant who withdraws.

    The participant has to provide the code.

    Examples: emovid study withdraw kit/ bcdf-ghjk-mnpq-rstv-wxyz-2345
    """
    from emovid.survey.codes import digest, normal
    from emovid.survey.open import open_survey

    normalised = normal(code)
    _, store = open_survey(kit, pilot=pilot)
    known = bool(normalised) and store.withdraw(digest(normalised))
    store.close()
    if not known:
        raise InputError(f"{code}: no participant has this code; expected one as in bcdf-ghjk-mnpq-rstv-wxyz-2345")
    if not quiet:
        print("all that was recorded of this participant is deleted; do so in former exports, too", file=sys.stderr)


def _table(found: "SurveyProgress") -> str:
    used = sorted(found.rows.values())
    lines = [
        f"enrolled     {found.enrolled:5d}",
        f"finished     {found.finished:5d}",
        f"in progress  {found.in_progress:5d}",
        f"abandoned    {found.abandoned:5d}",
        f"withdrawn    {found.withdrawn:5d}",
        f"answers      {found.answers:5d}",
        f"Orders of those who finished: each row {used[0]} to {used[-1]} times, each video {found.places[0]} to "
        f"{found.places[1]} times in each place, {found.neighbours[0]} to {found.neighbours[1]} times right after each "
        "other one",
    ]
    return "\n".join(lines)
