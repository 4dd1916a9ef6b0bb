"""Commands of a documentation page with the output shown there, and a runner for them."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any

import pytest
import yaml

from emovid.cli.main import main
from tests.helpers import exports
from tests.helpers.crowd import Crowd
from tests.helpers.served import serving
from tests.helpers.small_survey import small_kit

ROOT = Path(__file__).parent.parent.parent
DOCS = ROOT / "docs"

_BLOCKS = re.compile(
    r'^```(?P<kind>[a-z]+)(?: title="(?P<title>[^"]*)")?\n(?P<text>.*?)^```$|(?P<indented>(?:^    emovid [^\n]*\n)+)',
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Command:
    """A command line, with its output, or None if the page shows no output."""

    line: str
    printed: str | None = None


@dataclass(frozen=True)
class Keys:
    """Keys to write into a YAML file, replacing existing ones."""

    file: str
    text: str


def pages() -> list[Path]:
    """Return the README and the pages of the documentation."""
    return [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


def mentioned(page: Path) -> list[str]:
    """Return the commands named in the text or the tables of a page."""
    return re.findall(r"`(emovid [^`]*)`", page.read_text().replace("\n", " "))


def in_tables(page: Path) -> list[str]:
    """Return the commands in table cells of a page."""
    rows = re.findall(r"^\|.*\|$", page.read_text(), re.MULTILINE)
    return [command for row in rows for command in re.findall(r"`(emovid [^`]*)`", row)]


def steps(page: Path) -> Iterator[Command | Keys]:
    """Yield the steps of a reader of the page, in order."""
    for block in _BLOCKS.finditer(page.read_text()):
        if block["indented"]:
            for line in block["indented"].splitlines():
                yield Command(line.split(" #")[0].strip())
        elif block["kind"] == "console":
            for part in re.split(r"^\$ ", block["text"], flags=re.MULTILINE)[1:]:
                line, _, printed = part.partition("\n")
                yield Command(line, printed)
        elif block["kind"] == "yaml" and (block["title"] or "").split(":")[0].endswith(".yaml"):
            yield Keys(block["title"].split(":")[0], block["text"])


def agrees(said: str, printed: str) -> bool:
    """Return whether output matches the page, where `...` matches anything and column spacing may differ."""
    parts = [re.escape(" ".join(part.split())) for part in printed.split("...")]
    return re.fullmatch(r".*".join(parts), " ".join(said.split()), re.DOTALL) is not None


ENV = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "COLUMNS": "200",
}
REFERENCE = ROOT / "studies" / "santos-egerstedt" / "responses.csv"
SMALL = {"video.size: 1280x720": "size: 320x180", "size: 1280x720": "size: 320x180", "fps: 30": "fps: 5"}
EXAMPLES = {
    "qualtrics": exports.qualtrics,
    "google-forms": exports.google_sheets,
    "microsoft-forms": exports.microsoft,
    "surveymonkey": exports.surveymonkey,
    "limesurvey": exports.limesurvey,
    "jspsych": exports.jspsych,
    "psychopy": exports.psychopy,
    "labjs": exports.labjs,
    "otree": exports.otree_wide,
    "psiturk": exports.psiturk,
    "pymushra": exports.pymushra,
    "formr": exports.formr,
    "revisit": exports.revisit,
    "sosci": exports.sosci,
    "unipark": exports.unipark,
    "redcap": exports.redcap,
    "typeform": exports.typeform,
    "opensesame": exports.opensesame,
    "eprime": exports.eprime,
    "gorilla": exports.gorilla,
    "labvanced": exports.labvanced,
    "pcibex": exports.pcibex,
    "mturk": exports.mturk,
    "any-table": exports.generic_long,
    "index": lambda: exports.Export({"reference.csv": REFERENCE.read_bytes()}, "long table"),
}


def small(source: Path) -> str:
    """Return a scene or study file with a video that renders quickly."""
    text = source.read_text()
    for large, little in SMALL.items():
        text = text.replace(large, little)
    return text


def given(page: Path, folder: Path) -> dict[str, str]:
    """Put the files of a reader of the page into the folder, and return replacements for placeholders of the page."""
    if page.stem != "survey":  # the answers of the reader get this name
        (folder / "responses.csv").write_bytes(REFERENCE.read_bytes())
    if page.parent.name == "analyse":
        export = EXAMPLES[page.stem]()
        (folder / "key.csv").write_text(exports.KEY)
        (folder / "exports").mkdir()
        for name, data in export.files.items():
            (folder / "exports" / name).write_bytes(data)
        if len(export.files) == 1:
            (folder / "export.csv").write_bytes(*export.files.values())
        return {}
    (folder / "table.csv").write_text("a,b\n1,2\n")
    scene = "robotarium-today/anger" if page.stem == "export-robotarium" else "anger"
    (folder / "my_scene.yaml").write_text(small(ROOT / "configs" / f"{scene}.yaml"))
    (folder / "sweep.yaml").write_text(
        "only: measure\nscenes: [sadness]\nset: {duration: 1}\ngrid: {robot.K: [2, 3]}\n"
    )
    if page.name != "README.md" and "videos/" in page.read_text():
        run("emovid render --all --size 320x180 --fps 5 --set duration=2 --quiet", folder)
    words = {"$SLURM_ARRAY_TASK_ID": "1"}
    return words | {"CODE": code_of_a_participant(folder)} if page.stem == "survey" else words


def code_of_a_participant(folder: Path) -> str:
    """Build a kit, let three participants take part, and return the code of one."""
    with serving(small_kit(folder)) as server:
        crowd = Crowd(server.address, 3, duration=1.0)
        crowd.start()
        crowd.wait()
    assert crowd.failures == []
    return crowd.people[0].code


def run(line: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run a command in this process, or in a separate one if only a signal ends it."""
    command = shlex.split(line)
    assert command[0] == "emovid", line
    if command[1:3] == ["study", "serve"]:
        return started_and_stopped([*command, "--port", "0"], folder)
    return started_and_stopped(command, folder) if "--watch" in command else called(command, folder)


