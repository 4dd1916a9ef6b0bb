"""`emovid simulate`: a scene to a trajectory."""

import json
from pathlib import Path
from typing import Annotated

import typer

from emovid.cli.options import (
    Emotion,
    Json,
    Platform,
    Quiet,
    Seed,
    Set,
    Source,
    on_platform,
    one_source,
    output_file,
    settings,
)

_OTHER_FILES = (
    *(".npy", ".json", ".parquet", ".mat", ".txt", ".tsv", ".xlsx", ".xls", ".ods", ".h5", ".hdf5", ".feather", ".pkl"),
    *(".yaml", ".yml", ".mp4", ".webm", ".gif"),
)


def simulate(
    source: Source = None,
    emotion: Emotion = None,
    platform: Platform = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="A file ending in .npz or .csv, or a folder.", show_default="SCENE.npz"),
    ] = None,
    assignments: Set = None,
    seed: Seed = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate a scene without drawing it.

    Examples: emovid simulate --emotion fear -o fear.npz · emovid simulate my.yaml --seed 3 -o my.csv
    """
    from emovid.atomic_io import make_folder
    from emovid.cli.progress import counting
    from emovid.scene.load import find_scene, load_scene
    from emovid.swarm.files import SUFFIXES, save_trajectory
    from emovid.swarm.simulate import check_start
    from emovid.swarm.simulate import simulate as run

    chosen = on_platform(one_source(source, emotion), platform)
    scene = load_scene(chosen, settings(assignments, seed))
    target = output_file(
        output,
        f"{find_scene(chosen).stem}.npz",
        ".",
        SUFFIXES,
        _OTHER_FILES,
    )
    check_start(scene)
    make_folder(target.parent)
    with counting(target.name, quiet=quiet or as_json) as on_period:
        trajectory = run(scene, on_period)
    save_trajectory(trajectory, target)
    if as_json:
        facts = {"file": str(target), "trajectory_sha256": trajectory.digest(), "samples": len(trajectory.t)}
        typer.echo(json.dumps(facts | {"robots": scene.robots, "seed": scene.seed}, indent=2))
    elif not quiet:
        typer.echo(f"{target}: {scene.robots} robots, {len(trajectory.t)} samples in {scene.duration:g} s", err=True)
