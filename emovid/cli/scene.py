"""`emovid scene`: look at scenes, check them, start new ones."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from emovid.cli import completion
from emovid.cli.options import Force, Json, Platform, Quiet, Scene, Seed, Set, check_file, on_platform, settings
from emovid.cli.scene_diff import diff
from emovid.errors import InputError

if TYPE_CHECKING:
    from emovid.scene import model

app = typer.Typer(help="List, show, check and make scenes.", no_args_is_help=True)


@app.command("list")
def list_scenes(platform: Platform = None, as_json: Json = False) -> None:
    """List the shipped scenes.

    Example: emovid scene list
    """
    from emovid.scene.emotions import EMOTIONS

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


@app.command()
def robots(as_json: Json = False) -> None:
    """List the robots that `robot.model` can name; a file of your own is another.

    Example: emovid scene robots
    """
    from emovid.scene.robot_files import load_robot, shipped_robots

    bodies = [load_robot(name) for name in shipped_robots()]
    if as_json:
        typer.echo(json.dumps([body.model_dump() for body in bodies], indent=2))
        return
    units = {"v_max": "m/s", "omega_max": "rad/s", "wheel_max": "m/s a wheel"}
    for body in bodies:
        limits = body.limits.model_dump(exclude_none=True) if body.limits else {}
        size = "{:g} x {:g} mm".format(*(1000 * side for side in body.shape.box))
        most = ", ".join(f"{value:.3g} {units[name]}" for name, value in limits.items()) or "no limits"
        typer.echo(f"{body.name:<19}{body.kinematics:<19}{size:<16}{most}")


@app.command()
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


@app.command()
def check(scene: Scene, assignments: Set = None, seed: Seed = None, as_json: Json = False) -> None:
    """Check a scene: read it, run it, and say how close to the edge and to each other the robots come.

    Examples: emovid scene check my.yaml · emovid scene check anger --set robots=20 --seed 3
    """
    from dataclasses import asdict

    from emovid.scene.load import load_scene, scene_digest
    from emovid.swarm.simulate import simulate
    from emovid.swarm.summary import summarise

    checked = load_scene(scene, settings(assignments, seed))
    found = summarise(simulate(checked))
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


@app.command()
def new(
    file: Annotated[Path, typer.Argument(help="The file to write.")],
    source: Annotated[
        str, typer.Option("--from", help="The scene to start from.", autocompletion=completion.scenes)
    ] = "happiness",
    platform: Platform = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Start a new scene from a copy of another, comments and all.

    Example: emovid scene new my.yaml --from anger
    """
    from emovid.atomic_io import make_folder, writing

    source = on_platform(source, platform)
    _, text = _read(source)
    check_file(file, str(file))
    if file.exists() and not force:
        raise InputError(f"{file}: exists; --force replaces it")
    make_folder(file.parent)
    with writing(file) as target:
        target.write(text.encode())
    if not quiet:
        typer.echo(f"{file}: a copy of {source}; check it with emovid scene check {file}", err=True)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenes, for completion and hover help in editors.

    Example: emovid scene schema > emovid.schema.json
    """
    from emovid.scene.schema import scene_schema

    typer.echo(json.dumps(scene_schema(), indent=2))


app.command()(diff)


def _read(source: str) -> "tuple[model.Scene, str]":
    """Return a scene and the text of its file, read once: it may be a pipe."""
    from emovid.scene.load import find_scene, parse_scene
    from emovid.scene.resources import read_text

    path = find_scene(source)
    text = read_text(path)
    return parse_scene(text, str(path), folder=path.parent), text
