import csv
import json
from pathlib import Path

import numpy as np
import pytest

from emovid.atomic_io import file_digest
from emovid.cli.main import main
from emovid.scene.emotions import EMOTIONS

SIX = "happiness, surprise, sadness, fear, disgust, anger"
ONE_SCENE = f"expected one scene: a file, or --emotion and one of {SIX}"
SMALL = ["--size", "96x64", "--fps", "5", "--set", "duration=1"]


def render(*arguments: object) -> int:
    return main(["render", *map(str, arguments), *SMALL])


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def manifest(folder: Path) -> dict:
    return json.loads((folder / "manifest.json").read_text())["videos"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_emotion_is_rendered_into_the_videos_folder(tmp_path) -> None:
    assert render("--emotion", "anger") == 0
    assert names(tmp_path) == ["videos"]
    assert names(tmp_path / "videos") == ["anger.mp4", "manifest.json"]


@pytest.mark.parametrize(
    ("output", "expected"),
    [("out/", "out/my_scene.mp4"), ("a/b", "a/b/my_scene.mp4"), ("x.mp4", "x.mp4"), ("c/y.MP4", "c/y.MP4")],
)
def test_output_is_a_folder_unless_it_has_a_video_suffix(tmp_path, output, expected) -> None:
    main(["scene", "new", "my_scene.yaml", "--from", "sadness"])
    assert render("my_scene.yaml", "-o", output) == 0
    assert (tmp_path / expected).is_file()
    assert (tmp_path / expected).with_name("manifest.json").is_file()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["-o", "x.webm"], "x.webm"),
        (["-o", "c/y.GIF"], "c/y.GIF"),
        (["--format", "gif"], "videos/anger.gif"),
        (["--format", "webm", "-o", "out"], "out/anger.webm"),
        (["--set", "video.format=webm"], "videos/anger.webm"),
        (["--format", "png-sequence"], "videos/anger/00004.png"),
    ],
)
def test_format_follows_the_output_suffix_or_the_option(capsys, arguments, expected) -> None:
    assert render("--emotion", "anger", *arguments) == 0
    assert Path(expected).is_file()
    capsys.readouterr()
    assert render("--emotion", "anger", *arguments) == 0
    assert "up to date" in capsys.readouterr().err


def test_sequence_with_a_damaged_picture_is_rendered_again(capsys) -> None:
    render("--emotion", "anger", "--format", "png-sequence")
    before = Path("videos/anger/00002.png").read_bytes()
    Path("videos/anger/00002.png").write_bytes(b"damaged")
    capsys.readouterr()
    assert render("--emotion", "anger", "--format", "png-sequence") == 0
    assert "[1/1] videos/anger: 5 frames" in capsys.readouterr().err
    assert Path("videos/anger/00002.png").read_bytes() == before


def test_manifest_lists_two_formats_of_one_scene() -> None:
    render("--emotion", "anger", "--format", "png-sequence")
    render("--emotion", "anger", "--format", "webm")
    assert sorted(manifest(Path("videos"))) == ["anger", "anger.webm"]


def test_folder_with_other_files_is_not_replaced_by_a_sequence(capsys) -> None:
    Path("videos/anger").mkdir(parents=True)
    Path("videos/anger/thesis.txt").write_text("mine")
    assert render("--emotion", "anger", "--format", "png-sequence") == 2
    said = capsys.readouterr().err
    assert said == "videos/anger: holds thesis.txt, which is not a picture of a sequence; expected a new folder\n"
    assert names(Path("videos/anger")) == ["thesis.txt"]


def test_theme_and_overlays_change_only_the_picture() -> None:
    render("--emotion", "fear")
    plain = manifest(Path("videos"))["fear.mp4"]
    for look in (["--theme", "dark"], ["--overlay", "clock"], ["--overlay", "cells", "--overlay", "density"]):
        render("--emotion", "fear", *look, "--force")
        entry = manifest(Path("videos"))["fear.mp4"]
        assert entry["sha256"] != plain["sha256"], look
        assert entry["trajectory_sha256"] == plain["trajectory_sha256"]


def test_finished_run_is_rendered_with_other_video_options() -> None:
    main(["simulate", "--emotion", "fear", "-o", "fear.npz"])
    look = ["--theme", "dark", "--overlay", "targets", "-o", "x.webm", "--size", "96x64", "--fps", "1"]
    assert main(["render", "fear.npz", *look]) == 0
    assert Path("x.webm").is_file()


