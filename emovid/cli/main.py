"""The `emovid` command: the table of commands, and the one place where errors become one line and an exit code."""

import errno
import gc
import signal
import sys
from collections.abc import Iterable
from importlib import import_module
from typing import Annotated, Any, NamedTuple, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup
from typer.exceptions import TyperException

import emovid
from emovid.cli.environment import set_up_libraries, set_up_streams
from emovid.errors import EmovidError, reason, say_warnings_in_one_line


class Entry(NamedTuple):
    """One command: its name, "MODULE:FUNCTION" in `emovid.cli`, its help in one line, and its heading in the help."""

    name: str
    source: str
    help: str
    heading: str | None = None


COMMANDS = (
    Entry("render", "render:render", "Render scenes as videos; videos that are up to date are kept."),
    Entry("preview", "render:preview", "Show a scene at a glance: a small loop or a contact sheet, within seconds."),
    Entry("simulate", "render:simulate", "Simulate a scene without drawing it."),
    Entry("measure", "measure:measure", "Measure how scenes move, and check the paper's claims about them."),
    Entry("check-platform", "platforms:check_platform", "Check whether a testbed can run a scene."),
    Entry("sweep", "sweep:sweep", "Make every missing or outdated item of a sweep, and a table of the results."),
    Entry("status", "status:status", "List what is missing, stale or corrupt in a folder of results."),
    Entry("verify", "status:verify", "Recompute the hashes of all files that a folder's manifest records."),
    Entry("figures", "figures:figures", "Make the paper's figures and tables, ready for print."),
    Entry("doctor", "doctor:doctor", "Check this installation, and suggest a remedy for each problem."),
)
GROUPS = {
    "export": (
        "Export scenes to other platforms.",
        (Entry("robotarium", "platforms:robotarium", "Write a scene as an experiment script for the Robotarium."),),
    ),
    "scene": (
        "List, show, check, compare and create scenes.",
        (
            Entry("list", "scene:list_scenes", "List the shipped scenes."),
            Entry("robots", "scene:robots", "List the robots that `robot.model` can name."),
            Entry("show", "scene:show", "Show a scene: its file, which explains every key."),
            Entry("check", "scene:check", "Check a scene: simulate it and report what happens."),
            Entry("new", "scene:new", "Create a scene as a copy of another, with its comments."),
            Entry("schema", "scene:schema", "Print the JSON Schema of scenes, for completion and help in editors."),
            Entry("diff", "scene:diff", "List the keys that differ between two scenes."),
        ),
    ),
    "study": (
        "Plan, build, run and analyze a user study.",
        (
            Entry("power", "planning:power", "Plan how many participants a study needs.", "Plan"),
            Entry("plan", "planning:plan", "Plan a whole study by simulation.", "Plan"),
            Entry("simulate", "planning:simulate", "Simulate the responses of participants.", "Plan"),
            Entry("new", "kit:new", "Create a study file that follows the paper's procedure.", "Build"),
            Entry("build", "kit:build", "Build a kit: videos under random codes, orders, the key.", "Build"),
            Entry("update", "kit:update", "Correct texts of a finished kit, as a new version.", "Build"),
            Entry("audit", "kit:audit", "Search a kit for anything that reveals an emotion to participants.", "Build"),
            Entry("export", "kit:export", "Export a kit to a survey tool, as a data set or a draft.", "Build"),
            Entry("serve", "survey:serve", "Serve a kit as a web survey until Ctrl-C.", "Run"),
            Entry("progress", "survey:progress", "Show how many participants enrolled, finished and left.", "Run"),
            Entry("responses", "survey:responses", "Write the answers of a web survey as a table.", "Run"),
            Entry("withdraw", "survey:withdraw", "Delete the data of a participant who withdraws.", "Run"),
            Entry("recruits", "survey:recruits", "List the participants of a recruitment service, as CSV.", "Run"),
            Entry(
                "columns",
                "analysis:columns",
                "Show the role of each column of an export, and the evidence for it.",
                "Analyze",
            ),
            Entry("analyze", "analysis:analyze", "Analyze survey exports: matrix, tests, figures, report.", "Analyze"),
            Entry(
                "schema",
                "study_schema:schema",
                "Print the JSON Schema of study.yaml, of map.yaml or of results.json.",
                "Analyze",
            ),
            Entry("model", "study_model:model", "Compare groups and conditions in a mixed logistic model.", "Analyze"),
            Entry("compare", "analysis:compare", "Compare a replication with the original study.", "Analyze"),
        ),
    ),
}


