import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.figures.catalogue import CATALOGUE

ROOT = Path(__file__).parents[2]
EMOVID = [sys.executable, "-m", "emovid"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files(folder: Path = Path()) -> set[str]:
    return {str(path) for path in folder.rglob("*") if path.is_file()}


def width_of(png: str) -> float:
    """Return the width [in] of a picture of 300 dots per inch."""
    return int.from_bytes(Path(png).read_bytes()[16:20], "big") / 300


def test_figure_list_has_one_line_per_figure(capsys) -> None:
    assert main(["figures", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*CATALOGUE, "frames", "contact-sheet", "gallery"]
    for line, entry in zip(lines, CATALOGUE.values(), strict=False):
        assert entry.paper in line
        assert line.endswith(entry.caption)
    assert main(["figures", "--list", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["anger-frames"]["paper"] == "Fig. 8"
    assert rows["trace-sheet"]["paper"] is None
    assert rows["attributes"]["formats"] == ["tex", "md", "html"]
    assert rows["circumplex"]["tables"] == ["study"]
    assert files() == set()


def test_figures_are_made_in_the_requested_formats_and_width(capsys) -> None:
    arguments = ["gritsbot", "behaviours", "gritsbot", "-o", "out/here", "--format", "png", "--format", "md"]
    assert main(["figures", *arguments, "--style", "two-column"]) == 0
    assert files() == {"out/here/gritsbot.png", "out/here/behaviours.md"}
    assert {width_of(name) for name in files() if name.endswith("png")} == {7.16}
    said = capsys.readouterr()
    assert said.err == "[1/2] out/here/gritsbot: png\n[2/2] out/here/behaviours: md\n"
    assert said.out == ""


def test_default_formats_are_pdf_and_png_plus_text_for_tables() -> None:
    assert main(["figures", "gritsbot", "attributes", "--quiet"]) == 0
    assert files() == {
        *("figures/gritsbot.pdf", "figures/gritsbot.png"),
        *(f"figures/attributes.{suffix}" for suffix in ("tex", "md")),
    }
    assert width_of("figures/gritsbot.png") == 3.5


def test_quiet_prints_nothing_and_json_lists_the_files(capsys) -> None:
    assert main(["figures", "gritsbot", "--format", "svg", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main(["figures", "gritsbot", "--format", "svg", "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out) == {"figures": {"gritsbot": ["figures/gritsbot.svg"]}, "left_out": {}}
    assert said.err == ""


def test_frames_of_any_scene_at_any_times() -> None:
    main(["scene", "new", "mine.yaml", "--from", "sadness"])
    assert main(["figures", "frames", "mine.yaml", "--times", "0,2.5,8,15", "--format", "svg"]) == 0
    assert files() == {"mine.yaml", "emovid-scene.schema.json", "figures/mine-frames.svg"}


def test_frames_of_the_paper_show_its_scene_with_full_traces() -> None:
    traces = ["video.trails.robots=5", "video.trails.seconds=null", "video.trails.fade=false"]
    settings = [*traces, f"video.colours.trails=[{', '.join(5 * ['theme'])}]"]
    said = [word for setting in settings for word in ("--set", setting)]
    assert main(["figures", "frames", "sadness", "--format", "svg", "--quiet", "-o", "other", *said]) == 0
    assert main(["figures", "sadness-frames", "--format", "svg", "--quiet"]) == 0
    assert Path("other/sadness-frames.svg").read_bytes() == Path("figures/sadness-frames.svg").read_bytes()


def test_frames_of_a_finished_run_equal_those_of_its_scene() -> None:
    main(["simulate", "fear", "--quiet", "--set", "duration=2", "-o", "run.npz"])
    assert (
        main(["figures", "frames", "run.npz", "--format", "svg", "--quiet"]) == 0
    )  # the time 15 s of the paper is after its end
    main(["figures", "frames", "run.npz", "--format", "svg", "--quiet", "-o", "same", "--times", "0,1,2"])
    assert Path("figures/run-frames.svg").read_bytes() == Path("same/run-frames.svg").read_bytes()


def test_seed_changes_the_robot_positions() -> None:
    for seed in ("1", "2"):
        main(["figures", "anger-frames", "--format", "svg", "--quiet", "--seed", seed, "-o", seed])
    assert Path("1/anger-frames.svg").read_bytes() != Path("2/anger-frames.svg").read_bytes()


def test_figures_of_another_study_leave_out_missing_groups(capsys) -> None:
    main(["study", "simulate", "-o", "m.csv", "--participants", "12"])
    main(["study", "analyze", "m.csv", "-o", "results", "--quiet"])
    capsys.readouterr()
    Path("marked.json").write_bytes(
        b"\xef\xbb\xbf" + Path("results/results.json").read_bytes()
    )  # as some editors write
    sources = ("results", "results/results.json", "results/confusion_matrix.csv", "marked.json")
    for number, source in enumerate(sources):
        arguments = ["confusion-matrix", "--study", source, "--format", "svg", "--quiet"]
        assert main(["figures", *arguments, "-o", f"of-{number}"]) == 0
    (made,) = {Path(f"of-{number}/confusion-matrix.svg").read_bytes() for number in range(len(sources))}
    assert main(["figures", "confusion-matrix", "--format", "svg", "--quiet"]) == 0
    assert Path("figures/confusion-matrix.svg").read_bytes() != made
    assert main(["figures", "accuracy-gender", "--study", "results", "-o", "none"]) == 2
    why = "the study has no group gender; its groups: none"
    assert capsys.readouterr().err == f"accuracy-gender: {why}\n"
    assert not Path("none").exists()
    assert main(["figures", "all", "--study", "results", "--format", "md", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)["figures"]) == ["attributes", "behaviours"]


def test_figures_without_data_are_left_out(capsys, monkeypatch) -> None:
    few = {name: CATALOGUE[name] for name in ("gritsbot", "accuracy-gender", "confusion-matrix")}
    monkeypatch.setattr("emovid.workflows.figures.CATALOGUE", few)
    main(["study", "analyze", "--counts", str(ROOT / "studies/santos-egerstedt/counts.csv"), "-o", "r", "--quiet"])
    assert main(["figures", "all", "--study", "r", "--format", "svg"]) == 0
    assert {path.name for path in Path("figures").iterdir()} == {"gritsbot.svg", "confusion-matrix.svg"}
    assert capsys.readouterr().err.splitlines() == [
        "[1/2] figures/gritsbot: svg",
        "[2/2] figures/confusion-matrix: svg",
        "accuracy-gender: left out: the study has no group gender; its groups: none",
    ]


def test_results_with_an_invalid_group_are_refused(capsys) -> None:
    main(["study", "analyze", "--counts", str(ROOT / "studies" / "santos-egerstedt" / "counts.csv"), "--quiet"])
    results = json.loads(Path("results/results.json").read_bytes())
    Path("results/results.json").write_text(json.dumps(results | {"groups": {"gender": {"female": {}}}}))
    assert main(["figures", "circumplex", "--study", "results"]) == 2
    expected = "results/results.json: not results; expected the results.json of emovid study analyze\n"
    assert capsys.readouterr().err == expected
    Path("results/results.json").write_text(json.dumps(results | {"groups": {"gender": {}}}))  # of one level only
    assert main(["figures", "circumplex", "--study", "results", "--format", "svg", "--quiet"]) == 0


def test_an_unwritable_folder_is_reported_before_figures_are_drawn(monkeypatch, capsys) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)  # root can always write
    assert main(["figures", "gritsbot", "-o", "theirs"]) == 1
    assert capsys.readouterr().err == "-o theirs: cannot be written to\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "expected names of figures, all, gallery, or --list to see them"),
        (["anger-frame"], "anger-frame: no such figure (did you mean anger-frames?); --list shows them"),
        (["awe.yaml"], "awe.yaml: no such figure (did you mean frames awe.yaml?); --list shows them"),
        (["awe.MP4"], "awe.MP4: no such figure (did you mean contact-sheet awe.MP4?); --list shows them"),
        (["gritsbot", "zzz"], "zzz: no such figure; --list shows them"),
        (
            ["gritsbot", "--format", "pfd"],
            "--format pfd: expected one of pdf, png, svg, eps, tex, md, html (did you mean pdf?)",
        ),
        (["gritsbot", "--format", "tex"], "gritsbot: cannot be written as tex; expected one of pdf, png, svg, eps"),
        (
            ["gritsbot", "--style", "two-colum"],
            "--style two-colum: expected one-column or two-column (did you mean two-column?)",
        ),
        (["gritsbot", "--times", "0"], "--times goes with frames or contact-sheet, and a scene"),
        (["gritsbot", "--set", "seed=1"], "--set goes with frames or contact-sheet, and a scene"),
        (["gallery", "--format", "pdf"], "gallery: cannot be written as pdf; it is gallery.html"),
        (["galery"], "galery: no such figure (did you mean gallery?); --list shows them"),
        (["gallery", "-o", "full"], "full/gallery.html: is a folder; expected a file that can be replaced"),
        (["frames"], "frames: expected one scene: a file (.yaml), a finished run (.npz), or an emotion"),
        (
            ["frames", "fear", "anger"],
            "frames: expected one scene: a file (.yaml), a finished run (.npz), or an emotion",
        ),
        (["frames", "contact-sheet", "fear"], "frames and contact-sheet: expected one of them at a time"),
        (["all", "frames", "fear"], "all and frames: expected one of them at a time"),
        (["frames", "feer"], "feer: no such file or emotion (did you mean fear?)"),
        (["frames", "fear", "--times", "0,16"], "--times 0,16: 16 s is outside the run of 0 to 15 s"),
        (["frames", "fear", "--times", "-1"], "--times -1: -1 s is outside the run of 0 to 15 s"),
        (["frames", "fear", "--times", "0,nan"], "--times 0,nan: nan s is outside the run of 0 to 15 s"),
        (["frames", "fear", "--times", "0;2"], "--times 0;2: expected seconds with commas between, as in 0,2,8"),
        (["frames", "fear", "--times", ",".join(101 * "1")], "--times: 101 times; expected at most 100"),
        (["frames", "none.npz"], "none.npz: cannot be read: no such file or directory"),
        (["circumplex", "--study", "none.json"], "none.json: cannot be read: no such file or directory"),
        (["gritsbot", "-o", "file"], "-o file: is a file; expected a folder"),
        (["gritsbot", "-o", "file/in"], "-o file/in: cannot be made: not a directory"),
        (["gritsbot", "-o", "full"], "full/gritsbot.png: is a folder; expected a file that can be replaced"),
    ],
)
def test_invalid_input_gives_one_line_and_writes_no_file(capsys, arguments, message) -> None:
    Path("file").write_text("as it was")
    Path("full/gritsbot.png").mkdir(parents=True)
    Path("full/gallery.html").mkdir()
    assert main(["figures", *arguments]) == 2
    said = capsys.readouterr()
    assert (said.err, said.out) == (message + "\n", "")
    assert files() == {"file"}


@pytest.mark.parametrize("text", ["{}", "[]", '{"counts": [[1]], "labels": ["a"], "emotions": ["a"], "groups": [1]}'])
def test_file_without_results_is_refused(capsys, text) -> None:
    Path("x.json").write_text(text)
    assert main(["figures", "confusion-matrix", "--study", "x.json"]) == 2
    expected = "x.json: not results; expected the results.json of emovid study analyze\n"
    assert capsys.readouterr().err == expected


def test_seed_without_room_for_the_robots_writes_no_file(capsys, monkeypatch) -> None:
    main(["scene", "new", "mine.yaml", "--from", "fear"])
    Path("mine.yaml").write_text(Path("mine.yaml").read_text().replace("robots: 15", "robots: 900"))
    assert main(["figures", "frames", "mine.yaml"]) == 2
    assert "robots do not fit" in capsys.readouterr().err
    assert files() == {"mine.yaml", "emovid-scene.schema.json"}


def test_progress_bar_names_the_figures() -> None:
    ours, theirs = pty.openpty()
    environment = {key: value for key, value in os.environ.items() if key != "CI"} | {"TERM": "xterm"}
    command = [*EMOVID, "figures", "gritsbot", "diffeomorphism-trajectory", "--format", "svg"]
    done = subprocess.Popen(command, stderr=theirs, stdout=subprocess.DEVNULL, env=environment)
    os.close(theirs)
    said = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # the way Linux reports a closed other end
            break
        if not part:
            break
        said += part
    assert done.wait() == 0
    assert b"2/2" in said
    assert b"figures/diffeomorphism-trajectory" in said
    os.close(ours)


def test_only_the_figures_command_imports_matplotlib() -> None:
    script = "import sys, emovid.cli.main; assert not {'matplotlib', 'numpy', 'pandas'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", script], check=True)


def test_figure_with_other_content_is_replaced_only_with_force(capsys) -> None:
    frames = ["figures", "frames", "sadness", "--set", "duration=1", "--format", "svg", "--quiet"]
    assert main([*frames, "--times", "0"]) == 0
    assert main([*frames, "--times", "0"]) == 0  # the same
    before = Path("figures/sadness-frames.svg").read_bytes()
    capsys.readouterr()
    assert main([*frames, "--times", "1"]) == 2
    refused = "figures/sadness-frames.svg exists with other content; use --force to overwrite it, or -o\n"
    assert capsys.readouterr().err == refused
    assert Path("figures/sadness-frames.svg").read_bytes() == before
    assert main([*frames, "--times", "1", "--force"]) == 0
    assert Path("figures/sadness-frames.svg").read_bytes() != before


def test_no_figure_is_written_if_one_of_them_exists_with_other_content() -> None:
    Path("figures").mkdir()
    Path("figures/gritsbot.svg").write_text("mine")
    assert main(["figures", "attributes", "gritsbot", "--format", "svg", "--format", "md", "--quiet"]) == 2
    assert files() == {"figures/gritsbot.svg"}


def test_single_figure_in_a_text_format_is_printed(capsysbinary) -> None:
    assert main(["figures", "attributes", "--format", "md", "--quiet"]) == 0
    assert main(["figures", "attributes", "--format", "md", "-o", "-", "--quiet"]) == 0
    assert capsysbinary.readouterr().out == Path("figures/attributes.md").read_bytes()
    for arguments in (["attributes"], ["gritsbot", "--format", "png"], ["gritsbot", "shapes", "--format", "svg"]):
        assert main(["figures", *arguments, "-o", "-"]) == 2
        assert b"-o -: prints one figure in one --format of html, md, svg, tex" in capsysbinary.readouterr().err
    assert files() == {"figures/attributes.md"}


@pytest.mark.parametrize("name", ["fig3.pdf", "fig3.png", "fig3.eps", "a.zip", "b.ogv"])
def test_file_as_output_folder_is_refused(name, capsys) -> None:
    assert main(["figures", "gritsbot", "-o", name]) == 2
    assert capsys.readouterr().err == f"-o {name}: cannot write .{name.partition('.')[2]}; expected a folder\n"
    assert files() == set()
