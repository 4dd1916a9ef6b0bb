"""`emovid check-platform`: whether a testbed can run a scene."""

import json

import typer

from emovid.cli.options import Json, Platform, Scene, Seed, Set, checked_platform, on_platform, settings


def check_platform(
    scene: Scene,
    platform: Platform = None,
    assignments: Set = None,
    seed: Seed = None,
    as_json: Json = False,
) -> None:
    """Check whether a testbed can run a scene.

    Simulates the scene and checks the run against the rules, the arena and the motors of the testbed; exit with 1 if a
    check fails. A file is checked as it is; an emotion stands for its scene for the platform, robotarium by default.

    Examples: emovid check-platform anger · emovid check-platform my.yaml --platform robotarium-today
    """
    from dataclasses import asdict

    from emovid.platforms.feasibility import TESTBEDS
    from emovid.platforms.feasibility import check_platform as checks_of
    from emovid.scene.emotions import EMOTIONS
    from emovid.scene.load import load_scene
    from emovid.swarm.simulate import simulate

    place = checked_platform(platform or _platform_of(scene))
    name = on_platform(scene, place) if scene in EMOTIONS else scene
    found = checks_of(simulate(load_scene(name, settings(assignments, seed))), TESTBEDS[place])
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
    """Return the platform that the name of a shipped scene begins with, or else the paper's."""
    from emovid.scene.emotions import PLATFORMS

    before = scene.partition("/")[0]
    return before if before in PLATFORMS else PLATFORMS[0]
