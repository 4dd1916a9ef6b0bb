import re

import pytest

from emovid.measure.claims import CLAIMS, claims_on, exceptions
from emovid.scene.emotions import EMOTIONS, PLATFORMS
from emovid.scene.load import load_scene, shipped_names, shipped_scene
from emovid.scene.model import Scene
from emovid.scene.robots import Barrier
from emovid.yaml_source import read_yaml

TIMES = {"robotarium": 8, "robotarium-today": 5}  # factor by which a run is slower than in simulation
ARENAS = {"robotarium": (4.3, 3.6), "robotarium-today": (3.2, 2.0)}

each_scene = pytest.mark.parametrize("name", [name for name in shipped_names() if "/" in name])


def split(name: str) -> tuple[str, str]:
    platform, _, emotion = name.partition("/")
    return platform, emotion


def keys(data: object, path: str = "") -> set[str]:
    if isinstance(data, dict) and data:
        return {key for name, item in data.items() for key in keys(item, f"{path}.{name}")}
    return {path}


@each_scene
def test_robotarium_scenes_use_the_robots_of_the_paper(name: str) -> None:
    platform, emotion = split(name)
    scene = load_scene(name)
    assert scene.emotion == emotion
    assert (scene.robots, scene.robot.body.name) == (12, "gritsbot_x")
    assert scene.robot.limits == scene.robot.body.limits
    assert (scene.stage.width, scene.stage.height) == ARENAS[platform]
    assert isinstance(scene.safety, Barrier)
    trails = scene.video.trails
    assert (trails.robots, trails.seconds, trails.fade) == (None, 2 * TIMES[platform], True)
    assert scene.snapshots == tuple(TIMES[platform] * t for t in EMOTIONS[emotion].snapshot_times)
    assert scene.duration == 15 * TIMES[platform]
    assert type(scene.behaviour) is type(load_scene(emotion).behaviour)


@each_scene
def test_scene_spells_out_every_key(name: str) -> None:
    raw, _ = read_yaml(shipped_scene(name).read_text(encoding="utf-8"), name)
    resolved = load_scene(name).resolved()
    resolved["robot"] |= {"model": "gritsbot_x", "limits": "model"}  # both are in the file of the robot
    assert keys(raw) == keys(resolved)


@each_scene
def test_header_cites_section_five_and_both_videos(name: str) -> None:
    platform, emotion = split(name)
    header = re.match(r"(#.*\n)+", shipped_scene(name).read_text(encoding="utf-8"))
    assert header
    assert header[0].lower().startswith(f"# {emotion} on robots: ")
    assert "doi 10.1007/s12369-020-00665-6: Sec. V" in header[0]
    assert len(re.findall(r"https://youtu\.be/[\w-]{11}\b", header[0])) == 2
    assert f"--platform {platform}" in header[0]


def test_safety_accepts_a_kind_instead_of_a_group() -> None:
    scene = load_scene("robotarium/fear", {"safety": "none"})
    assert scene == load_scene("robotarium/fear", {"safety": {"kind": "none"}})
    assert load_scene("robotarium/fear", {"safety": "barrier"}).safety == Barrier(kind="barrier")


def test_snapshots_of_a_scene_override_those_of_the_paper() -> None:
    assert load_scene("fear").snapshot_times == EMOTIONS["fear"].snapshot_times
    assert load_scene("fear", {"snapshots": [0, 2]}).snapshot_times == (0, 2)
    nobody: Scene = load_scene("fear", {"emotion": None})
    assert nobody.snapshot_times is None


def test_for_robots_with_motors_only_claims_on_peaks_except_anger() -> None:
    kept = claims_on(motors=True)
    assert claims_on(motors=False) == CLAIMS
    assert set(exceptions(motors=True)) == {claim.text for claim in CLAIMS if claim.peaks}
    assert not exceptions(motors=False)
    assert [claim for claim in kept if not claim.peaks] == [claim for claim in CLAIMS if not claim.peaks]
    assert len(CLAIMS) - len(kept) == 2
    assert not any(claim.peaks for claim in kept)  # both concern anger only
    spared = {claim.text for claim in CLAIMS if claim.peaks}
    assert all("peak" in text or "spectral arc length" in text for text in spared)


def test_every_platform_has_all_six_emotions() -> None:
    for platform in PLATFORMS:
        folder = shipped_scene(f"{platform}/fear").parent
        assert {path.stem for path in folder.iterdir()} == set(EMOTIONS)
