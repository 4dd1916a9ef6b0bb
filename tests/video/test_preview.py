import base64
import re

import pytest

from emovid import show, simulate
from emovid.video.render import reduced
from tests.helpers.mp4 import decode

SHORT = {"duration": 1.0, "video.fps": 30}


def test_player_has_the_requested_width_and_rate(make_scene, tmp_path) -> None:
    player = show(simulate(make_scene("anger", SHORT)), width=160, fps=10)
    html = player._repr_html_()
    (data,) = re.findall(r'src="data:video/mp4;base64,([A-Za-z0-9+/=]+)"', html)
    (tmp_path / "x.mp4").write_bytes(base64.b64decode(data))
    assert decode(tmp_path / "x.mp4", 160, 90).shape == (10, 90, 160, 3)
    assert {"autoplay", "loop", "muted", "controls", 'width="160"'} <= set(re.split("[ >]", html))
    assert repr(player) == "Player(anger, 1 s, 160x90)"


@pytest.mark.parametrize(("width", "fps", "size"), [(481, 0, (480, 270)), (0, -3, (64, 64))])
def test_player_width_is_clamped_to_the_video_and_rounded(make_scene, width, fps, size) -> None:
    run = simulate(make_scene("anger", {"duration": 1.0, "video.fps": 2}))
    player = show(run, width, fps)
    assert player.width == size[0]
    assert f"anger, 1 s, {size[0]}x{size[1]}" in repr(player)


def test_a_player_is_small_enough_for_a_notebook(make_scene) -> None:
    assert len(show(simulate(make_scene("happiness")))._repr_html_()) < 1_500_000


def test_player_of_a_scene_without_an_emotion_is_called_a_swarm(make_scene) -> None:
    assert repr(show(simulate(make_scene("fear", SHORT | {"emotion": None})), 96)) == "Player(a swarm, 1 s, 96x64)"


@pytest.mark.parametrize(
    ("size", "width", "expected"),
    [
        ("1280x720", 320, "320x180"),
        ("720x720", 320, "320x320"),
        ("1000x300", 321, "320x96"),
        ("1280x128", 320, "320x64"),
        ("128x8192", 320, "320x8192"),
    ],
)
def test_reduced_sides_are_proportional_even_and_bounded(make_scene, size, width, expected) -> None:
    run = simulate(make_scene("fear", SHORT | {"video.size": size}))
    assert reduced(run, width, 10).scene.video.size == expected


def test_a_reduced_run_has_the_same_motion_and_no_more_frames(make_scene) -> None:
    run = simulate(make_scene("fear", SHORT | {"video.fps": 4}))
    small = reduced(run, 320, 10, "gif")
    assert (small.scene.video.fps, small.scene.video.format) == (4, "gif")
    assert small.digest() == run.digest()
    assert run.scene.video.size == "1280x720"
