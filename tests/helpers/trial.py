"""One fault, injected into the real command during rendering, and the required state afterward.

After every fault, each video is absent, the old one, or complete; the exit code is 0 only if all are complete; the
message names the file, the cause and the remedy; no process and no temporary file is left (after SIGKILL of the command
itself, by the next run); and the next run makes exactly what is missing.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stderr, suppress
from dataclasses import dataclass, field
from functools import cache
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

from emovid.atomic_io import file_digest
from emovid.batch.manifest import read_manifest
from emovid.cli.main import main
from emovid.scene.emotions import EMOTIONS

NAMES = [f"{emotion}.mp4" for emotion in EMOTIONS]
SMALL = ["--size", "320x240", "--fps", "15", "--set", "duration=2", "--jobs", "2"]
OLD = b"the old one"
REMEDIES = (
    "run again to make what is missing",
    "free some space",
    "choose another folder",
    "IMAGEIO_FFMPEG_EXE names it: unset this variable",
)
INTERRUPTED = (130, 143, -signal.SIGTERM, -signal.SIGKILL)
# A run in the background may ignore SIGINT, and child processes inherit that.
START = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); print('ready', flush=True);"
    "{first}; from emovid.__main__ import run; run()"
)


@dataclass
class Trial:
    """A run of the command in a separate folder, and its output.

    Attributes:
        folder: of the videos; it contains one older video at the start.
        reference: the same videos, rendered without a fault.
        seconds: duration of a run without a fault.
        environment: additional environment variables of the command.
        command: what runs; by default all six videos in two processes.
        first: Python that the command runs first.
        before: called in its process first.
        prefix: program that starts the command, for example in a separate namespace.
    """

    folder: Path
    reference: Path
    seconds: float
    environment: dict[str, str] = field(default_factory=dict)
    command: list[str] = field(default_factory=list)
    first: str = "pass"
    before: Callable[[], None] | None = None
    prefix: list[str] = field(default_factory=list)
    said: str = ""
    code: int = 0
    sessions: list[int] = field(default_factory=list)

    def start(self) -> "subprocess.Popen[str]":
        """Start the command, and return once Python itself has started."""
        command = self.command or ["render", "--all", "-o", str(self.folder), *SMALL, "--force"]
        process = subprocess.Popen(
            [*self.prefix, sys.executable, "-c", START.format(first=self.first), *command],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env=os.environ | self.environment,
            preexec_fn=self.before,  # noqa: PLW1509 - this process has no other thread
        )
        self.sessions.append(process.pid)
        assert process.stdout
        process.stdout.readline()
        return process

    def finish(self, process: "subprocess.Popen[str]") -> None:
        """Wait for the end of the command; keep the worst exit code with its output."""
        try:
            said = process.communicate(timeout=180)[1]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            said = process.communicate()[1] + "\nstill running after three minutes"
        if process.returncode or not self.code:
            self.said, self.code = said, process.returncode


@dataclass(frozen=True)
class Fault:
    """A fault.

    Attributes:
        name: in the table.
        inject: runs the command in a trial with the fault.
        cause: the words that its messages must contain.
        fails: whether the command must fail; otherwise it may.
        killed: whether the command itself may be killed without cleaning up.
    """

    name: str
    inject: Callable[[Trial], None]
    cause: str = ""
    fails: bool = False
    killed: bool = False


class TooLateError(Exception):
    """The command ended before the fault was injected."""


def try_fault(fault: Fault, reference: Path, seconds: float) -> list[str]:
    """Inject a fault into a separate run, again if it came too late; return violations."""
    while True:
        with TemporaryDirectory(prefix="emovid-chaos-") as place, suppress(TooLateError):
            trial = Trial(Path(place) / "videos", reference, seconds)
            trial.folder.mkdir()
            (trial.folder / NAMES[-1]).write_bytes(OLD)
            fault.inject(trial)
            return [*_violations(trial, fault), *_violations_of_next_run(trial)]


@cache
def reference_run(folder: Path) -> float:
    """Render the six videos without a fault, and return the duration [s]."""
    started = time.monotonic()
    subprocess.run([sys.executable, "-m", "emovid", "render", "--all", "-q", "-o", str(folder), *SMALL], check=True)
    return time.monotonic() - started


def family(pid: int) -> dict[int, str]:
    """Return the command lines of the descendants of a process."""
    found: dict[int, str] = {}
    todo, all_of_them = [pid], _processes()
    while todo:
        mother = todo.pop()
        children = {child: line for child, (parent, _, line) in all_of_them.items() if parent == mother}
        found |= children
        todo += children
    return found


def hidden(folder: Path) -> list[str]:
    """Return the temporary files in a folder."""
    return sorted(path.name for path in folder.iterdir() if path.name.startswith("."))


def left_of(sessions: list[int]) -> list[str]:
    """Return the command lines of processes left in sessions, after some time to end."""
    deadline = time.monotonic() + 20
    while left := [line for _, session, line in _processes().values() if session in sessions]:
        if time.monotonic() > deadline:
            break
        time.sleep(0.05)
    return left


def _violations(trial: Trial, fault: Fault) -> list[str]:
    there = {name: (trial.folder / name).read_bytes() for name in NAMES if (trial.folder / name).exists()}
    complete = [name for name, data in there.items() if data == (trial.reference / name).read_bytes()]
    found = [
        f"{name} is neither absent, nor the old one, nor complete: {len(data)} bytes"
        for name, data in there.items()
        if name not in complete and data != OLD
    ]
    # With all videos complete, the command may have been interrupted after the last one.
    allowed = (0, *INTERRUPTED) if len(complete) == len(NAMES) and not fault.fails else (1, *INTERRUPTED)
    if trial.code not in allowed:
        found.append(f"exit code {trial.code} with {len(complete)} of {len(NAMES)} complete: {trial.said[-500:]}")
    if trial.code not in (0, *INTERRUPTED):
        found += _unsaid(trial, fault)
    if "Traceback" in trial.said or "unexpected" in trial.said:
        found.append(f"a traceback: {trial.said[-1500:]}")
    if left := left_of(trial.sessions):
        found.append(f"processes left: {left}")
    if not fault.killed and trial.folder.is_dir() and hidden(trial.folder):
        found.append(f"temporary files left: {hidden(trial.folder)}")
    return found


def _unsaid(trial: Trial, fault: Fault) -> list[str]:
    """Return what the messages of a failed run lack: files, reasons, or remedies."""
    lines = [line for line in trial.said.splitlines() if not line.startswith("[")]
    failures = [line for line in lines if f"{trial.folder}/" in line and "another worker tries again" not in line]
    if len(lines) == 1:  # the whole command failed before any video
        failures = lines
    if not failures or not all(fault.cause.lower() in line.lower() for line in failures):
        return [f"what failed is not said: {trial.said[-500:]}"]
    return [] if any(remedy in lines[-1] for remedy in REMEDIES) else [f"what to do is not said: {lines[-1]}"]


def _violations_of_next_run(trial: Trial) -> list[str]:
    trial.folder.mkdir(exist_ok=True)
    known = read_manifest(trial.folder)
    done = {
        name
        for name in NAMES
        if name in known and (trial.folder / name).is_file() and file_digest(trial.folder / name) == known[name].sha256
    }
    for name in NAMES:  # a file of the user, which only --force replaces
        if (trial.folder / name).is_file() and (trial.folder / name).read_bytes() == OLD:
            (trial.folder / name).unlink()
    with redirect_stderr(StringIO()) as stderr:
        code = main(["render", "--all", "-o", str(trial.folder), *SMALL, "--jobs", "1"])
    said = stderr.getvalue()
    made = {name for name in NAMES if f"{name}: 30 frames" in said}
    found = [] if code == 0 else [f"the next run fails: {said[-500:]}"]
    if made != set(NAMES) - done:
        found.append(f"the next run makes {sorted(made)}, with {sorted(done)} done")
    for name in [*NAMES, "presentation_order.csv", "manifest.json"]:
        path = trial.folder / name
        if not path.is_file() or path.read_bytes() != (trial.reference / name).read_bytes():
            found.append(f"after the next run, {name} is not as it should be")
    if hidden(trial.folder):
        found.append(f"temporary files left by the next run: {hidden(trial.folder)}")
    return found


def _processes() -> dict[int, tuple[int, int, str]]:
    """Return the parent, the session and the command line of each process that has not ended, from /proc."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, parent, _, session = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
                line = (entry / "cmdline").read_text().replace("\0", " ")
            except (OSError, ValueError):
                continue  # the process has ended in the meantime
            if state != "Z":
                found[int(entry.name)] = (int(parent), int(session), line)
    return found