def test_manifest_records_how_a_video_was_made() -> None:
    assert render("--emotion", "fear", "--seed", "9") == 0
    entry = manifest(Path("videos"))["fear.mp4"]
    assert {key: entry[key] for key in ("emotion", "seed", "frames", "fps", "size")} == {
        "emotion": "fear", "seed": 9, "frames": 5, "fps": 5, "size": "96x64",
    }  # fmt: skip
    assert all(len(entry[key]) == 64 for key in ("sha256", "trajectory_sha256", "scene_digest"))
    assert {"emovid", "numpy", "scipy", "matplotlib", "ffmpeg"} <= set(entry["versions"])
    assert "libx264" in entry["encoder"]


def test_current_videos_are_not_rendered_again(capsys) -> None:
    render("--emotion", "anger")
    made = Path("videos/anger.mp4").stat()
    capsys.readouterr()
    assert render("--emotion", "anger") == 0
    said = capsys.readouterr().err
    assert said == "[1/1] videos/anger.mp4: up to date\nnothing to render: all is up to date\n"
    again = Path("videos/anger.mp4").stat()
    assert again.st_ino == made.st_ino
    assert again.st_mtime_ns >= made.st_mtime_ns  # its date is new, for make


@pytest.mark.parametrize(
    "spoil",
    [
        lambda: Path("videos/anger.mp4").unlink(),
        lambda: Path("videos/anger.mp4").write_bytes(b"damaged"),
        lambda: Path("videos/manifest.json").unlink(),
        lambda: Path("videos/manifest.json").write_text("{not json"),
        lambda: Path("videos/manifest.json").write_text('{"videos": [1]}'),
    ],
    ids=["video lost", "video damaged", "manifest lost", "manifest damaged", "manifest of another kind"],
)
def test_missing_or_damaged_videos_are_rendered_again(spoil) -> None:
    render("--emotion", "anger")
    before = Path("videos/anger.mp4").read_bytes()
    spoil()
    assert render("--emotion", "anger") == 0
    assert Path("videos/anger.mp4").read_bytes() == before
    assert manifest(Path("videos"))["anger.mp4"]["frames"] == 5


@pytest.mark.parametrize(
    ("change", "keys"),
    [
        (("--seed", "2"), "seed"),
        (("--set", "robot.l=0.005"), "robot.l"),
        (("--set", "video.trails.robots=3"), "video.trails.robots"),
        (("--set", "robots=4", "--theme", "dark", "--set", "robot.K=9", "--seed", "2"),
         "robot.K, robots, seed and 1 more"),
        (("-o", "videos", "--seed", "2"), "seed"),
        (("-o", "videos/anger.mp4", "--seed", "2"), "seed"),
    ],
)  # fmt: skip
def test_video_with_other_settings_is_replaced_only_with_force(capsys, change, keys) -> None:
    render("--emotion", "anger")
    before = {path: path.read_bytes() for path in Path("videos").iterdir()}
    capsys.readouterr()
    assert render("--emotion", "anger", *change) == 2
    refused = f"videos/anger.mp4 exists with other settings ({keys}); use --force to overwrite it, or -o\n"
    assert capsys.readouterr() == ("", refused)
    assert {path: path.read_bytes() for path in Path("videos").iterdir()} == before
    assert render("--emotion", "anger", *change, "--force") == 0
    assert "[1/1] videos/anger.mp4: 5 frames\nrendered 1 in" in capsys.readouterr().err
    Path("videos/anger.mp4").unlink()
    assert render("--emotion", "anger") == 0  # no video can be lost


def test_force_renders_a_video_again(capsys) -> None:
    render("--emotion", "anger")
    assert render("--emotion", "anger", "--force") == 0
    assert "[1/1] videos/anger.mp4: 5 frames\nrendered 1 in" in capsys.readouterr().err


