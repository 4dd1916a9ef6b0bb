import struct

import pytest

from emovid.errors import RenderError
from emovid.kit.mp4 import boxes, content_size, moov_size, pad_to_equal_size
from emovid.video.ffmpeg import count_frames
from tests.helpers.small_survey import small_kit


def box(kind: bytes, body: bytes = b"") -> bytes:
    return struct.pack(">I4s", 8 + len(body), kind) + body


def test_boxes_in_containers_are_found_with_their_offsets() -> None:
    large = struct.pack(">I4sQ", 1, b"mdat", 16 + 3) + b"abc"  # its size in 64 bits
    data = box(b"ftyp", b"isom") + box(b"moov", box(b"mvhd", b"1") + box(b"trak", box(b"tkhd"))) + large
    found = [(item.kind, item.start, len(item.body)) for item in boxes(data)]
    assert found == [
        ("ftyp", 0, 4),
        ("moov", 12, 25),
        ("mvhd", 20, 1),
        ("trak", 29, 8),
        ("tkhd", 37, 0),
        ("mdat", 45, 3),
    ]
    assert all(data[start + 4 : start + 8].decode() == kind for kind, start, _ in found)


@pytest.mark.parametrize("data", [b"abc", box(b"free")[:-1], struct.pack(">I4s", 7, b"free"), b"\0\0\0\x09free"])
def test_invalid_mp4_boxes_are_refused(data) -> None:
    with pytest.raises(ValueError, match=r"no (complete )?box at byte 12"):
        list(boxes(box(b"ftyp", b"isom") + data))


def test_only_a_trailing_free_box_counts_as_padding(tmp_path) -> None:
    data = box(b"free", b"12") + box(b"mdat", b"abc")
    assert content_size(data) == len(data)
    assert content_size(data + box(b"free", bytes(5))) == len(data)


def test_files_are_padded_to_equal_length_once(tmp_path) -> None:
    short, long = tmp_path / "short.mp4", tmp_path / "long.mp4"
    short.write_bytes(box(b"mdat"))
    long.write_bytes(box(b"mdat", bytes(100)) + box(b"free", bytes(999)))
    pad_to_equal_size([short, long])
    assert short.read_bytes() == box(b"mdat") + box(b"free", bytes(100))
    assert long.read_bytes() == box(b"mdat", bytes(100)) + box(b"free")
    pad_to_equal_size([short, long])
    assert long.read_bytes() == box(b"mdat", bytes(100)) + box(b"free")
    long.write_bytes(b"none")
    with pytest.raises(RenderError, match=r"long\.mp4: not an MP4 file: no box at byte 0"):
        pad_to_equal_size([short, long])


def test_frame_tables_get_equal_sizes_and_keep_all_frames(tmp_path) -> None:
    kit = small_kit(tmp_path)
    videos = sorted((kit / "public" / "videos").iterdir())
    assert len({moov_size(video.read_bytes()) for video in videos}) == 1
    assert len({video.stat().st_size for video in videos}) == 1
    before = {video: (video.read_bytes(), count_frames(video)) for video in videos}
    assert {frames for _, frames in before.values()} == {5}
    pad_to_equal_size(videos)  # a repetition changes nothing
    assert {video: video.read_bytes() for video in videos} == {video: data for video, (data, _) in before.items()}
