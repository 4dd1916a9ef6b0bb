"""The kinds of video, and the encoder's arguments for each: what decides the bytes of a file.

All are made for equal bytes on every processor: `bitexact` everywhere, one thread, nothing in a file that names a time
or a version.
"""

import re
from pathlib import Path
from typing import Literal, NamedTuple

from emovid.scene.video import FormatName


class Format(NamedTuple):
    """A kind of video.

    Attributes:
        suffix: of its files; nothing for a folder of pictures.
        pixels: what the encoder takes, in ffmpeg's words.
        arguments: of the encoder; {gop} stands for the frames of a second.
    """

    suffix: str
    pixels: Literal["yuv420p", "pal8", "rgba"]
    arguments: str


PICTURE = "%05d.png"  # of a sequence, from 00000.png

# The planes come converted; only their colours' meaning is left to say. `setparams` tags all of it, the encoder's own
# options would tag the matrix alone.
_BT709 = "-vf setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709:range=tv"

FORMATS: dict[FormatName, Format] = {
    # H.264 High, one closed GOP a second, no B-frames (every browser seeks to the frame), the index in front. crf 16 is
    # visually lossless. `cpu-independent` makes equal bytes on every processor; `filter_units` drops x264's banner.
    "mp4": Format(
        ".mp4",
        "yuv420p",
        f"{_BT709} -c:v libx264 -preset veryfast -crf 16 -profile:v high -g {{gop}} -keyint_min {{gop}} "
        "-sc_threshold 0 -bf 0 -threads 1 -x264-params cpu-independent=1:open-gop=0 -bsf:v filter_units=remove_types=6 "
        "-movflags +faststart -f mp4",
    ),
    # VP9, likewise: a keyframe a second, every frame shown. At this setting it is near H.264 in quality, size and time.
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
    """Return ffmpeg's arguments between the executable and the output, for frames on its stdin.

    Args:
        width: of the frames [pixels].
        height: likewise.
        fps: frames per second.
        format: of the video.
        crf: the constant rate factor of an mp4 or webm, if not the format's own: the larger, the smaller the file.
    """
    _, pixels, arguments = FORMATS[format]
    if crf is not None:
        arguments = re.sub(r"-crf \d+", f"-crf {crf}", arguments)
    return [
        *("-hide_banner", "-nostdin", "-v", "error", "-y"),
        *("-f", "rawvideo", "-pix_fmt", pixels, "-s", f"{width}x{height}", "-r", str(fps), "-i", "pipe:0", "-an"),
        *arguments.format(gop=fps).split(),
        *("-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1"),
    ]


def is_picture(path: Path) -> bool:
    """Return whether a file is called like one of a sequence."""
    return path.suffix == ".png" and path.stem.isdecimal()