def test_video_of_an_edited_run_is_not_current(capsys) -> None:
    for seed in (1, 2):
        main(["simulate", "fear", "-o", f"{seed}/run.npz", "--seed", str(seed), "--duration", "1", "-q"])
    with np.load("2/run.npz") as arrays, np.load("1/run.npz") as others:
        np.savez("edited.npz", **dict(arrays.items()) | {"scene": others["scene"]})
    look = ["--size", "96x64", "--fps", "5", "-o", "x.mp4"]
    assert main(["render", "1/run.npz", *look]) == 0
    assert main(["render", "fear", "--seed", "1", "--duration", "1", *look]) == 0  # the same run
    capsys.readouterr()
    assert main(["render", "edited.npz", *look]) == 2
    assert capsys.readouterr().err == "x.mp4 exists with other settings (run); use --force to overwrite it, or -o\n"


@pytest.mark.parametrize("name", ["anger.mp4", "anger.gif", "anger"])
def test_unrecorded_video_with_other_content_is_kept(name, capsys) -> None:
    format = {"anger": "png-sequence"}.get(name, name.partition(".")[2])
    assert render("anger", "--format", format, "-o", "other", "--seed", "5") == 0
    Path("videos").mkdir()
    Path("other", name).rename(Path("videos", name))
    before = file_digest(Path("videos", name))
    capsys.readouterr()
    assert render("anger", "--format", format) == 2
    problem = "exists with other settings, or not from emovid"
    assert capsys.readouterr().err == f"videos/{name} {problem}; use --force to overwrite it, or -o\n"
    assert names(Path("videos")) == [name]
    assert file_digest(Path("videos", name)) == before
    assert render("anger", "--format", format, "--seed", "5") == 0  # identical: it is recorded
    assert file_digest(Path("videos", name)) == before
    assert list(manifest(Path("videos"))) == [name]
    assert render("anger", "--format", format, "--force") == 0


FOREIGN = {
    "manifest.json": '{"name": "My site", "icons": []}',
    "presentation_order.csv": "participant,answer\np1,anger\n",
}


@pytest.mark.parametrize("name", FOREIGN)
@pytest.mark.parametrize("force", [[], ["--force"]])
def test_a_file_of_another_program_is_never_replaced(name, force, capsys) -> None:
    Path("site").mkdir()
    Path("site", name).write_text(FOREIGN[name])
    assert render("--all", "-o", "site", *force) == 2
    problem = "was not written by emovid; move it, or choose another folder"
    assert capsys.readouterr().err == f"site/{name}: {problem}\n"
    assert names(Path("site")) == [name]
    assert Path("site", name).read_text() == FOREIGN[name]


def test_several_scenes_are_rendered_by_one_command(capsys) -> None:
    main(["scene", "new", "my.yaml", "--from", "sadness", "--quiet"])
    assert render("anger", "my.yaml", "anger", "--jobs", "1") == 0
    assert names(Path("videos")) == ["anger.mp4", "manifest.json", "my.mp4"]
    assert "[2/2] videos/my.mp4" in capsys.readouterr().err
    Path("deep").mkdir()
    Path("deep/my.yaml").write_bytes(Path("my.yaml").read_bytes())
    assert render("my.yaml", "deep/my.yaml") == 2
    expected = "my.yaml: videos/my.mp4 is the video of another scene, too; render one of them with -o\n"
    assert capsys.readouterr().err == expected
    assert render("my.yaml", "anger", "-o", "x.mp4") == 2
    assert capsys.readouterr().err == "-o x.mp4: is one file; expected a folder for 2 videos\n"


def test_duration_replaces_the_length_of_the_run() -> None:
    assert main(["render", "anger", "--duration", "2", "--size", "96x64", "--fps", "5"]) == 0
    assert manifest(Path("videos"))["anger.mp4"]["frames"] == 10


def test_a_part_of_a_finished_run_is_shown_at_another_speed() -> None:
    main(["simulate", "anger", "--duration", "2", "-o", "run.npz", "-q"])
    look = ["--size", "96x64", "--fps", "5"]
    assert main(["render", "run.npz", *look, "-o", "whole.mp4"]) == 0
    assert main(["render", "run.npz", *look, "-o", "slow.mp4", "--speed", "0.5", "--from", "0.4", "--to", "1.8"]) == 0
    whole, slow = manifest(Path())["whole.mp4"], manifest(Path())["slow.mp4"]
    assert (whole["frames"], slow["frames"]) == (10, 14)
    assert whole["trajectory_sha256"] == slow["trajectory_sha256"]


def test_copied_folder_is_current(tmp_path, capsys) -> None:
    render("--emotion", "anger")
    other = tmp_path / "copy"
    other.mkdir()
    for path in Path("videos").iterdir():
        (other / path.name).write_bytes(path.read_bytes())
    capsys.readouterr()
    assert render("--emotion", "anger", "-o", other) == 0
    assert "up to date" in capsys.readouterr().err


