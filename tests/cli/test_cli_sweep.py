import csv
import io
import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from emovid.cli.main import main
from emovid.measure.describe import DESCRIPTORS

TINY = "set: {duration: 0.4, video.size: 96x64, video.fps: 5}\n"
GRID = "scenes: [anger, fear]\nseeds: [1, 2]\ngrid: {robot.l: [0.002, 0.01]}\n" + TINY


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder that holds a sweep of eight items."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text(GRID)
    return tmp_path


def sweep(*arguments: object, file: str = "s.yaml") -> int:
    return main(["sweep", file, *map(str, arguments)])


def contents(folder: str) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def rows(folder: str) -> list[dict[str, str]]:
    with Path(folder, "results.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_sweep_writes_videos_table_contact_sheet_and_plan(capsys) -> None:
    assert sweep("--jobs", 1) == 0
    assert "made 8 in" in capsys.readouterr().err
    made = contents("sweeps/s")
    table = rows("sweeps/s")
    assert [row["item"] for row in table] == list("12345678")
    assert {row["name"] for row in table} == {name for name in made if name.endswith(".mp4")}
    assert set(made) - {row["name"] for row in table} == {
        "contact-sheet.png", "manifest.json", "plan.json", "results.csv", "results.parquet",
    }  # fmt: skip
    assert [(row["scene"], row["robot.l"], row["seed"]) for row in table[:3]] == [
        ("anger", "0.002", "1"), ("anger", "0.002", "2"), ("anger", "0.01", "1"),
    ]  # fmt: skip
    assert len({row["sha256"] for row in table}) == 8
    parquet = pd.read_parquet("sweeps/s/results.parquet")
    assert parquet.astype(str).to_dict("records") == table


def test_jobs_shards_and_single_process_give_identical_bytes(capsys) -> None:
    assert sweep("-o", "one", "--jobs", 1) == 0
    assert sweep("-o", "two", "--jobs", 2) == 0
    for shard in (2, 3, 1):
        assert len(list(Path("parts").glob("*.png"))) == 0
        assert sweep("-o", "parts", "--shard", f"{shard}/3", "--jobs", 1, "-q") == 0
    assert contents("one") == contents("two") == contents("parts")


def test_current_results_are_kept_also_in_a_copied_folder(capsys) -> None:
    sweep("-o", "a", "--jobs", 1)
    shutil.copytree("a", "b")
    before = contents("b")
    capsys.readouterr()
    assert sweep("-o", "b") == 0
    assert capsys.readouterr().err == "nothing to make: all is up to date\nb/results.csv: 8 of 8 items\n"
    assert main(["sweep", "b/plan.json", "-o", "b", "-q"]) == 0
    assert contents("b") == before


@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_bytes(b"damaged")])
def test_only_missing_or_damaged_items_are_made(capsys, spoil) -> None:
    sweep("-o", "a", "--jobs", 1)
    before = contents("a")
    victim = next(Path("a").glob("fear-*.mp4"))
    spoil(victim)
    assert main(["status", "a"]) == 1
    capsys.readouterr()
    assert sweep("-o", "a") == 0
    assert capsys.readouterr().err.startswith(f"[8/8] {victim}: 2 frames\nmade 1 in")
    assert contents("a") == before


def test_extended_sweep_makes_only_new_items(capsys) -> None:
    sweep("-o", "a", "--jobs", 1, "-q")
    Path("s.yaml").write_text(GRID.replace("[0.002, 0.01]", "[0.001, 0.002, 0.01]"))
    assert sweep("-o", "a", "--jobs", 1) == 0
    assert "made 4 in" in capsys.readouterr().err
    assert len(rows("a")) == 12


def test_each_measurement_is_a_table_row_without_a_file() -> None:
    assert sweep("-o", "m", "--only", "measure", "--jobs", 1, "-q") == 0
    assert set(contents("m")) == {"manifest.json", "plan.json", "results.csv", "results.parquet"}
    table = pd.read_csv("m/results.csv")
    assert list(table.columns) == ["item", "name", "scene", "robot.l", "seed", *DESCRIPTORS, "trajectory_sha256"]
    assert (table["speed_mean"] > 0).all()


def test_saved_trajectories_can_be_rendered_later() -> None:
    assert sweep("-o", "t", "--only", "trajectory", "--jobs", 1, "-q") == 0
    assert sweep("-o", "v", "--jobs", 1, "-q") == 0
    for run, video in zip(rows("t"), rows("v"), strict=True):
        assert run["trajectory_sha256"] == video["trajectory_sha256"]
    first = rows("t")[0]["name"]
    assert main(["render", f"t/{first}", "-o", "again.mp4", "-q"]) == 0
    assert Path("again.mp4").read_bytes() == Path("v", rows("v")[0]["name"]).read_bytes()
    assert Path("t/contact-sheet.png").is_file()


def test_contact_sheet_shows_each_item_in_its_cell() -> None:
    Path("s.yaml").write_text(
        "scenes: [sadness]\ngrid:\n"
        "  video.colours.stage: ['#ff0000', '#00ff00', '#0000ff']\n  video.trails.robots: [0, 5]\n" + TINY
    )
    assert sweep("-o", "a", "--jobs", 1, "-q") == 0
    sheet = np.asarray(Image.open("a/contact-sheet.png").convert("RGB")).astype(int)
    middles = []
    for channel in range(3):
        others = [other for other in range(3) if other != channel]
        places = np.nonzero((sheet[..., channel] > 200) & (sheet[..., others] < 60).all(axis=-1))
        middles.append([int(place.mean()) for place in places])
    down, across = np.diff(middles, axis=0).T
    assert (down > 100).all()  # a row for each color of the stage
    assert (np.abs(across) < 5).all()


