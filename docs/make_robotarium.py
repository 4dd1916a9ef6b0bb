"""Write the tables of docs/robotarium.md and docs/export-robotarium.md between their markers.

The first has parameters and descriptors of each platform; the second compares runs of the exported scripts, in a
stand-in of the Robotarium's simulator 1.x, with ours.
"""

import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from emovid.measure.describe import DESCRIPTORS, describe
from emovid.platforms.robotarium import ARENAS, robotarium_script
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import Setting, load_scene
from emovid.scene.model import Scene
from emovid.swarm.simulate import simulate
from tests.helpers import rps_stand_in

PLACES = ("", *PLATFORMS)
SHOWN = (
    "speed_mean", "speed_peak", "distance_travelled", "turning_per_metre", "sharp_corner_share", "cusps_per_second",
    "sparc", "hull_area_share_mean", "nearest_neighbour_end", "overshoot_share", "cost_ratio",
)  # fmt: skip
EXPORTED = {
    "speed_mean": "mean speed [m/s]",
    "turning_per_metre": "turning [rad/m]",
    "sharp_corner_share": "share of sharp corners",
    "cusps_per_metre": "cusps per meter",
    "radius_of_gyration_end": "radius of gyration at the end [m]",
    "cost_ratio": "cost relative to the converged cost",
}
EXPORT_SEEDS = range(1, 6)
_ALIKE = {"emotion", "seed", "video", "safety"}  # of all scenes, or said in the text


def leaves(data: object, path: str = "") -> dict[str, object]:
    """Return the values of nested groups by dotted key."""
    if isinstance(data, dict):
        return {key: value for name, item in data.items() for key, value in leaves(item, f"{path}.{name}").items()}
    return {path.removeprefix("."): data}


def keys_of(scene: Scene) -> dict[str, object]:
    """Return the keys of a scene that may differ between platforms, with the robot by name."""
    keys = scene.resolved()
    keys["robot"] |= {"model": scene.robot.body.name, "limits": "model" if scene.robot.limits else None}
    return leaves({name: value for name, value in keys.items() if name not in _ALIKE})


def named(place: str, emotion: str) -> str:
    """Return the name of the scene of an emotion on a platform."""
    return f"{place}/{emotion}" if place else emotion


def parameters(emotion: str) -> list[list[str]]:
    """Return a row for each key of the scene of an emotion that differs between platforms."""
    scenes = [load_scene(named(place, emotion)) for place in PLACES]
    keys = [keys_of(scene) for scene in scenes]
    for known, scene in zip(keys, scenes, strict=True):
        known["snapshots"] = ", ".join(f"{t:g}" for t in scene.snapshot_times or ())
    return [
        [f"`{key}`", *(_text(known.get(key)) for known in keys)]
        for key in dict.fromkeys(key for known in keys for key in known)
        if len({_text(known.get(key)) for known in keys}) > 1
    ]


def descriptors(emotion: str) -> list[list[str]]:
    """Return a row for each descriptor, measured up to the last snapshot."""
    found = [describe(simulate(load_scene(named(place, emotion)))) for place in PLACES]
    rows = []
    for name in SHOWN:
        values = [f"{values[name]:.3g}" for values in found]
        if set(values) != {"nan"}:
            rows.append([f"`{name}` [{DESCRIPTORS[name].unit}]", *values])
    return rows


def tables() -> str:
    """Return all tables as Markdown."""
    head = ["simulation", *PLATFORMS]
    parts = []
    for emotion in EMOTIONS:
        parts += [
            f"### {emotion.capitalize()}",
            _table(["parameter", *head], parameters(emotion)),
            _table(["descriptor", *head], descriptors(emotion)),
        ]
    return "\n\n".join(parts)


def script_table() -> str:
    """Return the descriptors of chaotic scenes and of their scripts over the whole length, mean and deviation."""
    columns = []
    for emotion in ("fear", "disgust", "anger"):
        ours, scripts = [], []
        for seed in EXPORT_SEEDS:
            scene = load_scene(f"robotarium-today/{emotion}", [Setting("seed", seed, "--seed")])
            simulator, _ = rps_stand_in.run(
                robotarium_script(scene, emotion, ARENAS["3.2x2.0"]), rps_stand_in.Robotarium1
            )
            ours.append(describe(simulate(scene), 0.0, scene.duration))
            scripts.append(describe(simulator.run_of(scene), 0.0, scene.duration))
        columns += [ours, scripts]
    head = [f"mean and standard deviation of {len(EXPORT_SEEDS)} seeds"]
    head += [name for emotion in ("fear", "disgust", "anger") for name in (f"{emotion}: emovid", "script")]
    rows = [
        [label, *(_spread([run[name] for run in column]) for column in columns)] for name, label in EXPORTED.items()
    ]
    return _table(head, rows)


def _spread(values: list[float]) -> str:
    mean, deviation = float(np.mean(values)), float(np.std(values, ddof=1))
    digits = max(0, 2 - int(np.floor(np.log10(mean))))
    return f"{mean:.{digits}f} ± {deviation:.{digits}f}"


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _text(value: object) -> str:
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def with_tables(page: str, made: str) -> str:
    """Return the page with the tables between its markers replaced."""
    return re.sub(r"(?<=<!-- tables -->\n).*(?=<!-- end -->)", lambda _: f"\n{made}\n\n", page, flags=re.DOTALL)


def main(folder: Path) -> None:
    """Write the tables into both pages."""
    for name, made in (("robotarium.md", tables()), ("export-robotarium.md", script_table())):
        page = (folder / name).read_text(encoding="utf-8")
        (folder / name).write_text(with_tables(page, made), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
