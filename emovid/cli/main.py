"""The `emovid` command, and the one place where errors become a line on stderr and an exit code."""

import errno
import gc
import os
import signal
import sys
from io import TextIOWrapper
from typing import Annotated, NoReturn

import typer
from typer.exceptions import TyperException

from emovid.cli import export, scene, study
from emovid.cli.check_platform import check_platform
from emovid.cli.doctor import doctor
from emovid.cli.figures import figures
from emovid.cli.measure import measure
from emovid.cli.preview import preview
from emovid.cli.render import render
from emovid.cli.simulate import simulate
from emovid.cli.status import status, verify
from emovid.cli.sweep import sweep
from emovid.errors import EmovidError, say_warnings_in_one_line

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command()(render)
app.command()(preview)
app.command()(simulate)
app.command()(measure)
app.command("check-platform")(check_platform)
app.command()(sweep)
app.command()(status)
app.command()(verify)
app.command()(figures)
app.command()(doctor)
app.add_typer(export.app, name="export")
app.add_typer(scene.app, name="scene")
app.add_typer(study.app, name="study")


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"emovid {version('emovid')}")
        raise typer.Exit


@app.callback()
def _emovid(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Videos, figures and user studies of emotions expressed by a robot swarm (Santos and Egerstedt, 2021).

    Exit codes: 0 for done; 1 for a failure, or a check that found something;
    2 for a mistake in what was given; 130 or 143 for an interruption.

    Examples: emovid render --emotion anger · emovid preview my.yaml --watch · emovid COMMAND --help
    """


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 1 for a failure, 2 for bad input, 130 or 143 for a signal."""
    try:
        # Without standalone mode Typer returns the code of an Exit, 130 for a Ctrl-C, and raises what a user did wrong.
        # It ends the program itself, with 1, where whoever reads our output has had enough, as `head` does.
        code = int(app(arguments, prog_name="emovid", standalone_mode=False) or 0)
        return _say("interrupted: run again to make what is missing", code) if code == 130 else code
    except EmovidError as error:
        return _say(str(error), error.exit_code)
    except TyperException as error:
        return _say(error.format_message(), error.exit_code)
    except MemoryError:
        return _say("not enough memory: fewer robots, a longer control_period or a shorter duration need less", 1)
    except OSError as error:  # that no command has foreseen, such as a name longer than the system takes
        from emovid.atomic_io import reason

        place = f"{error.filename}: " if error.filename else ""
        return _say(place + reason(error), 2 if error.errno == errno.ENAMETOOLONG else 1)


def _say(message: str, code: int) -> int:
    print(" ".join(message.split()), file=sys.stderr)
    return code


def _on_sigterm(*_: object) -> NoReturn:
    raise SystemExit(143)


def run() -> NoReturn:
    """Run as a program, which a SIGTERM ends like a Ctrl-C: what is under way is undone."""
    signal.signal(signal.SIGTERM, _on_sigterm)
    if isinstance(sys.stdout, TextIOWrapper):  # as stderr: signs that the encoding lacks, names that are no Unicode
        sys.stdout.reconfigure(errors="backslashreplace")
    say_warnings_in_one_line()
    # Commands are short. Threads that wait to help with larger matrices than ours would cost each 0.2 s; looking for
    # garbage, 0.05 s during imports and 0.1 s at the end, when all that is left goes anyway.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(100_000)
    code = main()
    gc.freeze()
    sys.exit(code)
