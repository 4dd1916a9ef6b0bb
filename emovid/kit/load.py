"""From study.yaml to a valid study and the scenes and videos it names."""

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

from emovid.atomic_io import file_digest
from emovid.errors import SourceError, nearest
from emovid.kit.external_videos import check_video
from emovid.kit.model import MAX_VIDEOS, Stimulus, Study
from emovid.responses.key import read_bytes
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene, scene_digest
from emovid.scene.model import Scene
from emovid.scene.validation_messages import complaint
from emovid.swarm.simulate import check_start
from emovid.yaml_source import KeyPath, Places, place_of, read_yaml

NAME = "study.yaml"
_MAX_BYTES = 2_000_000


@dataclass(frozen=True)
class Exemplar:
    """One video to be made: what it shows, before it is blinded.

    Attributes:
        entry: its stimulus, counted from 0 as in study.yaml.
        emotion: the label it stands for.
        source: the scene's name, or the video's.
        number: counted from 0 among those of one scene and one level of each factor.
        factors: the level of each factor.
        scene: or None for a finished video.
        video: the finished video, or None.
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
    """A study with what it names.

    Attributes:
        path: of its study.yaml.
        study: what that says.
        exemplars: the videos to be made, in its order.
    """

    path: Path
    study: Study
    exemplars: tuple[Exemplar, ...]

    def digest(self) -> str:
        """Return the SHA-256 of all that decides a kit besides seed and participants."""
        made_of = [
            scene_digest(item.scene) if item.scene else file_digest(item.video) if item.video else ""
            for item in self.exemplars
        ]
        said = self.study.resolved() | {"participants": None}
        text = json.dumps([version("emovid"), said, made_of], sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


def load_study(source: Path) -> LoadedStudy:
    """Return the study of a study.yaml, or of a folder that holds one.

    Raises:
        SourceError: for a study that cannot be meant, or that names a wrong scene or video: with file, line and key.
    """
    path = source / NAME if source.is_dir() else source
    study, places = _read(path)
    exemplars = tuple(_exemplars(study, path, places))
    _check_shown(study, exemplars, places)
    return LoadedStudy(path, study, exemplars)


def _read(path: Path) -> tuple[Study, Places]:
    data = read_bytes(path)
    if len(data) > _MAX_BYTES:
        raise SourceError(str(path), "too large for a study; expected a study.yaml")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SourceError(str(path), "not UTF-8 text", data[: error.start].count(b"\n") + 1) from None
    try:
        values, places = read_yaml(text, str(path))
    except SourceError as error:
        raise SourceError(error.where, error.message.replace("a scene", "a study"), 0, error.key) from None
    if not isinstance(values, dict):
        raise SourceError(str(path), "not a study: expected keys such as title, question, labels, stimuli")
    try:
        return Study.model_validate(values), places
    except ValidationError as error:
        found = complaint(error, places, Study)
        raise SourceError(found.where, found.message, 0, found.key) from None


def _exemplars(study: Study, path: Path, places: Places) -> Iterator[Exemplar]:
    count = len(study.stimuli) * study.exemplars
    for factor in study.factors.values():
        count *= len(factor)
    if count > MAX_VIDEOS:
        raise SourceError(
            place_of(("stimuli",), places), f"{count} videos; expected at most {MAX_VIDEOS}", 0, "stimuli"
        )
    combinations = [dict(zip(study.factors, chosen, strict=True)) for chosen in product(*study.factors.values())]
    for entry, stimulus in enumerate(study.stimuli):
        at: KeyPath = ("stimuli", entry)
        if stimulus.video is not None:
            video = path.parent / stimulus.video
            emotion = _label(stimulus, None, study, at, places)
            with _blamed_on((*at, "video"), places):
                check_video(video, study.video)
            yield Exemplar(entry, emotion, Path(stimulus.video).stem, video=video)
            continue
        for levels in combinations:
            scene = _scene(study, entry, levels, path, places)
            emotion = _label(stimulus, scene, study, at, places)
            for number in range(study.exemplars):
                yield Exemplar(entry, emotion, Path(str(stimulus.scene)).stem, number, levels, scene)


def _scene(study: Study, entry: int, levels: Mapping[str, str], path: Path, places: Places) -> Scene:
    """Return the scene of a stimulus at one level of each factor, with all that the study sets in it."""
    stimulus = study.stimuli[entry]
    name = str(stimulus.scene)
    file = path.parent / name
    source = name if name in EMOTIONS or not (file.suffix or file.exists()) else file
    groups: list[tuple[KeyPath, Mapping[str, Any]]] = [(("set",), study.set)]
    groups += [(("factors", factor, level), study.factors[factor][level]) for factor, level in levels.items()]
    groups += [(("stimuli", entry, "set"), stimulus.set)]
    settings = [Setting(key, value, place_of((*at, key), places)) for at, keys in groups for key, value in keys.items()]
    look = {"video.size": study.video.size, "video.fps": study.video.fps, "duration": study.video.duration}
    own = {"video.format": "mp4"} | look
    settings += [Setting(key, value, place_of(("video", key.rpartition(".")[2]), places)) for key, value in own.items()]
    with _blamed_on(("stimuli", entry, "scene"), places):
        scene = load_scene(source, settings)
        check_start(scene)
        for overlay, shown in scene.video.overlays:
            if shown:
                raise scene.fault(f"video.overlays.{overlay}", "true: a stimulus shows stage, robots and trails alone")
    return scene


@contextmanager
def _blamed_on(path: KeyPath, places: Places) -> Iterator[None]:
    """Turn what is wrong with a scene or a video into an error on the line of the study that names it."""
    try:
        yield
    except SourceError as error:
        where = place_of(path, places)
        if error.where.startswith(f"{where.rpartition(':')[0]}:"):  # a key that the study itself sets
            raise SourceError(error.where, error.message, 0, error.key) from None
        raise SourceError(where, str(error), 0, ".".join(map(str, path))) from None


def _label(stimulus: Stimulus, scene: Scene | None, study: Study, at: KeyPath, places: Places) -> str:
    """Return the label that a stimulus stands for: the one given beside it, else its scene's emotion."""
    emotion = stimulus.emotion or (scene.emotion if scene else None)
    if emotion in study.labels:
        return str(emotion)
    found = f"{emotion!r} is no label{nearest(emotion, study.labels)}" if emotion else "stands for no emotion"
    key, remedy = ("emotion", "expected") if stimulus.emotion else ("scene", "expected emotion: beside it, with")
    path = (*at, key)
    message = f"{found}; {remedy} one of {', '.join(study.labels)}"
    raise SourceError(place_of(path, places), message, 0, ".".join(map(str, path)))


def _check_shown(study: Study, exemplars: tuple[Exemplar, ...], places: Places) -> None:
    """Refuse to show one video of each emotion where emotions have different numbers of them."""
    counts = {label: sum(item.emotion == label for item in exemplars) for label in study.labels}
    counts = {label: count for label, count in counts.items() if count}
    if study.orders.shown == "one_of_each" and len(set(counts.values())) > 1:
        listed = ", ".join(f"{count} of {label}" for label, count in counts.items())
        path = ("orders", "shown")
        message = f"one_of_each needs as many videos of one emotion as of the others; there are {listed}"
        raise SourceError(place_of(path, places), message, 0, ".".join(path))
