"""`emovid doctor`: check the installation."""

import json
from pathlib import Path
from typing import Annotated

import typer

from emovid.workflows.doctor import checks


def doctor(as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False) -> None:
    """Check this installation, and suggest a remedy for each problem.

    Checks packages, scenes, encoding in each format, fonts, folders, browser and extras; exit with 1 if a required
    check fails. A missing extra is not a failure.

    Examples: emovid doctor · emovid doctor --json
    """
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
        typer.echo(f"{len(failed)} required checks fail" if failed else "all required checks pass")
    if failed:
        raise typer.Exit(1)
