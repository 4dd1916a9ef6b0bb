import os
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from emovid.errors import SourceError
from emovid.scene.emotions import EMOTIONS
from emovid.scene.load import load_scene, parse_scene, scene_digest, scene_text, shipped_scene
from emovid.scene.picture import MAX_BYTES, MAX_SIDE, picture_of
from emovid.swarm.files import load_trajectory, save_trajectory
from emovid.swarm.simulate import simulate

FEAR = shipped_scene("fear").read_text(encoding="utf-8")


@pytest.fixture
def scene_file(tmp_path) -> Path:
    """Write a scene whose density is a picture, and the picture next to it."""
    keys = "    kind: image\n    file: maps/map.png\n    smoothing: 0.05"
    lines = ["    kind: image" if line.startswith("    kind: uniform") else line for line in FEAR.splitlines()]
    text = "\n".join(lines).replace("    kind: image", keys)
    (tmp_path / "maps").mkdir()
    (tmp_path / "scene.yaml").write_text(text)
    save(tmp_path, np.arange(0, 240, 2).reshape(10, 12))
    return tmp_path / "scene.yaml"


def save(folder: Path, values: np.ndarray, mode: str | None = None) -> None:
    picture = Image.fromarray(values.astype(np.uint16 if mode == "I;16" else np.uint8))
    picture.save(folder / "maps" / "map.png")


def test_picture_path_is_relative_to_the_scene_and_pixels_are_stored_in_it(scene_file, monkeypatch) -> None:
    monkeypatch.chdir("/")
    density = load_scene(scene_file).behaviour.density
    picture = picture_of(density.pixels)
    assert (picture.width, picture.height) == (12, 10)
    assert list(picture.values) == list(range(0, 240, 2))


def test_scene_with_a_loaded_picture_needs_no_file(scene_file, tmp_path) -> None:
    scene = load_scene(scene_file)
    run = simulate(scene.model_copy(update={"duration": 1.0}))
    save_trajectory(run, tmp_path / "run.npz")
    (tmp_path / "maps" / "map.png").unlink()
    assert parse_scene(scene_text(scene), "text").resolved() == scene.resolved()
    again = load_trajectory(tmp_path / "run.npz").scene
    assert simulate(again).digest() == run.digest()


def test_digest_depends_on_the_pixels_of_the_picture(scene_file, tmp_path) -> None:
    before = scene_digest(load_scene(scene_file))
    Image.open(tmp_path / "maps" / "map.png").convert("RGBA").save(tmp_path / "maps" / "map.png", compress_level=0)
    assert scene_digest(load_scene(scene_file)) == before
    save(tmp_path, np.arange(1, 241, 2).reshape(10, 12))
    assert scene_digest(load_scene(scene_file)) != before


def test_large_pictures_are_reduced(scene_file, tmp_path) -> None:
    save(tmp_path, np.kron(np.arange(0, 240, 2).reshape(10, 12), np.ones((64, 64))))
    picture = picture_of(load_scene(scene_file).behaviour.density.pixels)
    assert (picture.width, picture.height) == (MAX_SIDE, 107)
    assert picture.values[0] == 0
    assert picture.values[-1] == 238


def test_transparent_pixels_count_as_white(scene_file, tmp_path) -> None:
    values = np.zeros((4, 4, 4), np.uint8)
    values[1, 2, 3] = 255
    save(tmp_path, values)
    picture = picture_of(load_scene(scene_file).behaviour.density.pixels)
    assert list(picture.values) == [255] * 6 + [0] + [255] * 9


def cut_off(path: Path) -> None:
    save(path.parents[1], np.random.default_rng(0).integers(0, 255, (64, 64)))
    path.write_bytes(path.read_bytes()[:2000])


def with_header(path: Path, header: bytes) -> None:
    """Replace the header of a PNG, with a correct checksum."""
    png, chunk = path.read_bytes(), b"IHDR" + header
    path.write_bytes(png[:8] + len(header).to_bytes(4) + chunk + zlib.crc32(chunk).to_bytes(4) + png[33:])


