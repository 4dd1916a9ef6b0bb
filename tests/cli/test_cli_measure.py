import csv
import json
import os
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.measure.describe import DESCRIPTORS
from emovid.scene.emotions import EMOTIONS


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_check_prints_each_claim_with_its_verdict(capsys) -> None:
    assert main(["measure", "--all", "--gate"]) == 0
    said = capsys.readouterr()
    lines = [line for line in said.out.splitlines() if line.startswith("holds")]
    assert any("anger has the highest peak speed (Sec. II:" in line and ">= 1.5 times" in line for line in lines)
    assert said.out.splitlines()[-1] == f"{len(lines)} of {len(lines)} claims hold"
    assert "not applied by the paper  fear has the shape of downward pointing triangles" in said.out
    assert said.err.splitlines()[0] == "[1/6] happiness"


def test_failed_claim_gives_exit_code_1(capsys) -> None:
    scenes = [name for name in EMOTIONS if name != "anger"]
    assert main(["scene", "new", "calm.yaml", "--from", "anger"]) == 0
    text = Path("calm.yaml").read_text().replace("u_max: 0.11 ", "u_max: 0.01 ")
    Path("calm.yaml").write_text(text)
    assert main(["measure", *scenes, "calm.yaml", "--gate", "--quiet"]) == 1
    assert main(["measure", *scenes, "calm.yaml", "--gate", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    failed = [claim for claim in found["claims"] if not claim["holds"]]
    assert any(claim["claim"] == "anger has the highest peak speed" for claim in failed)
    assert set(failed[0]) >= {"claim", "source", "values", "holds"}


def test_descriptors_as_json_and_csv(capsys) -> None:
    assert main(["measure", "fear", "happiness", "--json", "-o", "out/measure.csv"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found["scenes"]) == ["fear", "happiness"]
    assert list(found["scenes"]["fear"]) == list(DESCRIPTORS)
    assert found["scenes"]["happiness"]["cost_end"] is None
    assert found["claims"] == []
    rows = list(csv.DictReader(Path("out/measure.csv").read_text().splitlines()))
    assert len(rows) == 2 * len(DESCRIPTORS)
    by_name = {row["descriptor"]: row for row in rows if row["scene"] == "fear"}
    assert float(by_name["speed_mean"]["value"]) == found["scenes"]["fear"]["speed_mean"]
    assert by_name["speed_mean"]["unit"] == "m/s"


def test_finished_run_gives_the_same_measurements_as_its_scene(capsys) -> None:
    assert main(["measure", "disgust", "--seed", "5", "--json"]) == 0
    scene = json.loads(capsys.readouterr().out)["scenes"]["disgust"]
    for file in ("disgust.npz", "UPPER.NPZ"):
        assert main(["simulate", "--emotion", "disgust", "--seed", "5", "-o", file, "--quiet"]) == 0
        assert main(["measure", file, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["scenes"][file] == scene


def test_file_name_that_is_not_unicode_is_escaped_as_in_json() -> None:
    name = os.fsdecode(b"caf\xe9.yaml")
    main(["scene", "new", name, "--from", "sadness", "-q"])
    assert main(["measure", name, "-o", "measure.csv", "-q"]) == 0
    rows = csv.DictReader(Path("measure.csv").read_text().splitlines())
    assert {row["scene"] for row in rows} == {r"caf\udce9.yaml"}


def test_the_seed_is_replaced_in_every_scene(capsys) -> None:
    assert main(["measure", "fear", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["scenes"]["fear"]
    assert main(["measure", "fear", "--seed", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"]["fear"]["speed_mean"] != first["speed_mean"]


def test_table_shows_full_descriptor_names(capsys) -> None:
    assert main(["measure", "sadness"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in DESCRIPTORS)
    assert "0.0908" in said  # meters in 8 s


def test_table_shows_the_window_of_each_scene(capsys) -> None:
    assert main(["measure", "happiness", "sadness"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["window", "s", "4", "8"] in rows
    assert main(["measure", "sadness", "--set", "snapshots=[0, 3]", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"]["sadness"]["window"] == 3


@pytest.mark.parametrize(
    ("only", "names"),
    [
        ("speed_mean,cusps", ["speed_mean", "cusps"]),  # not speed_mean_diagonals, cusps_per_metre
        (" cost_ ,window", ["window", "cost_start", "cost_end", "cost_converged", "cost_ratio", "cost_progress"]),
        ("radius_spread,radius_spread", ["radius_spread"]),
    ],
)
def test_selected_descriptors_are_shown_in_the_given_order(only, names, capsys) -> None:
    shortly = ["measure", "fear", "--only", only, "--set", "duration=1"]
    assert main([*shortly, "--json", "-o", "measure.csv"]) == 0
    assert list(json.loads(capsys.readouterr().out)["scenes"]["fear"]) == names
    assert [row["descriptor"] for row in csv.DictReader(Path("measure.csv").read_text().splitlines())] == names
    assert main(shortly) == 0
    said = capsys.readouterr().out.split()
    assert [word for word in said if word in DESCRIPTORS] == names


def test_check_lists_claims_that_exclude_anger_for_robots_with_motors(capsys) -> None:
    main(["measure", "--gate", "--platform", "robotarium", "--set", "duration=0.3", "--quiet"])
    assert capsys.readouterr().out == ""
    main(["measure", "--gate", "--platform", "robotarium", "--set", "duration=0.3"])
    assert "\nchecked without anger  anger has the highest peak speed (" in capsys.readouterr().out


def test_claims_use_all_descriptors_whichever_are_shown(capsys) -> None:
    assert main(["measure", "--gate", "--only", "window"]) == 0
    assert "anger has the highest peak speed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["measure", "fear", "--only", "cuspz"], "or how names begin, as in cusps,cost (did you mean cusps?)"),
        (["measure", "fear", "--only", "speed,"], "--only speed,: expected descriptors"),
        (["measure", "fear", "--only", ""], "--only : expected descriptors"),
        (["measure"], "expected scenes to measure, or --all"),
        (["measure", "fear", "--all"], "expected scenes to measure, or --all"),
        (["measure", "fear", "--gate"], "--gate: expected one scene of each emotion; given fear"),
        (["measure", "feer"], "fear"),
        (["measure", "fear", "-o", "measure.txt"], "expected a file ending in .csv"),
        (["measure", "fear", "--set", "robots=0"], "robots"),
        (["measure", "no.npz"], "cannot be read"),
        (
            ["measure", "real.csv"],
            "expected a scene in addition, as in emovid measure real.csv anger, or a .track.yaml",
        ),
        (["measure", "real.csv", "fear"], "real.csv: cannot be read"),
        (["measure", "fear", "--same-rate"], "--same-rate: expected one recorded motion among the sources; given 0"),
    ],
)
def test_invalid_input_gives_a_one_line_message(arguments: list[str], words: str, capsys) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert len(said.err.splitlines()) == 1
    assert said.out == ""


def test_recorded_positions_are_compared_with_a_simulation_at_their_rate(capsys) -> None:
    assert main(["simulate", "--emotion", "anger", "--set", "duration=3", "-o", "real.csv", "--quiet"]) == 0
    assert main(["measure", "real.csv", "anger", "--set", "duration=3", "--same-rate", "--json"]) == 0
    scenes = json.loads(capsys.readouterr().out)["scenes"]
    real, simulated = ({k: v for k, v in scenes[name].items() if v is not None} for name in ("real.csv", "anger"))
    assert real == pytest.approx(simulated, rel=1e-6)
    assert scenes["real.csv"]["speed_peak"] is None
    assert main(["measure", "real.csv", "anger", "--only", "speed", "--set", "duration=3"]) == 0
    said = capsys.readouterr().out
    assert "real.csv: positions only, without commands and a density; missing: speed_p95, speed_peak" in said


def test_recorded_track_is_measured_and_rendered_like_a_run(capsys) -> None:
    assert main(["simulate", "--emotion", "fear", "--set", "duration=1", "-o", "real.csv", "--quiet"]) == 0
    Path("real.track.yaml").write_text(
        "file: real.csv\nformat: emovid\nscale: 1\ny: up\nrobot: gritsbot\nstage: {width: 1.2, height: 0.8}\n"
    )
    assert main(["measure", "real.track.yaml", "--only", "window", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scenes"]["real.track.yaml"] == {"window": 1.0}
    assert main(["render", "real.track.yaml", "-o", "real.mp4", "--size", "128x72", "--quiet"]) == 0
    assert Path("real.mp4").stat().st_size > 1000
    assert main(["figures", "frames", "real.track.yaml", "--format", "png", "-o", "figures"]) == 0
    assert list(Path("figures").glob("*.png"))
