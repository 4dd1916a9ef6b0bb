"""Faults that could lose or leak data: kills during a replacement, files of others, withdrawal during a read."""

import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from emovid.atomic_io import clear_leftovers
from emovid.cli.main import main
from emovid.survey.store import Store, Withdrawal
from tests.helpers.tiny import STUDY, make_kit_of_placeholders

# Replaces a folder again and again by two renames, as on systems that cannot exchange two folders.
_REPLACE = """
from itertools import count
from pathlib import Path
from emovid import atomic_io

atomic_io._exchange = lambda *_: False
for version in count():
    with atomic_io.whole_folder(Path("folder")) as part:
        for name in ("a", "b"):
            (part / name).write_text(str(version))
    if not version:
        print("ready", flush=True)
"""
_FOREIGN = {
    "manifest.json": b'{"short_name": "App"}',
    "plan.json": b'{"thesis": "chapter 1"}',
    "results.csv": b"participant,answer\np1,anger\n",
    "contact-sheet.png": b"my picture",
}
_SWEEP = "scenes: [fear]\nset: {duration: 0.4, video.size: 96x64, video.fps: 5}\n"
_TEXT = "Liechtenstein"


def kill_while_replacing(rng: random.Random) -> list[str]:
    """Kill a process that replaces a folder, at a random moment; return what was violated."""
    with TemporaryDirectory() as place:
        process = subprocess.Popen([sys.executable, "-c", _REPLACE], cwd=place, stdout=subprocess.PIPE)
        assert process.stdout
        process.stdout.readline()
        time.sleep(rng.uniform(0, 0.1))
        process.send_signal(signal.SIGKILL)
        process.communicate()
        clear_leftovers(Path(place))
        found = [f"{path.name} left" for path in Path(place).iterdir() if path.name != "folder"]
        files = [Path(place, "folder", name) for name in ("a", "b")]
        versions = {file.read_text() if file.is_file() else "nothing" for file in files}
        return found + ([] if len(versions) == 1 and versions != {"nothing"} else [f"not a whole folder: {versions}"])


def meet_foreign_file(rng: random.Random) -> list[str]:
    """Make a sweep in a folder with a file of another program; return what was violated."""
    name = rng.choice(list(_FOREIGN))
    with TemporaryDirectory() as place, redirect_stderr(StringIO()) as said:
        folder = Path(place, "mine")
        folder.mkdir()
        (folder / name).write_bytes(_FOREIGN[name])
        Path(place, "s.yaml").write_text(_SWEEP)
        force = rng.choice([[], ["--force"]])
        code = main(["sweep", str(Path(place, "s.yaml")), "-o", str(folder), "--jobs", "1", *force])
        found = [] if code == 2 else [f"exit code {code}"]
        found += [] if f"{name}: was not written by emovid" in said.getvalue() else [f"{name} is not named"]
        kept = {path.name: path.read_bytes() for path in folder.iterdir()} == {name: _FOREIGN[name]}
        return found + ([] if kept else [f"{name} or its folder was changed"])


def withdraw_during_read(rng: random.Random) -> list[str]:
    """Withdraw a participant while another program reads the database; return what was violated."""
    with TemporaryDirectory() as place:
        kit = make_kit_of_placeholders(Path(place), f"{STUDY}choices: random\n")
        path = Path(place, "answers.sqlite")
        store = Store(path, kit.manifest.key_commitment, patience=rng.uniform(0.05, 0.3))
        person = store.enroll("digest", kit.orders, kit.choices, "1", 60.0)
        store.tell(person.id, {"country": _TEXT})
        reader = sqlite3.connect(path, isolation_level=None)
        if reads := rng.random() < 0.8:
            reader.execute("BEGIN")
            reader.execute("SELECT * FROM participants").fetchall()
        outcome = store.withdraw("digest")
        found = _leaked(path) if outcome is Withdrawal.DELETED else []
        if not reads and outcome is not Withdrawal.DELETED:
            found.append(f"{outcome} although nobody reads")
        reader.close()
        if store.withdraw("digest") is not Withdrawal.DELETED:
            found.append("not deleted after the reader has gone")
        found += _leaked(path)
        store.close()
        return found


def _leaked(path: Path) -> list[str]:
    data = b"".join(file.read_bytes() for file in path.parent.glob(f"{path.name}*"))
    return ["deleted, it says, but the text is still there"] if _TEXT.encode() in data else []


LOSSES = {
    "SIGKILL while a folder is replaced by two renames": kill_while_replacing,
    "a file of another program in the folder": meet_foreign_file,
    "withdrawal while another program reads": withdraw_during_read,
}