def animated_without_frames(path: Path) -> None:
    png, chunk = path.read_bytes(), b"acTL" + bytes(8)
    path.write_bytes(png[:33] + (8).to_bytes(4) + chunk + zlib.crc32(chunk).to_bytes(4) + png[33:])


SPOILT = {
    "too large: more than 32 MB": lambda path: os.truncate(path, MAX_BYTES + 1),
    "too large: more pixels than any density needs": lambda path: with_header(
        path, 2 * (20_000).to_bytes(4) + b"\x08\0\0\0\0"
    ),
    "a broken PNG": lambda path: with_header(path, b"\0\0\0\x09"),
    "cannot be read: no such file or directory": Path.unlink,
    "not a PNG: expected a gray-scale picture": lambda path: path.write_bytes(b"GIF89a"),
    "cannot be read: image file is truncated": cut_off,
    "white all over; expected something darker": lambda path: save(path.parents[1], np.full((9, 9), 255)),
    "expected a PNG of 8 bits a channel": lambda path: save(path.parents[1], np.full((9, 9), 700), "I;16"),
}


def test_animation_without_frames_is_refused(scene_file, tmp_path) -> None:
    animated_without_frames(tmp_path / "maps" / "map.png")
    with pytest.raises(SourceError, match=r"behaviour.density.file: maps/map.png: a broken PNG$"):
        load_scene(scene_file)


@pytest.mark.parametrize("message", SPOILT)
def test_invalid_picture_gives_a_one_line_message(scene_file, tmp_path, message) -> None:
    SPOILT[message](tmp_path / "maps" / "map.png")
    with pytest.raises(SourceError) as caught:
        load_scene(scene_file)
    line = 1 + scene_file.read_text().splitlines().index("    file: maps/map.png")
    assert str(caught.value) == f"{scene_file}:{line}: behaviour.density.file: maps/map.png: {message}"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("smoothing: 0.05", "smoothing: 0.01", "smoothing: 0.01: expected at least 0.02, a twentieth of the radius of"),
        ("    file: maps/map.png\n", "", "file: missing (the picture, a PNG"),
        ("smoothing: 0.05", "smoothing: 0.05\n    pixels: 2x2 AAAA", "pixels: not the contents of a picture"),
        ("smoothing: 0.05", "smoothing: 0.05\n    pixels: 2x2 A", "pixels: not the contents of a picture"),
        ("smoothing: 0.05", "smoothing: 0.05\n    pixels: abc", "pixels: not the contents of a picture"),
    ],
)
def test_invalid_picture_keys_give_a_one_line_message(scene_file, old, new, message) -> None:
    scene_file.write_text(scene_file.read_text().replace(old, new))
    with pytest.raises(SourceError) as caught:
        load_scene(scene_file)
    assert f"behaviour.density.{message}" in str(caught.value)


def test_errors_in_part_of_a_sum_name_the_full_key() -> None:
    parts = "    kind: sum\n    parts:\n      - density:\n          kind: uniform\n      - weight: 2\n"
    parts += "        density:\n          kind: gaussian\n          sigma: {sigma}\n"
    before, _, after = FEAR.partition("    kind: uniform")
    text = before + parts + after.partition("\n")[2]
    where = f"f.yaml:{1 + text.splitlines().index('          sigma: {sigma}')}: behaviour.density.parts.1.density"
    assert len(parse_scene(text.format(sigma=0.1), "f.yaml").behaviour.density.parts) == 2
    for sigma, message in ((0.001, "sigma: 0.001: expected at least 0.008"), ("a", "sigma: 'a': expected a number")):
        with pytest.raises(SourceError) as caught:
            parse_scene(text.format(sigma=sigma), "f.yaml")
        assert str(caught.value).startswith(f"{where}.{message}")
    with pytest.raises(SourceError) as caught:
        parse_scene(text.format(sigma=0.1).replace("sigma", "sigmo"), "f.yaml")
    assert str(caught.value).startswith(
        f"{where}.sigmo: unknown key (did you mean behaviour.density.parts.1.density.sig"
    )


def test_shipped_scenes_need_no_other_file() -> None:
    assert not [emotion for emotion in EMOTIONS if "file:" in shipped_scene(emotion).read_text(encoding="utf-8")]
