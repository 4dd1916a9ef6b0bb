"""`emovid study serve`, `responses`, `progress` and `withdraw`: the web survey of a kit."""

import json
import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli.kit import KitPath
from emovid.cli.options import Force, Json, Quiet, check_file
from emovid.csv_writer import csv_text
from emovid.errors import EmovidError, InputError
from emovid.survey.codes import digest, normalized, recruit_digest
from emovid.survey.export import is_of_kit, progress_of, responses_csv
from emovid.survey.store import Withdrawal, open_survey
from emovid.workflows.outputs import write_outputs

Pilot = Annotated[bool, typer.Option("--pilot", help="Use the answers of the pilot, which are in a separate file.")]
Release = Annotated[
    float, typer.Option("--release-after", min=1, help="Minutes of inactivity until a participant counts as gone.")
]


def serve(
    kit: KitPath,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port to listen on; 0 selects a free one.")] = 8000,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    pilot: Pilot = False,
    https: Annotated[
        bool, typer.Option("--https", help="Send cookies over TLS only, which a proxy in front provides.")
    ] = False,
    kiosk: Annotated[
        bool, typer.Option("--kiosk", help="Participants share a computer: the last page leads to the next person.")
    ] = False,
    prefix: Annotated[
        str, typer.Option("--prefix", help="Path of the survey behind a proxy, as in /study1.", show_default=False)
    ] = "",
    release_after: Release = 120,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print only the address and errors.")] = False,
) -> None:
    """Serve a kit as a web survey until Ctrl-C.

    Answers are stored in KIT/answers/.

    Examples: emovid study serve kit/ · emovid study serve kit/ --pilot --port 8001
    """
    try:
        from emovid.survey.serve import serve as run  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        raise EmovidError(f"{error.name} is missing: pip install 'emovid[serve]'") from None

    if prefix and not re.fullmatch(r"(/[A-Za-z0-9._~-]+)+", prefix):
        raise InputError(f"--prefix {prefix}: not a path; expected one such as /study1")

    def started(host: str, port: int, token: str) -> None:
        address = f"http://{f'[{host}]' if ':' in host else host}:{port}{prefix}/"
        print(f"{address}: {'pilot' if pilot else 'survey'} of {kit}; Ctrl-C ends it", file=sys.stderr, flush=True)
        if not quiet:
            print(f"{address}status#{token}: numbers of participants, for researchers", file=sys.stderr)
        if (kit / "private").exists() and not quiet:
            print(f"{kit / 'private'} is not needed here: keep it elsewhere while the study runs", file=sys.stderr)

    release = 60 * release_after
    run(kit, host, port, pilot=pilot, https=https, release=release, kiosk=kiosk, prefix=prefix, started=started)


def responses(
    kit: KitPath,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write.")] = Path("responses.csv"),
    pilot: Pilot = False,
    rehearsal: Annotated[
        bool, typer.Option("--rehearsal", help="Mark the answers as a rehearsal, which study analyze counts.")
    ] = False,
    release_after: Release = 120,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Write the answers of a web survey as a table.

    The survey may be running. study analyze reads the table.

    Examples: emovid study responses kit/ -o responses.csv
    """
    check_file(output, f"-o {output}", (".csv",))
    opened, store = open_survey(kit, pilot=pilot)
    mode = "rehearsal" if rehearsal else ""
    text = responses_csv(store, opened, pilot=pilot, release=60 * release_after, mode=mode)
    counts = progress_of(store, list(opened.orders), opened.manifest.codes, 60 * release_after)
    store.close()
    force = force or is_of_kit(output, opened.manifest.codes)
    write_outputs({output: text.encode()}, force=force)
    if not quiet:
        flow = ", ".join(f"{count} {name}" for name, count in counts.flow().items() if count and name != "answers")
        print(f"{output}: {counts.answers} answers; participants: {flow or 'none'}", file=sys.stderr)


def progress(kit: KitPath, pilot: Pilot = False, release_after: Release = 120, as_json: Json = False) -> None:
    """Show how many participants enrolled, finished and left.

    Also shows the balance of the orders.

    Examples: emovid study progress kit/ · emovid study progress kit/ --json
    """
    opened, store = open_survey(kit, pilot=pilot)
    opened.need_orders()
    found = progress_of(store, list(opened.orders), opened.manifest.codes, 60 * release_after)
    store.close()
    typer.echo(json.dumps(found.as_json(), indent=2) if as_json else str(found))


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
    normal = normalized(code)
    _, store = open_survey(kit, pilot=pilot)
    outcome = store.withdraw(digest(normal), recruit_digest(normal)) if normal else Withdrawal.UNKNOWN
    store.close()
    if outcome is Withdrawal.UNKNOWN:
        raise InputError(f"{code}: no participant has this code; expected one such as bcdf-ghjk-mnpq-rstv-wxyz-2345")
    if outcome is Withdrawal.PENDING:
        raise EmovidError(
            "the answers are deleted, but another program reads the database, and its log still holds them: "
            "close that program and run this command again"
        )
    if not quiet:
        print("all records of this participant are deleted; delete them in earlier exports, too", file=sys.stderr)


def recruits(kit: KitPath, pilot: Pilot = False) -> None:
    """List the participants of a recruitment service, as CSV.

    Their parameters and outcome (started, finished, failed) tell whom to pay. Nothing joins them with answers.

    Examples: emovid study recruits kit/ > recruits.csv
    """
    opened, store = open_survey(kit, pilot=pilot)
    found = store.recruits()
    store.close()
    names = opened.manifest.recruitment.names if opened.manifest.recruitment else ()
    rows = [[*(parameters.get(name, "") for name in names), outcome] for parameters, outcome in found]
    typer.echo(csv_text([*names, "outcome"], rows), nl=False)
