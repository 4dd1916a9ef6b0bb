"""`emovid doctor`: does everything work here, and what helps if not."""

import json
from pathlib import Path

import typer

from emovid.cli.options import Json


def doctor(as_json: Json = False) -> None:
    """Check this installation, and suggest a remedy for each problem.

    Checks packages, scenes, encoding in each format, fonts, folders, browser and extras; exit with 1 if a required
    check fails. A missing extra is no failure.

    Examples: emovid doctor · emovid doctor --json
    """
    from emovid.workflows.doctor import checks

    found = []
    for check in checks(Path.cwd()):
        found.append(check)
        if not as_json:
            state = "ok" if check.passed else "FAILED" if check.needed else "missing"
            typer.echo(f"{state:<8} {check.name}: {check.found}")
            if check.remedy:
                typer.echo(f"{'':<8} remedy: {check.remedy}")
    failed = [check for check in found if check.needed and not check.passed]
    if as_json:
        typer.echo(json.dumps({"passed": not failed, "checks": [check._asdict() for check in found]}, indent=2))
    else:
        typer.echo(f"{len(failed)} needed things fail" if failed else "all that is needed works")
    if failed:
        raise typer.Exit(1)
