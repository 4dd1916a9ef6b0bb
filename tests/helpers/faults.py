"""The faults of the chaos suite: signals at random times, full disks, broken encoders, folders and files."""

import os
import random
import resource
import shutil
import signal
import stat
import subprocess
import time
from contextlib import suppress

from emovid.video import ffmpeg
from tests.helpers.containers import UNSHARE, unshare_works
from tests.helpers.owners import DEAD
from tests.helpers.trial import NAMES, SMALL, Fault, TooLateError, Trial, family

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
VICTIMS = {"the command": "", "a worker": "spawn_main", "ffmpeg": "libx264"}


def at_random(rng: random.Random, number: signal.Signals, victim: str) -> Fault:
    """Return the fault of a signal to the command, a worker or an ffmpeg at a random time of the run."""

    def inject(trial: Trial) -> None:
        process = trial.start()
        time.sleep(rng.random() * trial.seconds)
        hit = False
        if pid := _victim(process, VICTIMS[victim], rng):
            with suppress(ProcessLookupError):  # the process has just ended
                os.kill(pid, number)
                hit = True
        trial.finish(process)
        if not hit:
            raise TooLateError

    killed = number == signal.SIGKILL and victim == "the command"
    return Fault(f"{number.name} to {victim}", inject, "ffmpeg" if victim == "ffmpeg" else "", killed=killed)


def _victim(process: "subprocess.Popen[str]", word: str, rng: random.Random) -> int | None:
    """Return a process to signal; wait for the first if there is none yet."""
    while process.poll() is None:
        if not word:
            return process.pid
        if found := [pid for pid, line in family(process.pid).items() if word in line]:
            return rng.choice(found)
        time.sleep(0.005)
    return None


def _undisturbed(trial: Trial) -> None:
    trial.finish(trial.start())


def with_ffmpeg(name: str, script: str, cause: str, first: str = "pass") -> Fault:
    """Return the fault of a script in place of ffmpeg; `$real` is the real one, the last argument its output.

    The command runs in a single process, after the code `first`.
    """

    def inject(trial: Trial) -> None:
        fake = trial.folder.parent / "ffmpeg"
        answer = f'real=\'{ffmpeg.executable()}\'; case "$*" in *-version*|*progress*) exec "$real" "$@";; esac'
        fake.write_text(f"#!/bin/bash\n{answer}\n{script}\n")
        fake.chmod(fake.stat().st_mode | stat.S_IXUSR)
        trial.environment["IMAGEIO_FFMPEG_EXE"] = str(fake)
        trial.first = first
        trial.command = ["render", "--all", "-o", str(trial.folder), *SMALL, "--force", "--jobs", "1"]
        _undisturbed(trial)

    return Fault(name, inject, cause, fails=True)


def _without_ffmpeg(trial: Trial) -> None:
    trial.environment["IMAGEIO_FFMPEG_EXE"] = "/nowhere/ffmpeg"
    _undisturbed(trial)


def _limited(trial: Trial) -> None:
    trial.before = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8_000, 8_000))
    trial.environment["COVERAGE_PROCESS_CONFIG"] = ""  # the data of `make coverage` would exceed the limit, too
    _undisturbed(trial)


def _on_small_disk(trial: Trial) -> None:
    _mounted(trial, "size=100k", _undisturbed)


def _read_only(trial: Trial) -> None:
    if os.geteuid():
        trial.folder.chmod(0o555)
        _undisturbed(trial)
        trial.folder.chmod(0o755)
    else:  # even root cannot write here
        _mounted(trial, "ro", _undisturbed)


def _mounted(trial: Trial, options: str, run) -> None:
    """Run with a separate file system as the folder, and copy its files to the real folder afterward."""
    real, inside = trial.folder, trial.folder.with_name("inside")
    inside.mkdir()
    subprocess.run([shutil.which("mount") or "mount", "-t", "tmpfs", "-o", options, "tmpfs", str(inside)], check=True)
    try:
        trial.folder = inside
        run(trial)
        trial.folder, trial.said = real, trial.said.replace(str(inside), str(real))
        for path in inside.iterdir():
            shutil.copy2(path, real / path.name)
    finally:
        subprocess.run([shutil.which("umount") or "umount", str(inside)], check=True)