def test_shipped_sweep_is_found_by_name(capsys) -> None:
    assert sweep("--shard", "24/24", "--jobs", 1, file="look_ahead_and_gain") == 0
    assert capsys.readouterr().err.splitlines()[0].endswith(".mp4: 150 frames")
    assert [row["robot.K"] for row in rows("sweeps/look_ahead_and_gain")] == ["12"]


def test_json_reports_counts(capsys) -> None:
    assert sweep("-o", "a", "--jobs", 1, "--json") == 0
    said = capsys.readouterr()
    assert json.loads(said.out) == {"folder": "a", "items": 8, "made": 8, "up_to_date": 0, "failed": {}}
    assert said.err == ""


def test_failures_are_listed_and_other_items_are_made(capsys) -> None:
    sweep("-o", "a", "--jobs", 1, "-q")
    victim = next(Path("a").glob("fear-*.mp4"))
    shutil.rmtree("a")
    Path("a", victim.name).mkdir(parents=True)
    assert sweep("-o", "a", "--jobs", 1) == 1
    said = capsys.readouterr().err.splitlines()
    assert [line.startswith(f"{victim}: ") for line in said[:8]].count(True) == 1  # at the time of the failure
    assert said[-2] == "a/results.csv: 7 of 8 items"
    assert said[-1] == "1 of 8 items failed: run again to make what is missing"
    assert len(rows("a")) == 7


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.yaml"], "none.yaml: cannot be read: no such file or directory"),
        (["s.yaml", "--only", "vidoe"], "--only: only: 'vidoe': expected one of video, trajectory, measure"),
        (["s.yaml", "--shard", "0/2"], "--shard 0/2: expected a number and a count, from 1/40 to 40/40"),
        (["s.yaml", "-o", "s.yaml"], "-o s.yaml: is a file; expected a folder"),
        (["bad.yaml"], "bad.yaml:2: robots: 99999 robots do not fit into "),
        (["s.yaml", "--scheduler", "nowhere"], "--scheduler nowhere: missing port number in address 'nowhere'; "
         "expected as in tcp://127.0.0.1:8786"),
    ],
)  # fmt: skip
def test_invalid_input_gives_one_line_and_writes_no_file(capsys, arguments, message) -> None:
    Path("bad.yaml").write_text("scenes: [anger]\ngrid: {robots: [3, 99999]}\n")
    assert main(["sweep", *arguments]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    assert said.startswith(message)
    assert not Path("sweeps").exists()


def test_status_and_verify_accept_rendered_folders(capsys) -> None:
    small = ["--size", "96x64", "--fps", "5", "--set", "duration=0.4"]
    main(["render", "--emotion", "anger", *small, "-q"])
    assert main(["status", "videos"]) == 0
    assert main(["verify", "videos", "--rebuild", "-j", "1"]) == 0
    assert capsys.readouterr().out == 2 * "1 results: 1 current\n"
    Path("videos/anger.mp4").write_bytes(b"")
    assert main(["status", "videos"]) == 1
    assert main(["verify", "videos", "--json"]) == 1
    said = capsys.readouterr().out
    assert said.startswith("corrupt: anger.mp4\n1 results: 1 corrupt\n")
    assert json.loads(said.split("corrupt\n")[-1])["counts"] == {"corrupt": 1}


def parquet_of_answers() -> bytes:
    file = io.BytesIO()
    pd.DataFrame({"participant": ["p1"], "answer": ["anger"]}).to_parquet(file)
    return file.getvalue()


FOREIGN = {
    "manifest.json": b'{"name": "My site", "icons": []}',
    "plan.json": b'{"thesis": "chapter 1"}',
    "results.csv": b"participant,answer\np1,anger\n",
    "results.parquet": parquet_of_answers(),
    "contact-sheet.png": b"my picture",
}


@pytest.mark.parametrize("name", FOREIGN)
@pytest.mark.parametrize("force", [[], ["--force"]])
def test_a_file_of_another_program_is_never_replaced(name, force, capsys) -> None:
    Path("mine").mkdir()
    Path("mine", name).write_bytes(FOREIGN[name])
    assert sweep("-o", "mine", *force) == 2
    problem = "was not written by emovid; move it, or choose another folder"
    assert capsys.readouterr().err == f"mine/{name}: {problem}\n"
    assert contents("mine") == {name: FOREIGN[name]}


def test_results_of_another_sweep_are_replaced_only_with_force(capsys) -> None:
    def write(seeds: str) -> None:
        Path("s.yaml").write_text(f"only: measure\nscenes: [anger]\nseeds: {seeds}\nset: {{duration: 0.4}}\n")

    write("[1, 2]")
    assert sweep("-o", "out") == 0
    write("[1, 2, 3]")
    assert sweep("-o", "out") == 0  # all are kept
    before = contents("out")
    write("[2, 3]")
    capsys.readouterr()
    assert sweep("-o", "out") == 2
    problem = "exists with other settings (1 of its results are not in this sweep)"
    assert capsys.readouterr().err == f"out/plan.json {problem}; use --force to overwrite it, or -o\n"
    assert contents("out") == before
    assert sweep("-o", "out", "--force") == 0
    assert [row["seed"] for row in rows("out")] == ["2", "3"]