def called(command: list[str], folder: Path) -> "subprocess.CompletedProcess[str]":
    """Return the exit code and the output of a command that is called as a function."""
    out = TextIOWrapper(BytesIO(), encoding="utf-8", write_through=True)
    err = TextIOWrapper(BytesIO(), encoding="utf-8", write_through=True)
    with chdir(folder), redirect_stdout(out), redirect_stderr(err), pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "200")
        code = main(command[1:])
    said, complained = (stream.buffer.getvalue().decode() for stream in (out, err))  # type: ignore[attr-defined]
    return subprocess.CompletedProcess(command, code, said, complained)


def started_and_stopped(command: list[str], folder: Path) -> "subprocess.CompletedProcess[str]":
    """Wait for the first line of a command, and stop it with SIGTERM, since SIGINT may be ignored."""
    with subprocess.Popen(
        command, cwd=folder, env=ENV, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as it:
        assert it.stdout
        said = it.stdout.readline()
        it.terminate()
        said += it.stdout.read()
        code = it.wait()
    return subprocess.CompletedProcess(command, 0 if code in (0, 143) else code, said, "")


def write(keys: Keys, folder: Path) -> None:
    path = folder / keys.file
    have = yaml.safe_load(path.read_text()) if path.is_file() else {}
    path.write_text(yaml.safe_dump(merged(have, yaml.safe_load(keys.text))))


def merged(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """Return keys merged over keys. A group of another kind replaces the group."""
    result = dict(old)
    for key, value in new.items():
        deeper = isinstance(value, dict) and isinstance(old.get(key), dict) and "kind" not in value
        result[key] = merged(old[key], value) if deeper else value
    return result


def follow(page: Path, folder: Path) -> None:
    """Follow the steps of a page, in a folder with the files of its reader."""
    words = given(page, folder)
    for step in steps(page):
        if isinstance(step, Keys):
            write(step, folder)
            continue
        line = re.sub("|".join(map(re.escape, words)) or "$^", lambda word: words[word[0]], step.line)
        if line.startswith("emovid render ") and "--size" not in line and step.printed is None:
            line += " --size 320x180 --fps 5"  # more frames and larger ones would show nothing more
        done = run(line, folder)
        said = done.stdout + done.stderr
        if step.line.startswith("emovid study new "):  # which the reader copies and edits
            study = folder / step.line.split()[3] / "study.yaml"
            study.write_text(small(study).replace("duration: 15", "duration: 3"))
        if step.printed is None:
            assert done.returncode == 0, f"{step.line}\n{said}"
        else:
            assert agrees(said, step.printed), f"{step.line}\n{said}"
            assert "Traceback" not in said