def test_second_video_keeps_the_first_in_the_manifest() -> None:
    render("--emotion", "anger")
    render("--emotion", "fear")
    assert sorted(manifest(Path("videos"))) == ["anger.mp4", "fear.mp4"]
    Path("videos/anger.mp4").unlink()
    render("--emotion", "disgust")
    assert sorted(manifest(Path("videos"))) == ["disgust.mp4", "fear.mp4"]


def test_six_videos_are_identical_with_one_job_and_two_jobs(capsys) -> None:
    assert render("--all", "--jobs", "1", "-o", "one") == 0
    capsys.readouterr()
    assert render("--all", "--jobs", "2", "-o", "two") == 0
    said = capsys.readouterr().err.splitlines()
    assert sorted(line.split("] ")[1] for line in said[:-1]) == sorted(f"two/{name}.mp4: 5 frames" for name in EMOTIONS)
    assert [line.split("]")[0] for line in said[:-1]] == [f"[{i}/6" for i in range(1, 7)]
    assert (
        names(Path("one"))
        == names(Path("two"))
        == sorted([*(f"{e}.mp4" for e in EMOTIONS), "manifest.json", "presentation_order.csv"])
    )
    for name in names(Path("one")):
        assert Path("one", name).read_bytes() == Path("two", name).read_bytes(), name