class ListedCommand(TyperCommand):
    """A command in a list of commands: its module is imported when it runs or is asked for help or completion."""

    def __init__(self, entry: Entry) -> None:
        super().__init__(entry.name, help=entry.help, rich_help_panel=entry.heading)
        self.entry = entry

    def load(self) -> TyperCommand:
        """Return the command itself."""
        module, _, function = self.entry.source.partition(":")
        alone = typer.Typer(add_completion=False)
        alone.command(self.entry.name)(getattr(import_module(f"emovid.cli.{module}"), function))
        command = typer.main.get_command(alone)
        assert isinstance(command, TyperCommand)
        return command

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Parse the command line of the command itself."""
        return self.load().make_context(*arguments, **options)


class _Root(TyperGroup):
    """All commands and groups, none of them imported."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands.update(_listed(COMMANDS))
        for name, (text, entries) in GROUPS.items():
            self.add_command(TyperGroup(name=name, help=text, commands=_listed(entries), no_args_is_help=True))


def _listed(entries: Iterable[Entry]) -> dict[str, Any]:
    return {entry.name: ListedCommand(entry) for entry in entries}


app = typer.Typer(
    cls=_Root,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def all_commands() -> TyperGroup:
    """Return the command line with every command imported, for documentation and tests."""
    root = typer.main.get_command(app)
    assert isinstance(root, TyperGroup)
    groups = [group for group in (root, *root.commands.values()) if isinstance(group, TyperGroup)]
    for group in groups:
        for name, command in group.commands.items():
            group.commands[name] = command.load() if isinstance(command, ListedCommand) else command
    return root


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"emovid {emovid.__version__}")
        raise typer.Exit


@app.callback()
def _emovid(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Videos, figures and user studies of emotions expressed by a robot swarm (Santos and Egerstedt, 2021).

    Exit codes: 0 for success; 1 for a failure, or a check that found something;
    2 for invalid input; 130 or 143 for an interruption.

    Examples: emovid render --emotion anger · emovid preview my.yaml --watch · emovid COMMAND --help
    """


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code: 0, 1 for a failure, 2 for bad input, 130 or 143 for a signal."""
    try:
        # Without standalone mode Typer returns the code of an Exit, 130 for Ctrl-C, and raises usage errors. If the
        # reader of our output stops reading, as `head` does, Typer exits by itself with 1.
        code = int(typer.main.get_command(app)(arguments, prog_name="emovid", standalone_mode=False) or 0)
        return _fail("interrupted: run again to make what is missing", code) if code == 130 else code
    except SystemExit as stop:
        if stop.code == 143:
            return _fail("terminated: run again to make what is missing", 143)
        raise
    except EmovidError as error:
        return _fail(str(error), 1 if _is_denied(error) else error.exit_code)
    except TyperException as error:
        return _fail(error.format_message(), error.exit_code)
    except MemoryError:
        return _fail("not enough memory: fewer robots, a longer control_period or a shorter duration need less", 1)
    except OSError as error:  # that no command handles, such as a file name that is too long for the system
        place = f"{error.filename}: " if error.filename else ""
        return _fail(place + reason(error), 2 if error.errno == errno.ENAMETOOLONG else 1)


def _is_denied(error: BaseException | None) -> bool:
    """Return whether an error comes from missing permissions, for reading or writing."""
    while error and not isinstance(error, PermissionError):
        error = error.__context__
    return error is not None


def _fail(message: str, code: int) -> int:
    print(" ".join(message.split()), file=sys.stderr)
    return code


def _on_sigterm(*_: object) -> NoReturn:
    raise SystemExit(143)


def run() -> NoReturn:
    """Run as a program; SIGTERM ends it like Ctrl-C, and work in progress is undone."""
    signal.signal(signal.SIGTERM, _on_sigterm)
    set_up_streams()
    set_up_libraries()
    say_warnings_in_one_line()
    # Commands are short: garbage collection costs 0.05 s during imports, and 0.1 s at exit, where all memory is freed
    # anyway.
    gc.set_threshold(100_000)
    code = main()
    gc.freeze()
    sys.exit(code)
