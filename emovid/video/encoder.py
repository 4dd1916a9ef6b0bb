"""Videos from frames: formats, the encoder's arguments for each, and complete files under their final names.

The arguments decide the bytes of a file. They give equal bytes on every processor: `bitexact` everywhere, one thread,
and no time or version in the file.
"""

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Literal, NamedTuple

from emovid.atomic_io import whole_file, whole_folder
from emovid.errors import InputError, RenderError
from emovid.scene.video import FormatName, Video
from emovid.video import ffmpeg
from emovid.video.canvas import Pixels


class Format(NamedTuple):
    """A video format.

    Attributes:
        suffix: of its files; empty for a folder of pictures.
        pixels: pixel format of the frames, in ffmpeg's words.
        arguments: of the encoder; {gop} stands for the number of frames in a second.
    """

    suffix: str
    pixels: Literal["yuv420p", "pal8", "rgba"]
    arguments: str


_QUANTIZER_OVER_CRF, _MAX_QUANTIZER = 8, 51  # of x264; measured on the six videos
PICTURE = "%05d.png"  # of a sequence, from 00000.png

# Frames arrive as Y, U and V; `setparams` labels their color space completely, the encoder's own options only in part.
_BT709 = "-vf setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709:range=tv"

FORMATS: dict[FormatName, Format] = {
    # H.264 High, one closed GOP a second, no B-frames (every browser seeks to the frame), the index in front. Quantizer
    # 24 is visually lossless: as crf 16 in size and better in SSIM, in 0.7 of its time, since there is no lookahead;
    # `ipratio` spends the bits on keyframes, which the still background repeats. `cpu-independent` makes equal bytes on
    # every processor; `filter_units` drops x264's banner.
    "mp4": Format(
        ".mp4",
        "yuv420p",
        f"{_BT709} -c:v libx264 -preset veryfast -qp 24 -profile:v high -g {{gop}} -keyint_min {{gop}} "
        "-sc_threshold 0 -bf 0 -threads 1 "
        "-x264-params cpu-independent=1:open-gop=0:ipratio=2.5:partitions=all:weightp=0 "
        "-bsf:v filter_units=remove_types=6 -movflags +faststart -f mp4",
    ),
    # VP9 with a keyframe a second and no hidden frames; at this setting near H.264 in quality, size and time.
    "webm": Format(
        ".webm",
        "yuv420p",
        f"{_BT709} -c:v libvpx-vp9 -crf 24 -b:v 0 -deadline realtime -cpu-used 6 -lag-in-frames 0 -auto-alt-ref 0 "
        "-g {gop} -keyint_min {gop} -threads 1 -row-mt 0 -f webm",
    ),
    "gif": Format(".gif", "pal8", "-c:v gif -threads 1 -f gif"),
    "png-sequence": Format("", "rgba", "-c:v png -pix_fmt rgb24 -pred mixed -threads 1 -start_number 0 -f image2"),
}


def encoder_arguments(
    width: int, height: int, fps: int, format: FormatName = "mp4", crf: int | None = None
) -> list[str]:
    """Return ffmpeg's arguments between the executable and the output, for frames on its standard input.

    Args:
        width: of the frames [pixels].
        height: of the frames [pixels].
        fps: frames per second.
        format: of the video.
        crf: quality of an mp4 or webm in place of the format's own, as a constant rate factor: a larger one makes a
            smaller file. An mp4 takes the constant quantizer of about the same size.
    """
    _, pixels, arguments = FORMATS[format]
    if crf is not None:
        arguments = re.sub(r"-crf \d+", f"-crf {crf}", arguments)
        arguments = re.sub(r"-qp \d+", f"-qp {min(crf + _QUANTIZER_OVER_CRF, _MAX_QUANTIZER)}", arguments)
    return [
        *("-hide_banner", "-nostdin", "-v", "error", "-y"),
        *("-f", "rawvideo", "-pix_fmt", pixels, "-s", f"{width}x{height}", "-r", str(fps), "-i", "pipe:0", "-an"),
        *arguments.format(gop=fps).split(),
        *("-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1"),
    ]


def video_arguments(video: Video, crf: int | None = None) -> list[str]:
    """Return the encoder's arguments for a scene's video. See `encoder_arguments`."""
    return encoder_arguments(video.width, video.height, video.fps, video.format, crf)


def write_video(
    frames: Iterable[Pixels],
    count: int,
    arguments: list[str],
    target: Path,
    on_frame: Callable[[int], None] | None = None,
) -> None:
    """Encode frames into a file, which appears only when ffmpeg has succeeded and the number of frames is right.

    Args:
        frames: in the encoder's pixel format; a frame may reuse the buffer of the one before.
        count: number of frames.
        arguments: see `encoder_arguments`.
        target: in an existing folder; a file there stays until the new one is complete.
        on_frame: called with the number of frames encoded; an exception of it ends the encoding.

    Raises:
        RenderError: if ffmpeg fails, with its own message.
    """
    with whole_file(target) as part:
        ffmpeg.encode(frames, [*arguments, ffmpeg.address(part)], target, on_frame)
        _check_count(ffmpeg.count_frames(part), count, target)


def write_pictures(
    frames: Iterable[Pixels],
    count: int,
    arguments: list[str],
    target: Path,
    on_frame: Callable[[int], None] | None = None,
) -> None:
    """Encode frames into a folder, as 00000.png and so on. See `write_video`.

    Raises:
        InputError: if `target` exists and is not a folder of such pictures.
        RenderError: if ffmpeg fails, with its own message.
    """
    check_sequence(target)
    with whole_folder(target) as part:
        output = ffmpeg.address(part).replace("%", "%%") + f"/{PICTURE}"
        ffmpeg.encode(frames, [*arguments, output], target, on_frame)
        _check_count(len(list(part.iterdir())), count, target)


def check_sequence(target: Path) -> None:
    """Raise an `InputError` if `target` exists and is not a folder of pictures of a sequence: it would be replaced."""
    if target.is_dir() and (others := sorted(path.name for path in target.iterdir() if not _is_picture(path))):
        raise InputError(f"{target}: holds {others[0]}, which is not a picture of a sequence; expected a new folder")
    if target.exists() and not target.is_dir():
        raise InputError(f"{target}: is a file; expected a folder for pictures")


def _is_picture(path: Path) -> bool:
    return path.suffix == ".png" and path.stem.isdecimal()


def _check_count(found: int, expected: int, target: Path) -> None:
    if found != expected:
        raise RenderError(f"{target}: ffmpeg wrote {found} of {expected} frames")
