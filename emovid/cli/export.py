"""`emovid export`: scenes for other machines."""

import json
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli import completion
from emovid.cli.options import Emotion, Json, Quiet, Seed, Set, Source, one_source, output_file, settings
from emovid.errors import InputError, nearest

_FOLDER = "upload"
# The shipped scenes for each arena.
_SCENES = {"3.2x2.0": "robotarium-today", "4.3x3.6": "robotarium"}


def robotarium(
    source: Source = None,
    emotion: Emotion = None,
    every: Annotated[bool, typer.Option("--all", "-a", help="All six emotions.")] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A folder, made if missing, or a .py file.", show_default=_FOLDER),
    ] = None,
    arena: Annotated[
        str,
        typer.Option(
            help="3.2x2.0 m as today, or 4.3x3.6 m as in the paper.", autocompletion=completion.words(*_SCENES)
        ),
    ] = "3.2x2.0",
    trails: Annotated[
        bool, typer.Option("--trails", help="Draw the scene's trails, which the testbed projects on its floor.")
    ] = False,
    assignments: Set = None,
    seed: Seed = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a scene as an experiment script for the Robotarium.

    The script is one file, for the Robotarium's simulator and for upload. The name of an emotion stands for the scene
    that ships for the arena.

    Examples: emovid export robotarium anger --trails · emovid export robotarium my.yaml -o my_experiment.py
    """
    from emovid.atomic_io import make_folder, writing
    from emovid.platforms.robotarium import ARENAS, robotarium_script
    from emovid.scene.emotions import EMOTIONS
    from emovid.scene.load import find_scene, load_scene, scene_digest

    if arena not in ARENAS:
        raise InputError(f"--arena {arena}: expected {' or '.join(ARENAS)}{nearest(arena, ARENAS)}")
    if every and (source or emotion):
        raise InputError("--all: expected no scene beside it")
    written = []
    for chosen in EMOTIONS if every else [one_source(source, emotion)]:
        name = f"{_SCENES[arena]}/{chosen}" if chosen in EMOTIONS else chosen
        scene, stem = load_scene(name, settings(assignments, seed)), find_scene(name).stem
        target = output_file(output, f"{stem}.py", _FOLDER, (".py",), (".m", ".yaml", ".txt"))
        text = robotarium_script(scene, stem, ARENAS[arena], trails=trails)
        written.append((target, text, {"file": str(target), "scene_digest": scene_digest(scene), "seed": scene.seed}))
    if len({target for target, _, _ in written}) < len(written):
        raise InputError(f"-o {output}: is one file; expected a folder for six scripts")
    for target, text, _ in written:
        make_folder(target.parent)
        with writing(target) as file:
            file.write(text.encode())
        if not (quiet or as_json):
            typer.echo(f"{target}: for the Robotarium's arena of {ARENAS[arena]}", err=True)
    if as_json:
        typer.echo(json.dumps([facts for _, _, facts in written], indent=2))