def _vanishing(trial: Trial) -> None:
    process = trial.start()
    while process.poll() is None and not any(path.suffix == ".part" for path in trial.folder.iterdir()):
        time.sleep(0.005)
    trial.folder.rename(trial.folder.with_name("gone"))
    trial.finish(process)


def _two_runs(trial: Trial) -> None:
    first, second = trial.start(), trial.start()
    trial.finish(first)
    trial.finish(second)


def _in_containers(trial: Trial) -> None:
    trial.prefix = UNSHARE  # so that both have the process number 1
    _two_runs(trial)


def _closed_stderr(trial: Trial) -> None:
    trial.before = lambda: os.close(2)
    _undisturbed(trial)


def _stale_files(trial: Trial) -> None:
    for name in (f".{NAMES[0]}.{DEAD}.part", f".other.mp4.{DEAD}.part"):
        (trial.folder / name).write_bytes(b"half")
    (trial.folder / f".manifest.json.{DEAD}.journal").write_text('["x", {"only": "vid')
    (trial.folder / ".manifest.json.lock").write_bytes(b"")
    _undisturbed(trial)


def damaged(rng: random.Random, name: str) -> Fault:
    """Return the fault of a file that changes between two runs: truncated, or with other bytes."""

    def inject(trial: Trial) -> None:
        _undisturbed(trial)
        path = trial.folder / name
        data = bytearray(path.read_bytes())
        if rng.random() < 0.5:
            data = data[: rng.randrange(len(data))]
        else:
            for _ in range(8):
                data[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(data)
        _undisturbed(trial)

    return Fault(f"a damaged {'manifest' if name.endswith('.json') else 'video'}", inject)


_IMPATIENT = "import emovid.video.ffmpeg as ffmpeg; ffmpeg.IDLE_TIMEOUT = 0.3"


def lasting() -> list[Fault]:
    """Return the faults that last for the whole run."""
    faults = [
        Fault("a limit on the size of files", _limited, "file too large", fails=True),
        with_ffmpeg("a full device", '"$real" "${@:1:$#-1}" /dev/full', "No space left on device"),
        with_ffmpeg("an ffmpeg that writes nothing", "cat > /dev/null; exit 0", "ffmpeg wrote 0 of 30 frames"),
        with_ffmpeg("an ffmpeg that loses frames", 'head -c 1000000 | "$real" "$@"; cat > /dev/null', "of 30 frames"),
        with_ffmpeg(
            "an ffmpeg that dies midway", "head -c 1000000 > /dev/null; echo on fire >&2; exit 3", "status 3: on fire"
        ),
        with_ffmpeg("an ffmpeg that is killed midway", "head -c 1000000 > /dev/null; kill -9 $$", "status -9: killed"),
        with_ffmpeg("an ffmpeg that hangs at the start", "exec sleep 1000", "ffmpeg hangs", _IMPATIENT),
        with_ffmpeg(
            "an ffmpeg that hangs at the end",
            "cat > /dev/null; exec sleep 1000 < /dev/null",
            "ffmpeg hangs",
            _IMPATIENT,
        ),
        Fault("no ffmpeg", _without_ffmpeg, "/nowhere/ffmpeg: no such file", fails=True),
        Fault("a folder that cannot be written to", _read_only, "choose another folder", fails=True),
        Fault("a folder that vanishes", _vanishing, "is its folder still there?", fails=True),
        Fault("two runs into one folder", _two_runs),
        Fault("stale temporary files", _stale_files),
        Fault("a closed stderr", _closed_stderr),
    ]
    if unshare_works():
        faults.append(Fault("two runs in containers with equal process numbers", _in_containers))
    if not os.geteuid():
        faults.append(Fault("a small disk", _on_small_disk, "no space left on device: free some space", fails=True))
    return faults
