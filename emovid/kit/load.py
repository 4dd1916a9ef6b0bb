"""Reading a study.yaml, with the scenes and finished videos that it names."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.metadata import version
from itertools import product
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from emovid.atomic_io import file_digest, make_folder, replace_if_changed
from emovid.errors import InputError, SourceError, nearest
from emovid.kit.external_videos import check_video
from emovid.kit.study import MAX_VIDEOS, StimulusKeys, Study, study_schema
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene, scene_digest
from emovid.scene.model import Scene
from emovid.scene.resources import STUDIES, read_text
from emovid.swarm.simulate import check_start
from emovid.yaml_models import source_error, with_schema
from emovid.yaml_source import KeyPath, Places, place_of, read_yaml

NAME = "study.yaml"
_MAX_BYTES = 2_000_000


@dataclass(frozen=True)
class Exemplar:
    """A video to make, before it gets its code.

    Attributes:
        entry: index of its stimulus in study.yaml, from 0.
        emotion: the label that it signals.
        source: name of the scene or of the finished video.
        number: index among the exemplars of one scene and one combination of levels, from 0.
        factors: the level of each factor.
        scene: the scene; None for a finished video.
        video: the finished video; None for a scene.
    """

    entry: int
    emotion: str
    source: str
    number: int = 0
    factors: Mapping[str, str] = field(default_factory=dict)
    scene: Scene | None = None
    video: Path | None = None


@dataclass(frozen=True)
class LoadedStudy:
    """A study, its file, and its exemplars in the order of study.yaml."""

    path: Path
    study: Study
    exemplars: tuple[Exemplar, ...]
    extras: tuple[Exemplar, ...] = ()

    def digest(self) -> str:
        """Return the SHA-256 of everything that determines a kit except seed and number of participants."""
        contents = [
            scene_digest(item.scene) if item.scene else file_digest(item.video) if item.video else ""
            for item in (*self.exemplars, *self.extras)
        ]
        keys = self.study.resolved() | {"participants": None}
        text = json.dumps([version("emovid"), keys, contents], sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


def start_study(folder: Path) -> Path:
    """Write the example study and the schema for editors into a folder, created if missing; return its study.yaml.

    Raises:
        InputError: if the folder contains a study.yaml or a schema of another program.
    """
    file = folder / NAME
    if file.exists():
        raise InputError(f"{file}: exists; expected another folder")
    files = with_schema(read_text(STUDIES / "example" / NAME, "study"), file, study_schema())
    make_folder(folder)
    for path, data in files.items():
        replace_if_changed(path, data)
    return file


def load_study(source: Path) -> LoadedStudy:
    """Return the study of a study.yaml, or of a folder that holds one.

    Raises:
        SourceError: for an invalid study, or one that names an invalid scene or video, with file, line and key.
    """
    path = source / NAME if source.is_dir() else source
    values, places = read_yaml(read_text(path, "study", _MAX_BYTES), str(path), "study")
    if not isinstance(values, dict):
        raise SourceError(str(path), "not a study: expected keys such as title, question, labels, stimuli")
    try:
        study = Study.model_validate(values)
    except ValidationError as error:
        raise source_error(error, places, Study) from None
    exemplars = tuple(_exemplars(study, path, places))
    _check_one_of_each(study, exemplars, places)
    return LoadedStudy(path, study, exemplars, tuple(_extras(study, path, places)))


def _error(path: KeyPath, places: Places, message: str) -> SourceError:
    return SourceError(place_of(path, places), message, key=".".join(map(str, path)))


def _exemplars(study: Study, path: Path, places: Places) -> Iterator[Exemplar]:
    combinations = [dict(zip(study.factors, levels, strict=True)) for levels in product(*study.factors.values())]
    count = len(study.stimuli) * study.exemplars * len(combinations)
    if count > MAX_VIDEOS:
        raise _error(("stimuli",), places, f"{count} videos; expected at most {MAX_VIDEOS}")
    for entry, stimulus in enumerate(study.stimuli):
        at: KeyPath = ("stimuli", entry)
        if stimulus.video is not None:
            video = path.parent / stimulus.video
            emotion = _label(stimulus, None, study, at, places)
            with _errors_at((*at, "video"), places):
                check_video(video, study.video)
            yield Exemplar(entry, emotion, Path(stimulus.video).stem, video=video)
            continue
        for levels in combinations:
            scene = _scene(study, stimulus, at, levels, path, places)
            emotion = _label(stimulus, scene, study, at, places)
            for number in range(study.exemplars):
                yield Exemplar(entry, emotion, Path(str(stimulus.scene)).stem, number, levels, scene)


def _extras(study: Study, path: Path, places: Places) -> Iterator[Exemplar]:
    """Yield the videos beside the stimuli: the practice video, if there is one, and those of the attention checks."""
    extras: list[tuple[KeyPath, StimulusKeys]] = [(("practice",), study.practice)] if study.practice else []
    extras += [(("checks", i), check) for i, check in enumerate(study.checks)]
    for at, stimulus in extras:
        if stimulus.video is None:
            yield Exemplar(-1, "", Path(str(stimulus.scene)).stem, scene=_scene(study, stimulus, at, {}, path, places))
            continue
        video = path.parent / stimulus.video
        with _errors_at((*at, "video"), places):
            check_video(video, study.video)
        yield Exemplar(-1, "", Path(stimulus.video).stem, video=video)


def _scene(
    study: Study, stimulus: StimulusKeys, at: KeyPath, levels: Mapping[str, str], path: Path, places: Places
) -> Scene:
    """Return the scene of a stimulus at one level of each factor, with the keys that the study sets."""
    name = str(stimulus.scene)
    file = path.parent / name
    source = name if name in EMOTIONS or not (file.suffix or file.exists()) else file
    groups: list[tuple[KeyPath, Mapping[str, Any]]] = [(("set",), study.set)]
    groups += [(("factors", factor, level), study.factors[factor][level]) for factor, level in levels.items()]
    groups += [((*at, "set"), stimulus.set)]
    settings = [
        Setting(key, value, place_of((*group, key), places)) for group, keys in groups for key, value in keys.items()
    ]
    common = {"video.format": "mp4", "video.size": study.video.size, "video.fps": study.video.fps}
    common["duration"] = study.video.duration
    settings += [
        Setting(key, value, place_of(("video", key.rpartition(".")[2]), places)) for key, value in common.items()
    ]
    with _errors_at((*at, "scene"), places):
        scene = load_scene(source, settings)
        check_start(scene)
        if scene.frames != study.video.frames:
            key = "speed" if scene.video.speed != 1 else "end" if scene.video.end else "begin"
            value = getattr(scene.video, key)
            raise scene.fault(f"video.{key}", f"{value:g}: a stimulus shows its whole run, at the speed of the run")
        for overlay, shown in scene.video.overlays:
            if shown:
                raise scene.fault(f"video.overlays.{overlay}", "true: a stimulus shows only stage, robots and trails")
    return scene


@contextmanager
def _errors_at(path: KeyPath, places: Places) -> Iterator[None]:
    """Turn an error in a scene or a video into one on the line of the study that names it."""
    try:
        yield
    except SourceError as error:
        where = place_of(path, places)
        if error.where.startswith(f"{where.rpartition(':')[0]}:"):  # a key that the study itself sets
            raise SourceError(error.where, error.message, 0, error.key) from None
        raise _error(path, places, str(error)) from None


def _label(stimulus: StimulusKeys, scene: Scene | None, study: Study, at: KeyPath, places: Places) -> str:
    """Return the label that a stimulus signals: its own `emotion`, or else that of its scene."""
    emotion = stimulus.emotion or (scene.emotion if scene else None)
    if emotion in study.labels:
        return str(emotion)
    found = f"{emotion!r} is not a label{nearest(emotion, study.labels)}" if emotion else "has no emotion"
    key, remedy = ("emotion", "expected") if stimulus.emotion else ("scene", "expected an additional emotion,")
    raise _error((*at, key), places, f"{found}; {remedy} one of {', '.join(study.labels)}")


def _check_one_of_each(study: Study, exemplars: tuple[Exemplar, ...], places: Places) -> None:
    """Refuse to show one video of each emotion where emotions have different numbers of videos."""
    counts = {label: sum(item.emotion == label for item in exemplars) for label in study.labels}
    counts = {label: count for label, count in counts.items() if count}
    if study.orders.shown == "one_of_each" and len(set(counts.values())) > 1:
        listed = ", ".join(f"{count} of {label}" for label, count in counts.items())
        message = f"one_of_each: expected equally many videos of each emotion; found {listed}"
        raise _error(("orders", "shown"), places, message)
