"""What `emovid figures` makes figures from, besides the shipped scenes: any scene or run, and a study's results."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emovid.errors import InputError

if TYPE_CHECKING:
    from emovid.figures.catalogue import Entry
    from emovid.figures.material import Material
    from emovid.scene.load import Setting

_MOST_TIMES = 24


def frames_of(sources: list[str], times: str | None, overrides: "Sequence[Setting]") -> "Entry":
    """Return the figure of snapshots of a scene or a run, simulated here: its times are held against it."""
    from emovid.figures.catalogue import Entry
    from emovid.figures.frames import frames_figure
    from emovid.figures.style import DOUBLE_COLUMN
    from emovid.scene.load import find_scene, load_scene
    from emovid.swarm.files import load_trajectory
    from emovid.swarm.simulate import simulate

    if len(sources) != 1:
        raise InputError("frames: expected one scene: a file (.yaml), a finished run (.npz), or an emotion")
    (source,) = sources
    finished = load_trajectory(Path(source), overrides) if source.endswith(".npz") else None
    scene = finished.scene if finished else load_scene(source, overrides)
    chosen = _times(times, scene.emotion, float(finished.t[-1]) if finished else scene.duration)
    run = finished or simulate(scene)
    stem = Path(source).stem if finished else find_scene(source).stem
    said = f"Snapshots at {', '.join(f'{t:g}' for t in chosen)} s"
    return Entry(f"{stem}-frames", "", said, frames_figure, lambda _: (run, chosen), DOUBLE_COLUMN)


def _times(text: str | None, emotion: str | None, end: float) -> list[float]:
    """Return the times [s] given, or those of the paper if the run is as long, or its start, middle and end."""
    from emovid.scene.emotions import EMOTIONS

    if text is None:
        of_paper = list(EMOTIONS[emotion].snapshot_times) if emotion else [end + 1]
        return of_paper if of_paper[-1] <= end else [0.0, end / 2, end]
    try:
        times = [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--times {text}: expected seconds with commas between, as in 0,2,8") from None
    for t in times:
        if not 0 <= t <= end:
            raise InputError(f"--times {text}: {t:g} s is outside the run of 0 to {end:g} s")
    if len(times) > _MOST_TIMES:
        raise InputError(f"--times: {len(times)} times; expected at most {_MOST_TIMES}")
    return times


def study_results(source: Path | None) -> Any:
    """Return the results of a study: those in a file or folder, or an analysis of the reference study."""
    from emovid.figures.study import recognition_of
    from emovid.study.analyze import analyze, analyze_counts
    from emovid.study.matrix import read_results
    from emovid.study.read import read_responses

    if source is None:
        return analyze(read_responses([_reference_study()]), ["gender", "robotics_background"])
    counts, labels, signalled = read_results(source)  # says what is wrong with it
    file = source / "results.json" if source.is_dir() else source
    if file.suffix.lower() != ".json":
        return analyze_counts(counts, labels, signalled)
    results = json.loads(file.read_text(encoding="utf-8"))
    try:
        for column, levels in results["groups"].items():
            if levels:
                recognition_of(results, column)
    except (AttributeError, LookupError, TypeError, ValueError):
        raise InputError(f"{file}: no results; expected the results.json of emovid study analyze") from None
    return results


def _reference_study() -> Path:
    """Return the responses of the reference study."""
    import emovid

    room = Path(emovid.__file__).parent
    folder = room if (room / "studies").is_dir() else room.parent  # a checkout keeps them on top
    return folder / "studies" / "santos-egerstedt" / "responses.csv"


def measures_of(material: "Material") -> dict[str, dict[str, float]]:
    """Return the descriptors of the six emotions."""
    from emovid.measure.describe import describe
    from emovid.scene.emotions import EMOTIONS

    return {emotion: describe(material.run(emotion)) for emotion in EMOTIONS}
