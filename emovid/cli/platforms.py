"""`emovid check-platform` and `emovid export robotarium`: scenes for testbeds."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli import completion
from emovid.cli.options import (
    Emotion,
    Force,
    Json,
    Platform,
    Quiet,
    Scene,
    Seed,
    Set,
    Source,
    checked_platform,
    on_platform,
    one_source,
    output_file,
    settings,
)
from emovid.errors import InputError, nearest
from emovid.platforms.feasibility import TESTBEDS
from emovid.platforms.feasibility import check_platform as feasibility_checks
from emovid.platforms.robotarium import ARENAS, robotarium_script
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import find_scene, load_scene, scene_digest
from emovid.swarm.simulate import simulate
from emovid.workflows.outputs import STDOUT, write_outputs

# The shipped scenes for each arena.
_ARENA = "3.2x2.0"
_SCENES = {_ARENA: "robotarium-today", "4.3x3.6": "robotarium"}


def check_platform(
    scene: Scene,
    platform: Platform = None,
    assignments: Set = None,
    seed: Seed = None,
    as_json: Json = False,
) -> None:
    """Check whether a testbed can run a scene.

    Simulates the scene and checks the run against the rules, the arena and the motors of the testbed; exit with 1 if a
    check fails. A file is checked as it is; an emotion stands for its scene for the platform. The default platform is
    robotarium-today.

    Examples: emovid check-platform anger · emovid check-platform my.yaml --platform robotarium-today
    """
    place = checked_platform(platform or _platform_of(scene))
    name = on_platform(scene, place) if scene in EMOTIONS else scene
    found = feasibility_checks(simulate(load_scene(name, settings(assignments, seed))), TESTBEDS[place])
    failed = sum(not check.holds for check in found)
    if as_json:
        report = {"scene": name, "platform": place, "holds": not failed, "checks": list(map(asdict, found))}
        typer.echo(json.dumps(report, indent=2))
    else:
        typer.echo(f"{name} on {place}")
        for check in found:
            word = "FAILS" if not check.holds else "holds" if check.expected else ""
            expected = f" (expected {check.expected})" if check.expected else ""
            typer.echo(f"  {word:<6} {check.name + ':':<40} {check.found}{expected}")
        typer.echo(f"{failed} of {len(found)} checks fail" if failed else "can run there")
    if failed:
        raise typer.Exit(1)


def _platform_of(scene: str) -> str:
    """Return the platform in the name of a shipped scene, or else that of today, as for `emovid export`."""
    before = scene.partition("/")[0]
    return before if before in PLATFORMS else _SCENES[_ARENA]


def robotarium(
    source: Source = None,
    emotion: Emotion = None,
    every: Annotated[bool, typer.Option("--all", "-a", help="All six emotions.")] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="A folder, created if missing, a .py file, or - to print it.", show_default="upload"
        ),
    ] = None,
    arena: Annotated[
        str,
        typer.Option(
            help="3.2x2.0 m as today, or 4.3x3.6 m as in the paper.", autocompletion=completion.words(*_SCENES)
        ),
    ] = _ARENA,
    trails: Annotated[
        bool, typer.Option("--trails", help="Draw the scene's trails, which the testbed projects on its floor.")
    ] = False,
    assignments: Set = None,
    seed: Seed = None,
    force: Force = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a scene as an experiment script for the Robotarium.

    The script is one file, for the Robotarium's simulator and for upload. The name of an emotion stands for the scene
    that ships for the arena.

    Examples: emovid export robotarium anger --trails · emovid export robotarium my.yaml -o my_experiment.py
    """
    if arena not in ARENAS:
        raise InputError(f"--arena {arena}: expected {' or '.join(ARENAS)}{nearest(arena, ARENAS)}")
    if every and (source or emotion):
        raise InputError("--all: cannot be combined with a scene")
    scripts = {}
    for chosen in EMOTIONS if every else [one_source(source, emotion)]:
        name = f"{_SCENES[arena]}/{chosen}" if chosen in EMOTIONS else chosen
        scene, stem = load_scene(name, settings(assignments, seed)), find_scene(name).stem
        target = STDOUT if output == STDOUT else output_file(output, f"{stem}.py", "upload", (".py",))
        if target in scripts:
            raise InputError(f"-o {output}: is one file; expected a folder for six scripts")
        scripts[target] = scene, robotarium_script(scene, stem, ARENAS[arena], trails=trails).encode()
    write_outputs({target: script for target, (_, script) in scripts.items()}, force=force)
    if as_json:
        facts = [
            {"file": str(target), "scene_digest": scene_digest(scene), "seed": scene.seed}
            for target, (scene, _) in scripts.items()
        ]
        typer.echo(json.dumps(facts, indent=2))
    elif not quiet:
        for target in scripts:
            typer.echo(f"{target}: for the Robotarium's arena of {ARENAS[arena]}", err=True)
