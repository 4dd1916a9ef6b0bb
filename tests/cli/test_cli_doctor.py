import errno
import json
import tempfile
import webbrowser
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from emovid.cli.main import main
from emovid.errors import RenderError
from emovid.workflows import doctor


def found(capsys) -> dict[str, dict]:
    return {check["name"]: check for check in json.loads(capsys.readouterr().out)["checks"]}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_intact_installation_passes_and_leaves_no_files(tmp_path, capsys) -> None:
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[-1] == "all required checks pass"
    assert (
        sum(line.startswith(("ok       mp4: encoded by ffmpeg ", "ok       webm", "ok       gif")) for line in said)
        == 3
    )
    assert f"folder {tmp_path}: writable" in "\n".join(said)
    assert list(tmp_path.iterdir()) == []


def test_ffmpeg_that_does_not_encode_fails_with_a_remedy(capsys, monkeypatch) -> None:
    def render(*_: object) -> str:
        raise RenderError("run.mp4: ffmpeg failed with exit status 1: Unknown encoder 'libx264'")

    monkeypatch.setattr("emovid.video.render.render_video", render)
    assert main(["doctor"]) == 1
    lines = capsys.readouterr().out.splitlines()
    at = lines.index("FAILED   mp4: run.mp4: ffmpeg failed with exit status 1: Unknown encoder 'libx264'")
    assert "imageio-ffmpeg" in lines[at + 1]
    assert lines[-1] == "1 required checks fail"
    assert any(line.startswith("missing  webm: ") for line in lines)


def test_doctor_runs_the_real_ffmpeg(capsys, monkeypatch) -> None:
    from emovid.video import ffmpeg

    monkeypatch.setattr(ffmpeg, "executable", lambda: "/bin/false")
    assert main(["doctor", "--json"]) == 1
    assert "ffmpeg failed with exit status 1" in found(capsys)["mp4"]["found"]


def test_missing_and_old_packages_are_named(capsys, monkeypatch) -> None:
    def version(name: str) -> str:
        if name == "scipy":
            raise PackageNotFoundError(name)
        return {"numpy": "1.26.4"}.get(name, "999")

    monkeypatch.setattr(doctor, "version", version)
    assert main(["doctor", "--json"]) == 1
    check = found(capsys)["packages"]
    assert check["found"] == "numpy 1.26.4 is older than 2.1; scipy is missing"
    assert check["remedy"] == "pip install 'numpy>=2.1' 'scipy>=1.15'"


def test_missing_optional_packages_do_not_fail(capsys, monkeypatch) -> None:
    needs = ["numpy>=2.1", "nowhere>=1; extra == 'cloud'", "pytest; extra == 'dev'"]
    monkeypatch.setattr(doctor, "requires", lambda _: needs)
    assert main(["doctor", "--json"]) == 0
    checks = found(capsys)
    assert checks["extra cloud"] == {
        "name": "extra cloud",
        "passed": False,
        "needed": False,
        "found": "nowhere is missing",
        "remedy": "pip install 'nowhere>=1'",
    }
    assert "extra dev" not in checks


def test_installed_browser_is_named(capsys, monkeypatch) -> None:
    monkeypatch.setattr(
        doctor, "_BROWSERS", ("no-such-browser", "sh")
    )  # the first that is installed, also without a screen
    assert main(["doctor", "--json"]) == 0
    assert found(capsys)["browser"]["found"] == "sh"
    monkeypatch.setattr(doctor, "_BROWSERS", ())
    monkeypatch.setattr(webbrowser, "get", lambda: webbrowser.GenericBrowser("surf"))
    assert main(["doctor", "--json"]) == 0
    assert found(capsys)["browser"]["found"] == "surf"

    def none() -> None:
        raise webbrowser.Error("could not locate runnable browser")

    monkeypatch.setattr(webbrowser, "get", none)
    assert main(["doctor", "--json"]) == 0
    assert found(capsys)["browser"]["passed"] is False


def test_full_or_missing_folder_fails(tmp_path, monkeypatch) -> None:
    assert doctor._writing(tmp_path).passed
    gone = doctor._writing(tmp_path / "gone")
    assert (gone.passed, gone.found) == (False, "no such file or directory")
    monkeypatch.setattr(doctor, "_ROOM", 10**18)
    full = doctor._writing(tmp_path)
    assert (full.passed, full.needed) == (False, True)
    assert full.remedy.startswith("free some space")


def test_missing_temporary_folder_is_reported(capsys, monkeypatch) -> None:
    def none() -> str:
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found in ['/tmp']")

    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setattr(tempfile, "_get_default_tempdir", none)
    assert main(["doctor", "--json"]) == 1
    check = found(capsys)["folder for temporary files"]
    assert (check["passed"], check["found"]) == (False, "no usable temporary directory found in ['/tmp']")


def test_only_failing_checks_have_a_remedy(monkeypatch) -> None:
    monkeypatch.setattr(doctor, "requires", lambda _: ["nowhere"])
    for check in doctor.checks(Path("/nowhere")):
        assert bool(check.remedy) == (not check.passed), check
