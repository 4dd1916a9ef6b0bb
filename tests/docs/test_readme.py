"""The README and the tutorial: their commands run, print the output shown and write the files named."""

import json
import shutil
import subprocess
from pathlib import Path

from tests.helpers.pages import DOCS, ROOT, follow, in_tables, run


def test_readme_commands_work_as_described(tmp_path) -> None:
    page = ROOT / "README.md"
    follow(page, tmp_path)
    made = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*")}
    assert {"videos/anger.mp4", "videos/manifest.json", "fear.webm", "out/surprise.gif"} <= made
    assert {"curious.yaml", "previews/curious.gif", "kit/public/manifest.json", "kit/private/key.csv"} <= made
    assert {"figures/densities.pdf", "figures/curious-frames.png", "figures/anger-frames.pdf"} <= made
    assert {"results/report.html", "results/results.json", "results/confusion_matrix.tex"} <= made
    assert 1e6 < (tmp_path / "videos" / "anger.mp4").stat().st_size < 3e6  # as the questions say
    for line in in_tables(page):
        done = run(line, tmp_path)
        assert done.returncode == (1 if " diff " in line else 0), f"{line}\n{done.stdout}{done.stderr}"
    assert untracked(tmp_path) == []


def untracked(folder: Path) -> list[str]:
    """Return the files and folders in a folder that git would list if they stood in the repository."""
    git = shutil.which("git")
    if not git or not (ROOT / ".git").exists():
        return []
    names = [f"{path.name}/" if path.is_dir() else path.name for path in folder.iterdir()]
    command = [git, "check-ignore", "--no-index", *names]
    ignored = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    return sorted(set(names) - set(ignored))


def test_tutorial_emotion_moves_as_described(tmp_path) -> None:
    follow(DOCS / "tutorial.md", tmp_path)
    scenes = json.loads(run("emovid measure curious.yaml fear disgust --json", tmp_path).stdout)["scenes"]
    curious, fear, disgust = (scenes[name] for name in ("curious.yaml", "fear", "disgust"))
    assert curious["turning_per_metre"] < fear["turning_per_metre"] / 5
    assert curious["cusps_per_second"] < fear["cusps_per_second"] / 5
    assert curious["speed_mean"] < disgust["speed_mean"]
