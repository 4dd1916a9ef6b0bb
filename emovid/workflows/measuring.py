"""Measuring scenes, finished runs and recorded motion, and checking the paper's claims."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path

from emovid.csv_writer import csv_text
from emovid.errors import InputError, nearest
from emovid.measure.claim_metrics import claim_metrics
from emovid.measure.claims import Verdict, exceptions, judge
from emovid.measure.describe import DESCRIPTORS, describe
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting
from emovid.swarm.simulate import simulate
from emovid.swarm.tracks import load_positions
from emovid.swarm.trajectory import RecordedTrajectory, Trajectory, sampled
from emovid.workflows.rendering import Source, load_source

Descriptors = dict[str, dict[str, float]]  # by source and name


@dataclass(frozen=True)
class Measured:
    """Results of `measure`.

    Attributes:
        scenes: the chosen descriptors of each source.
        verdicts: on the claims; empty without a gate.
        without_anger: claims that leave out anger for robots with motors, and the source of that.
        recorded: sources of recorded motion, whose descriptors of commands and density are missing.
    """

    scenes: Descriptors
    verdicts: list[Verdict]
    without_anger: Mapping[str, str]
    recorded: list[str]


def chosen_descriptors(only: str | None) -> list[str]:
    """Return the descriptors of names, or beginnings of names, with commas between, in their order; all for None.

    Raises:
        InputError: for a word that does not begin a name.
    """
    if only is None:
        return list(DESCRIPTORS)
    words = [word.strip() for word in only.split(",")]
    for word in words:
        if not word or not any(name.startswith(word) for name in DESCRIPTORS):
            expected = f"expected descriptors, or how names begin, as in cusps,cost{nearest(word, DESCRIPTORS)}"
            raise InputError(f"--only {only}: {expected}")
    return [name for name in DESCRIPTORS if name in words or name.startswith(tuple(set(words) - DESCRIPTORS.keys()))]


def measure_sources(
    sources: Sequence[str],
    settings: Sequence[Setting],
    shown: Sequence[str],
    done: Callable[[str], None],
    *,
    gate: bool = False,
    same_rate: bool = False,
) -> Measured:
    """Return the descriptors of sources, and the verdicts on the claims.

    Args:
        sources: scenes, emotions, finished runs, tracks, and CSV files of positions.
        settings: keys of their scenes to replace.
        shown: names of the descriptors to return.
        done: called with each source that is measured.
        gate: whether to check the claims: the sources are one of each emotion.
        same_rate: whether runs are sampled at the times of the recorded motion among the sources.

    Raises:
        InputError: for sources that do not fit the options; as loading and simulating do.
    """
    loaded = {source: load_source(source, settings) for source in sources if not _is_csv(source)}
    emotions = [source.scene.emotion for source in loaded.values()]
    if gate and sorted(map(str, emotions)) != sorted(EMOTIONS):
        raise InputError(f"--gate: expected one scene of each emotion; given {', '.join(map(str, emotions))}")
    positions = _positions(sources, loaded)
    real = _only_recording(sources, loaded, positions) if same_rate else None
    found: Descriptors = {}
    metrics: Descriptors = {}
    recorded = []
    for source in sources:
        run = positions[source] if source in positions else _run(loaded[source])
        if real is not None and not isinstance(run, RecordedTrajectory):
            run = sampled(run, real.t)
        if isinstance(run, RecordedTrajectory):
            recorded.append(source)
        end = min(float(run.t[-1]), float(real.t[-1])) if real is not None else None
        found[source] = describe(run, end=end)
        if gate:
            metrics[str(run.scene.emotion)] = claim_metrics(run)
        done(source)
    motors = all(source.scene.robot.limits for source in loaded.values())
    return Measured(
        {source: {name: values[name] for name in shown} for source, values in found.items()},
        judge({name: metrics[name] for name in EMOTIONS}, motors=motors) if gate else [],
        exceptions(motors=motors),
        recorded,
    )


def measures_csv(scenes: Mapping[str, Mapping[str, float]]) -> str:
    """Return one row for each source and descriptor; a missing value is an empty cell."""
    rows = [
        (scene, name, "" if isnan(value) else value, DESCRIPTORS[name].unit)
        for scene, values in scenes.items()
        for name, value in values.items()
    ]
    return csv_text(("scene", "descriptor", "value", "unit"), rows)


def _is_csv(source: str) -> bool:
    return Path(source).suffix.lower() == ".csv"


def _run(source: Source) -> Trajectory:
    return simulate(source.scene) if source.run is None else source.run


def _positions(sources: Sequence[str], loaded: Mapping[str, Source]) -> dict[str, RecordedTrajectory]:
    """Return the motion of the CSV files, on the stage of the first scene."""
    files = [source for source in sources if _is_csv(source)]
    if files and not loaded:
        needed = f"expected a scene in addition, as in emovid measure {files[0]} anger, or a .track.yaml"
        raise InputError(f"{files[0]}: positions without a stage and a robot; {needed}")
    like = next(iter(loaded.values()), None)
    return {file: load_positions(Path(file), like.scene) for file in files if like}


def _only_recording(
    sources: Sequence[str], loaded: Mapping[str, Source], positions: Mapping[str, RecordedTrajectory]
) -> RecordedTrajectory:
    runs = [positions[source] if source in positions else loaded[source].run for source in sources]
    recordings = [run for run in runs if isinstance(run, RecordedTrajectory)]
    if len(recordings) != 1:
        raise InputError(f"--same-rate: expected one recorded motion among the sources; given {len(recordings)}")
    return recordings[0]
