"""`emovid scene`: look at scenes, check them, start new ones."""

import json
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli.options import Force, Json, Seed, Set, settings
from emovid.errors import InputError

app = typer.Typer(help="List, show, check and make scenes.", no_args_is_help=True)

Scene = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file, or the name of an emotion.")]


@app.command("list")
def list_scenes(as_json: Json = False) -> None:
    """List the shipped scenes."""
    from emovid.scene.emotions import EMOTIONS

    rows = [
        {"emotion": e.name, "behaviour": e.behaviour, "control": e.control, "video": e.video} for e in EMOTIONS.values()
    ]
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    for row in rows:
        typer.echo(f"{row['emotion']:<11}{row['behaviour']:<24}{row['control']:<19}{row['video']}")


@app.command()
def show(scene: Scene, as_json: Annotated[bool, typer.Option("--json", help="Every key, as JSON.")] = False) -> None:
    """Show a scene: its file, which explains every key."""
    from emovid.scene.load import find_scene, load_scene

    resolved = load_scene(scene).resolved()
    typer.echo(json.dumps(resolved, indent=2) if as_json else find_scene(scene).read_text(encoding="utf-8"), nl=as_json)


@app.command()
def check(scene: Scene, assignments: Set = None, seed: Seed = None, as_json: Json = False) -> None:
    """Check a scene: read it, run it, and say how close to the edge and to each other the robots come."""
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
        ("robots", f"{checked.robots} x {checked.robot.model}, {checked.duration:g} s, {checked.frames} frames"),
        ("speed", f"{found.mean_speed:.3f} m/s mean, {found.peak_speed:.3f} m/s peak"),
        ("smallest distance between bodies", distance + (" (they overlap)" if (found.body_distance or 0) < 0 else "")),
        ("periods cut at the stage's edge", f"{found.stage_cut_share:.2%}"),
        ("periods cut to keep bodies apart", f"{found.separation_cut_share:.2%}"),
    ):
        typer.echo(f"  {what + ':':<34} {value}")


@app.command()
def new(
    file: Annotated[Path, typer.Argument(help="The file to write.")],
    source: Annotated[str, typer.Option("--from", help="The scene to start from.")] = "happiness",
    force: Force = False,
) -> None:
    """Start a new scene from a copy of another, comments and all."""
    from emovid.scene.load import find_scene, load_scene
    from emovid.whole_files import make_folder, writing

    load_scene(source)
    if file.exists() and not force:
        raise InputError(f"{file}: exists; --force replaces it")
    text = find_scene(source).read_bytes()
    make_folder(file.parent)
    with writing(file) as target:
        target.write(text)
    typer.echo(f"{file}: a copy of {source}; check it with emovid scene check {file}", err=True)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenes, for completion and hover help in editors."""
    from emovid.scene.schema import scene_schema

    typer.echo(json.dumps(scene_schema(), indent=2))
