"""The six study videos: properties read from the files, not from the ffmpeg arguments."""

import struct
from pathlib import Path

import numpy as np
import pytest

from emovid.cli.main import main
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene
from emovid.swarm.simulate import simulate
from emovid.video.painter import Painter
from tests.helpers.mp4 import boxes, decoded, only, stream_line, table

FRAMES, FPS, WIDTH, HEIGHT = 450, 30, 1280, 720


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    target = tmp_path_factory.mktemp("all") / "videos"
    assert main(["render", "--all", "--jobs", "2", "-o", str(target), "--quiet"]) == 0
    return target


@pytest.fixture(params=EMOTIONS)
def video(request, folder) -> Path:
    return folder / f"{request.param}.mp4"


def test_stream_format_is_playable_in_browsers(video) -> None:
    line = stream_line(video)  # one stream: no audio
    for fact in ("Video: h264 (High)", "yuv420p(tv, bt709", "1280x720", "30 fps"):
        assert fact in line, line
    assert "Audio" not in line


def luma(picture: np.ndarray) -> np.ndarray:
    return picture[..., :3] @ np.array([0.2126, 0.7152, 0.0722])


def test_every_decoded_frame_matches_the_drawn_frame(video) -> None:
    wanted = (0, 1, 45, 244, FRAMES - 1)
    frames = {k: frame for k, frame in enumerate(decoded(video, WIDTH, HEIGHT)) if k in wanted or k >= FRAMES}
    assert max(frames) == FRAMES - 1
    painter = Painter(simulate(load_scene(video.stem)))
    for k in wanted:
        others = [n for n in (k - 3, k, k + 3) if 0 <= n < FRAMES]  # sadness needs three frames for a pixel
        error = {n: np.abs(luma(frames[k]) - luma(painter.frame(n / FPS))).mean() for n in others}
        assert error[k] < 1.0, k  # rounding to 8-bit YUV, and quantizer 24
        assert min(error, key=error.__getitem__) == k, error  # no frame early or late
    colours = frames[0][[5, 40], WIDTH // 2].astype(int)
    assert colours == pytest.approx(np.array([[0xE3, 0xE4, 0xE8], [0xFA, 0xFA, 0xF7]]), abs=2)


def test_index_precedes_the_data(video) -> None:
    kinds = [box.kind for box in boxes(video)]
    assert kinds.index("ftyp") == 0
    assert kinds.index("moov") < kinds.index("mdat")
    assert kinds.count("trak") == 1


def test_the_frame_rate_is_constant(video) -> None:
    ((count, delta),) = table(only(video, "stts"), ">II")
    timescale = struct.unpack_from(">I", only(video, "mdhd").body, 12)[0]
    assert (count, timescale / delta) == (FRAMES, FPS)
    assert not [box for box in boxes(video) if box.kind == "ctts"]  # no B-frames: shown in the order of decoding
    assert struct.unpack_from(">II", only(video, "stsz").body, 4)[1] == FRAMES


def test_each_second_is_a_closed_group_of_pictures(video) -> None:
    keyframes = [row[0] for row in table(only(video, "stss"), ">I")]
    assert keyframes == list(range(1, FRAMES + 1, FPS))


def test_all_color_tags_are_present(video) -> None:
    place = only(video, "stsd").body.index(b"colr")
    kind, primaries, transfer, matrix = struct.unpack_from(">4sHHH", only(video, "stsd").body, place + 4)
    assert (kind, primaries, transfer, matrix) == (b"nclx", 1, 1, 1)


def test_file_contains_no_identifying_metadata(video) -> None:
    data = video.read_bytes().lower()
    for word in (*(emotion.encode() for emotion in EMOTIONS), b"emovid", b"x264 - core", b"lavf", b"crf=", b"2026"):
        assert word not in data, word
    for name in ("mvhd", "tkhd", "mdhd"):
        assert struct.unpack_from(">II", only(video, name).body, 4) == (0, 0)  # created, modified
    assert only(video, "udta").body.endswith(b"\0\0\0\x08ilst")  # the list of tags is empty


def test_all_six_videos_share_length_size_and_rate(folder) -> None:
    videos = sorted(folder.glob("*.mp4"))
    assert [path.stem for path in videos] == sorted(EMOTIONS)
    lines = {stream_line(path).split(" kb/s")[0].rsplit(",", 1)[0] for path in videos}
    assert len(lines) == 1, lines
    assert len({only(path, "stts").body for path in videos}) == 1
