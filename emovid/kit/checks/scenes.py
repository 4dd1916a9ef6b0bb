"""Whether a stimulus shows the very run of a public scene, which anybody can make again and compare."""

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emovid.kit.checks.finding import Finding
from emovid.kit.manifest import Video
from emovid.kit.read import Kit
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import Setting, load_scene
from emovid.swarm.simulate import simulate
from emovid.video import ffmpeg
from emovid.video.canvas import Pixels
from emovid.video.painter import Painter

# Pictures of one run correlate with 0.999 before and after encoding; of a stimulus and of its scene's public run, with
# 0.82 at most at 1280x720, 0.984 at 160x90 (25 and 60 kits).
_SAME = 0.99
_SEEN = 20  # levels of grey by which robots and trails, at least, differ from the stage
_WHEN = (0.0, 0.3, 0.6, 0.9)  # of the duration: the frames that are compared

Picture = NDArray[np.float64]


def check_scenes(kit: Kit) -> Iterator[Finding]:
    """Check that no stimulus shows a public scene's run as it is, however it is encoded.

    Frames are compared, not bytes: equal bytes are equal frames, and a copy that was encoded again is one, too.
    """
    like = kit.manifest.videos[0]
    paths = {video.file: kit.folder.public / video.file for video in kit.manifest.videos}
    decoded = {file: _decoded(path, like) for file, path in paths.items() if path.is_file()}
    everything = [picture for pictures in decoded.values() for picture in pictures]
    if not everything:
        return
    stage = np.median(everything, axis=0)
    for name in EMOTIONS:
        shown = _drawn(name, like.frames, like.fps, f"{like.width}x{like.height}")
        for file, pictures in decoded.items():
            if likeness(pictures, shown, stage) > _SAME:
                yield Finding("scenes", file, "shows the run of a public scene", (name,))


def likeness(first: Sequence[Picture], second: Sequence[Picture], stage: Picture) -> float:
    """Return the least correlation of two videos' pictures, each as it differs from the empty stage's."""
    if len(first) != len(second):
        return 0.0
    return min(_correlation(a - stage, b - stage) for a, b in zip(first, second, strict=True))


@cache
def _drawn(emotion: str, frames: int, fps: int, size: str) -> list[Picture]:
    """Return the compared frames of a public scene, run for as long as the videos are."""
    keys = {"duration": frames / fps, "video.size": size, "video.fps": fps}
    scene = load_scene(emotion, [Setting(key, value, "manifest.json") for key, value in keys.items()])
    painter = Painter(simulate(scene))
    return [_grey(painter.frame(k / fps)[..., :3]) for k in _numbers(frames)]


def _decoded(path: Path, like: Video) -> list[Picture]:
    """Return the compared frames of a file, in the size of another; fewer, if it has fewer."""
    chosen = "+".join(f"eq(n\\,{k})" for k in _numbers(like.frames))
    filters = f"select={chosen},scale={like.width}:{like.height}:in_color_matrix=bt709:in_range=tv,format=rgb24"
    source = ["-v", "error", "-nostdin", "-i", ffmpeg.address(path), "-vf", filters, "-fps_mode", "passthrough"]
    data = ffmpeg.run([*source, "-f", "rawvideo", "-"]).data
    size = 3 * like.width * like.height
    frames = [data[i : i + size] for i in range(0, len(data), size)]
    shape = like.height, like.width, 3
    return [_grey(np.frombuffer(frame, np.uint8).reshape(shape)) for frame in frames if len(frame) == size]


def _numbers(frames: int) -> list[int]:
    return sorted({int(share * frames) for share in _WHEN})


def _grey(picture: Pixels) -> Picture:
    return picture.astype(float) @ [0.2126, 0.7152, 0.0722]


def _correlation(first: Picture, second: Picture) -> float:
    seen = (np.abs(first) > _SEEN) | (np.abs(second) > _SEEN)
    scale = float(np.sqrt((first[seen] ** 2).sum() * (second[seen] ** 2).sum()))
    return float((first[seen] * second[seen]).sum()) / scale if scale else 0.0