def test_the_order_of_presentation_is_random_and_seeded() -> None:
    orders = []
    for i, (seed, keys) in enumerate([("1", []), ("1", ["--set", "emotion=null"]), ("2", []), ("3", [])]):
        render("--all", "-o", f"set{i}", "--seed", seed, "--jobs", "1", *keys)
        with Path(f"set{i}/presentation_order.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert list(rows[0]) == ["position", "emotion", "video"]
        assert [row["position"] for row in rows] == list("123456")
        assert all(row["video"] == f"{row['emotion']}.mp4" for row in rows)
        orders.append([row["emotion"] for row in rows])
    assert all(sorted(order) == sorted(EMOTIONS) for order in orders)
    assert orders[0] == orders[1]
    assert len({tuple(order) for order in orders}) == 3


def test_finished_run_is_rendered(capsys) -> None:
    main(["simulate", "--emotion", "fear", "-o", "fear.npz", "--set", "duration=1"])
    assert main(["render", "fear.npz", "--size", "96x64", "--fps", "5"]) == 0
    render("--emotion", "fear", "-o", "direct")
    assert Path("videos/fear.mp4").read_bytes() == Path("direct/fear.mp4").read_bytes()


def test_json_output_is_only_on_stdout(capsys) -> None:
    assert render("--emotion", "sadness", "--json") == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["videos"]["videos/sadness.mp4"]["frames"] == 5
    assert said.err == ""
    assert json.loads(said.out)["failed"] == {}


def test_json_lists_rendered_and_failed_videos(capsys) -> None:
    Path("videos/fear.mp4").mkdir(parents=True)
    assert render("--all", "--jobs", "1", "--json") == 1
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert sorted(found["videos"]) == sorted(f"videos/{name}.mp4" for name in EMOTIONS if name != "fear")
    assert list(found["failed"]) == ["videos/fear.mp4"]
    summary = "1 of 6 videos failed: run again to make what is missing"
    assert said.err.splitlines() == [*found["failed"].values(), summary]
    assert not Path("videos/presentation_order.csv").exists()


def test_single_failure_gives_a_one_line_message(capsys) -> None:
    Path("videos/fear.mp4").mkdir(parents=True)
    assert render("fear") == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("videos/fear.mp4: ")
    assert lines[0].endswith("; run again to make what is missing")


def test_quiet_prints_nothing(capsys) -> None:
    assert render("--emotion", "sadness", "--quiet") == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], ONE_SCENE),
        (["--emotion", "angr"], f"--emotion angr: expected one of {SIX} (did you mean anger?)"),
        (["anger", "--emotion", "fear"], ONE_SCENE),
        (["--all", "--emotion", "fear"], "--all renders the six emotions and takes no scene"),
        (["--all", "-o", "x.mp4"], "-o x.mp4: is one file; expected a folder for 6 videos"),
        (["fear", "-o", "x.mov"], "-o x.mov: cannot write .mov; expected .mp4, or a folder"),
        (["fear", "-o", "x.webm", "--format", "gif"], "-o x.webm: cannot write .webm; expected .gif, or a folder"),
        (["fear", "-o", "x.gif", "--format", "png-sequence"], "-o x.gif: cannot write .gif; expected a folder"),
        (["fear", "-o", "x.mp4", "--set", "video.format=gif"], "-o x.mp4: cannot write .mp4; expected .gif, or a "
                                                               "folder"),
        (["fear", "-o", "x.gif", "--fps", "60"], "--fps 60: video.fps: 60: expected at most 50 in a gif: browsers show "
                                                 "a faster one slowly"),
        (["fear", "--format", "avi"], "--format avi: video.format: 'avi': expected one of mp4, webm, gif, "
                                      "png-sequence"),
        (["fear", "--theme", "drak"], "--theme drak: video.theme: 'drak': expected one of light, dark (did you mean "
                                      "dark?)"),
        (["fear", "--overlay", "cell"], "--overlay cell: video.overlays.cell: unknown key (did you mean "
                                        "video.overlays.cells?)"),
        (["sadness", "--overlay", "density"], "--overlay density: video.overlays.density: true: a contour behavior "
                                              "has no density to show"),
        (["fear", "--set", "video.trails.seconds=null", "--set", "video.trails.fade=true"],
         "--set video.trails.fade=true: video.trails.fade: true: a permanent trail cannot fade; expected a "
         "number for seconds"),
        (["fear", "--speed", "0"], "--speed 0: video.speed: 0: expected at least 0.01"),
        (["fear", "--to", "16"], "--to 16: video.end: 16: expected at most the duration of the run, 15"),
        (["fear", "--from", "8", "--to", "2"], "--from 8: video.begin: 8: expected less than the end of the video, 2"),
        (["fear", "--from", "0:02"], "--from 0:02: video.begin: '0:02': expected a number"),
        (["nothing.npz"], "nothing.npz: cannot be read: no such file or directory"),
        (["fear", "--set", "robot.k=2"], "--set robot.k=2: robot.k: unknown key (did you mean robot.K?)"),
        (["fear", "--set", "robot.K"], "--set robot.K: expected KEY=VALUE, as in robot.l=0.002"),
        (["fear", "--size", "7"], "--size 7: video.size: 7: expected width x height in pixels, as in 1280x720"),
        (["fear", "--jobs", "0"], "--jobs 0: expected a whole number, at least 1 (did you mean 1?)"),
        (["fear", "--sed", "1"], "No such option: --sed (Possible options: --seed, --set, --speed)"),
        (
            ["fear", "--set", "robots=900"],
            "--set robots=900: robots: 900 robots do not fit into 0.9 m x 0.6 m at random with 60 mm between centers: "
            "room was found for 107",
        ),
    ],
)  # fmt: skip
def test_invalid_input_gives_one_line_and_writes_no_file(tmp_path, capsys, arguments, message) -> None:
    assert main(["render", *arguments]) == 2
    said = capsys.readouterr()
    assert said.err.splitlines() == [message]
    assert said.out == ""
    assert names(tmp_path) == []


def test_invalid_output_gives_a_one_line_message(tmp_path, capsys) -> None:
    Path("taken").write_text("a file")
    assert render("fear", "-o", "taken") == 2
    assert capsys.readouterr().err == "-o taken: is a file; expected a folder, or a name that ends in .mp4\n"
    assert render("fear", "-o", "taken/inside") == 1
    assert capsys.readouterr().err == "taken/inside: cannot be made: not a directory\n"
    assert names(tmp_path) == ["taken"]


def test_other_videos_are_rendered_when_one_fails(tmp_path, capsys) -> None:
    Path("videos/fear.mp4").mkdir(parents=True)
    assert render("--all", "--jobs", "2") == 1
    said = capsys.readouterr().err.splitlines()
    assert [line.startswith("videos/fear.mp4: ") for line in said].count(True) == 1
    assert said[-1] == "1 of 6 videos failed: run again to make what is missing"
    assert sorted(manifest(Path("videos"))) == sorted(f"{name}.mp4" for name in EMOTIONS if name != "fear")
    assert [name for name in names(Path("videos")) if name.endswith(".part")] == []
