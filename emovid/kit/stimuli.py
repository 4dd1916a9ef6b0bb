"""Blinding: random codes for videos, random differences from the public runs, and rendering."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import atan2, pi
from pathlib import Path
from typing import Any

from emovid.errors import SourceError
from emovid.kit.external_videos import reencode
from emovid.kit.load import Exemplar, LoadedStudy
from emovid.kit.seeded_random import draw, flip, share, video_codes
from emovid.kit.study import Look, Vary
from emovid.kit.symmetry import can_half_turn, can_mirror, can_turn, mirrored, turned
from emovid.scene.behaviour import ContourKeys
from emovid.scene.model import Scene
from emovid.scene.stage import AtRandom
from emovid.scene.video import OwnColours
from emovid.swarm.simulate import check_start, simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.render import render_video

_ATTEMPTS = 50  # seeds to try for a random start with enough room


@dataclass(frozen=True)
class Stimulus:
    """A video with its code.

    Attributes:
        code: its public name.
        exemplar: its content.
        seed: random seed of its run; None for a run without random start.
        mirror: whether it is a mirror image.
        half_turn: whether it is upside down.
        turn: rotation of its contour about the center [rad].
    """

    code: str
    exemplar: Exemplar
    seed: int | None = None
    mirror: bool = False
    half_turn: bool = False
    turn: float = 0.0

    def facts(self) -> dict[str, Any]:
        """Return its row of the private stimuli.csv."""
        item = self.exemplar
        facts = {"video_code": self.code, "true_emotion": item.emotion, "source": item.source, "exemplar": item.number}
        facts |= {"seed": self.seed, "mirror": self.mirror, "half_turn": self.half_turn, "turn": self.turn}
        return facts | dict(item.factors)


def blinded(loaded: LoadedStudy, seed: int) -> list[Stimulus]:
    """Return the stimuli of a study in the order of their codes, which is also the order of making and listing them.

    Raises:
        SourceError: if the robots do not fit, with any of 50 seeds.
    """
    codes = video_codes(seed, len(loaded.exemplars) + len(loaded.extras))
    pairs = zip(codes, loaded.exemplars, strict=False)
    return sorted((_varied(code, item, loaded.study.vary, seed) for code, item in pairs), key=lambda item: item.code)


def extras_of(loaded: LoadedStudy, seed: int) -> list[Stimulus]:
    """Return the practice video and those of attention checks, with codes; their runs are those of their scenes."""
    codes = video_codes(seed, len(loaded.exemplars) + len(loaded.extras))[len(loaded.exemplars) :]
    return [Stimulus(code, item) for code, item in zip(codes, loaded.extras, strict=True)]


def make(stimulus: Stimulus, look: Look, target: Path, seed: int, on_frame: Callable[[int], None]) -> None:
    """Write the video of a stimulus. Raises RenderError if that fails."""
    item = stimulus.exemplar
    if item.scene is None:
        assert item.video is not None  # an exemplar has a scene or a video
        reencode(item.video, target, look, seed)
    else:
        render_video(run_of(stimulus, seed), target, on_frame)


def run_of(stimulus: Stimulus, seed: int) -> Trajectory:
    """Return the run of a stimulus."""
    scene = stimulus.exemplar.scene
    assert scene is not None
    run = simulate(tinted(_reseeded(scene, stimulus.seed), seed))
    if stimulus.turn and isinstance(scene.behaviour, ContourKeys):
        run = turned(run, stimulus.turn, (scene.behaviour.centre.x, scene.behaviour.centre.y))
    if stimulus.half_turn:
        run = turned(run, pi, (0.0, 0.0))
    return mirrored(run) if stimulus.mirror else run


def tinted(scene: Scene, seed: int) -> Scene:
    """Return the scene with each color channel changed by -1, 0 or 1 of 255 levels.

    The change is invisible, the same for all videos of a kit, and makes their bytes differ from those of other kits.
    """
    colours = {
        name: _tint(value, seed, name) if isinstance(value, str) else tuple(_tints(value, seed, name))
        for name, value in scene.video.palette
    }
    video = scene.video.model_copy(update={"colours": OwnColours.model_validate(colours)})
    return scene.model_copy(update={"video": video})


def _tints(colours: Sequence[str], seed: int, name: str) -> list[str]:
    return [_tint(colour, seed, name, i) for i, colour in enumerate(colours)]


def _tint(colour: str, seed: int, *name: object) -> str:
    levels = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    moved = [level + draw(seed, "tint", *name, i) % 3 - 1 for i, level in enumerate(levels)]
    return "#" + "".join(f"{min(max(level, 0), 255):02x}" for level in moved)


def _varied(code: str, item: Exemplar, vary: Vary, seed: int) -> Stimulus:
    """Return the stimulus of an exemplar; every other exemplar of a scene is mirrored."""
    scene = item.scene
    if scene is None:
        return Stimulus(code, item)
    first = flip(seed, "mirror", item.entry, *sorted(item.factors.items()))
    mirror = vary.mirror and can_mirror(scene) and (item.number % 2 == 1) != first
    half_turn = vary.half_turn and can_half_turn(scene) and flip(seed, "half turn", code)
    return Stimulus(
        code,
        item,
        seed=_run_seed(scene, code, seed) if vary.seed and isinstance(scene.start, AtRandom) else None,
        mirror=mirror,
        half_turn=half_turn,
        turn=_turn(scene, code, seed, mirror=mirror, half_turn=half_turn) if vary.turn else 0.0,
    )


def _turn(scene: Scene, code: str, seed: int, *, mirror: bool, half_turn: bool) -> float:
    """Return a rotation [rad] that puts each robot well between two robots of the public run; 0 if not possible.

    All robots look alike: only their positions after rotation, half turn and mirroring count.
    """
    first = _first_angle(scene)
    if first is None:
        return 0.0
    places = draw(seed, "place", code) % scene.robots
    wanted = (
        2 * pi * (places + 0.25 + share(seed, "turn", code) / 2) / scene.robots
    )  # of each robot's angle, in the end
    if mirror:  # an angle a becomes pi - a
        wanted = pi - 2 * first - wanted
    return (wanted - pi * half_turn) % (2 * pi)


@cache  # exemplars of a scene share the result
def _first_angle(scene: Scene) -> float | None:
    """Return the angle of robot 0 about the contour's center at the start [rad]; None for a run that cannot rotate."""
    run = simulate(scene)  # a run that can be rotated has no random start
    if not can_turn(run) or not isinstance(scene.behaviour, ContourKeys):
        return None
    x, y = (run.poses[0, 0, :2] - [scene.behaviour.centre.x, scene.behaviour.centre.y]).tolist()
    return atan2(y, x)


def _run_seed(scene: Scene, code: str, seed: int, attempt: int = 0) -> int:
    """Return a random seed with which the robots fit."""
    found = draw(seed, "run", code, attempt) % 2**63
    try:
        check_start(_reseeded(scene, found))
    except SourceError:
        if attempt + 1 == _ATTEMPTS:
            raise
        return _run_seed(scene, code, seed, attempt + 1)
    return found


def _reseeded(scene: Scene, seed: int | None) -> Scene:
    return scene if seed is None else scene.model_copy(update={"seed": seed})
