"""`emovid scene`: list, show, check, compare and create scenes."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from emovid.atomic_io import make_folder
from emovid.cli import completion
from emovid.cli.options import (
    Force,
    Json,
    Platform,
    Quiet,
    Scene,
    Seed,
    Set,
    check_file,
    on_platform,
    settings,
    warn_of,
)
from emovid.errors import InputError
from emovid.scene import model
from emovid.scene.difference import ABSENT, Difference, differences
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import (
    find_scene,
    load_robot,
    load_scene,
    moved_scene,
    parse_scene,
    scene_digest,
    scene_schema,
    shipped_robots,
)
from emovid.scene.resources import read_text
from emovid.swarm.simulate import simulate
from emovid.swarm.summary import summarize
from emovid.workflows.outputs import STDOUT, write_outputs
from emovid.yaml_models import with_schema

_SHOWN = 60  # characters of a value in the table; --json has all


def list_scenes(platform: Platform = None, as_json: Json = False) -> None:
    """List the shipped scenes.

    Example: emovid scene list
    """
    rows = [
        {
            "emotion": on_platform(e.name, platform),
            "behaviour": e.behaviour,
            "control": e.control,
            "video": e.video,
        }
        for e in EMOTIONS.values()
    ]
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    width = 2 + max(len(row["emotion"]) for row in rows)
    for row in rows:
        typer.echo(f"{row['emotion']:<{width}}{row['behaviour']:<24}{row['control']:<19}{row['video']}")


def robots(as_json: Json = False) -> None:
    """List the robots that `robot.model` can name.

    `robot.model` can also name a robot file of your own.

    Example: emovid scene robots
    """
    bodies = [load_robot(name) for name in shipped_robots()]
    if as_json:
        typer.echo(json.dumps([body.model_dump() for body in bodies], indent=2))
        return
    units = {"v_max": "m/s", "omega_max": "rad/s", "wheel_max": "m/s per wheel"}
    for body in bodies:
        limits = body.limits.model_dump(exclude_none=True) if body.limits else {}
        size = "{:g} x {:g} mm".format(*(1000 * side for side in body.shape.box))
        most = ", ".join(f"{value:.3g} {units[name]}" for name, value in limits.items()) or "no limits"
        typer.echo(f"{body.name:<19}{body.kinematics:<19}{size:<16}{most}")


def show(
    scene: Scene,
    platform: Platform = None,
    as_json: Annotated[bool, typer.Option("--json", help="Every key, as JSON.")] = False,
) -> None:
    """Show a scene: its file, which explains every key.

    Examples: emovid scene show anger · emovid scene show my.yaml --json
    """
    valid, text = _read(on_platform(scene, platform))
    typer.echo(json.dumps(valid.resolved(), indent=2) if as_json else text, nl=as_json)


def check(scene: Scene, assignments: Set = None, seed: Seed = None, as_json: Json = False) -> None:
    """Check a scene: simulate it and report what happens.

    Reports speeds, the smallest distance between robots, and how often motion was cut at the edge of the stage.

    Examples: emovid scene check my.yaml · emovid scene check anger --set robots=20 --seed 3
    """
    checked = load_scene(scene, settings(assignments, seed))
    found = summarize(simulate(checked))
    warn_of(checked, quiet=as_json)
    if as_json:
        typer.echo(json.dumps({"scene": scene, "scene_digest": scene_digest(checked), **asdict(found)}, indent=2))
        return
    distance = "one robot" if found.body_distance is None else f"{1000 * found.body_distance:.1f} mm"
    typer.echo(f"{scene}: valid")
    for what, value in (
        ("robots", f"{checked.robots} x {checked.robot.body.name}, {checked.duration:g} s, {checked.frames} frames"),
        ("speed", f"{found.mean_speed:.3f} m/s mean, {found.peak_speed:.3f} m/s peak"),
        ("smallest distance between bodies", distance + (" (they overlap)" if (found.body_distance or 0) < 0 else "")),
        ("periods cut at the stage's edge", f"{found.stage_cut_share:.2%}"),
        ("periods cut to keep bodies apart", f"{found.separation_cut_share:.2%}"),
    ):
        typer.echo(f"  {what + ':':<34} {value}")


def new(
    file: Annotated[Path, typer.Argument(help="The file to write; - prints it.")],
    source: Annotated[
        str, typer.Option("--from", help="The scene to start from.", autocompletion=completion.scenes)
    ] = "happiness",
    platform: Platform = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Create a scene as a copy of another, with its comments.

    The JSON Schema beside it lets editors complete and check its keys.

    Example: emovid scene new my.yaml --from anger
    """
    source = on_platform(source, platform)
    _, text = _read(source)
    if file == STDOUT:
        typer.echo(text, nl=False)
        return
    check_file(file, str(file), (".yaml", ".yml"))
    if file.exists() and not force:
        raise InputError(f"{file}: exists; use --force to overwrite it")
    files = with_schema(moved_scene(text, find_scene(source), file), file, scene_schema())
    make_folder(file.parent)
    write_outputs(files, force=True)
    if not quiet:
        typer.echo(f"{file}: a copy of {source}; check it with emovid scene check {file}", err=True)


def schema() -> None:
    """Print the JSON Schema of scenes, for completion and help in editors.

    Example: emovid scene schema > emovid.schema.json
    """
    typer.echo(json.dumps(scene_schema(), indent=2))


def diff(first: Scene, second: Scene, as_json: Json = False) -> None:
    """List the keys that differ between two scenes.

    Compares every key, including defaults, but not comments; exit with 1 if any key differs.

    Examples: emovid scene diff anger my.yaml · emovid scene diff fear disgust --json
    """
    found = differences(load_scene(first), load_scene(second))
    if as_json:
        rows = [{"key": row.key} | _present(first=row.first, second=row.second) for row in found]
        typer.echo(json.dumps({"first": first, "second": second, "differences": rows}, indent=2))
    elif found:
        _show(first, second, found)
    if found:
        raise typer.Exit(1)


def _present(**values: Any) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not ABSENT}


def _show(first: str, second: str, rows: Sequence[Difference]) -> None:
    """Print a line for each key: the key, and its value in the one scene and in the other."""
    cells = [("key", first, second), *((row.key, _text(row.first), _text(row.second)) for row in rows)]
    key, value = (max(len(row[column]) for row in cells) for column in (0, 1))
    for row in cells:
        typer.echo(f"{row[0]:<{key}}  {row[1]:<{value}}  {row[2]}")


def _text(value: Any) -> str:
    """Return a value as written in a scene, or a dash for a missing key."""
    text = "-" if value is ABSENT else value if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."


def _read(source: str) -> tuple[model.Scene, str]:
    """Return a scene and the text of its file, read once: it may be a pipe."""
    path = find_scene(source)
    text = read_text(path)
    return parse_scene(text, str(path), folder=path.parent), text
