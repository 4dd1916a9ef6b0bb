"""Many videos: which are missing, and making those, in this process or in several."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from emovid.batch.manifest import Record, add_to_manifest, is_current, read_manifest, recipe, record
from emovid.errors import EmovidError, RenderError
from emovid.scene.model import Scene
from emovid.signals import blocked_signals, unblock_signals
from emovid.swarm.simulate import simulate
from emovid.swarm.trajectory import Trajectory
from emovid.video.render import render_video


@dataclass(frozen=True)
class Job:
    """One video to make.

    Attributes:
        scene: what it shows.
        target: the file, in a folder that exists.
        run: the trajectory, if there is one already.
    """

    scene: Scene
    target: Path
    run: Trajectory | None = None

    @property
    def run_digest(self) -> str | None:
        """SHA-256 of the given trajectory."""
        return self.run.digest() if self.run else None


class Reporter(Protocol):
    """Is told how the work goes, from the process and thread that called `make_videos`, or a thread of it."""

    def advanced(self, job: Job, frames: int) -> None:
        """A job has so many frames done."""

    def finished(self, job: Job, entry: Record, *, made: bool) -> None:
        """A job's video is there: made now, or before."""


class Stopped(Exception):  # noqa: N818 - a signal, not an error
    """Raised in a worker when the parent wants it to end."""


def make_videos(jobs: Sequence[Job], workers: int, reporter: Reporter, *, force: bool = False) -> dict[Path, Record]:
    """Make the videos that are missing or out of date, and record each in its folder's manifest as it is done.

    Args:
        jobs: their targets' folders exist.
        workers: processes to use at once.
        reporter: hears of progress.
        force: make all, whatever is there.

    Returns:
        The records of all jobs, by target.

    Raises:
        EmovidError: of the jobs that failed, after the others are done.
    """
    records: dict[Path, Record] = {}
    missing = []
    for job in jobs:
        known = read_manifest(job.target.parent).get(job.target.name)
        if not force and is_current(known, recipe(job.scene, job.run_digest), job.target):
            assert known is not None  # what is current has a record
            records[job.target] = known
            reporter.finished(job, known, made=False)
        else:
            missing.append(job)
    failures = []
    for job, outcome in _make(missing, workers, reporter):
        if isinstance(outcome, EmovidError):
            failures.append(outcome)
            continue
        add_to_manifest(job.target.parent, job.target.name, outcome)
        records[job.target] = outcome
        reporter.finished(job, outcome, made=True)
    if failures:
        raise failures[0] if len(failures) == 1 else EmovidError("; ".join(map(str, failures)))
    return {job.target: records[job.target] for job in jobs}


def make_video(job: Job, on_frame: Callable[[int], None] | None = None) -> Record:
    """Make one video and return its record."""
    trajectory = job.run or simulate(job.scene)
    render_video(trajectory, job.target, on_frame)
    return record(job.scene, trajectory, job.target, job.run_digest)


def _make(jobs: Sequence[Job], workers: int, reporter: Reporter) -> Iterator[tuple[Job, Record | EmovidError]]:
    """Yield the jobs, as they end, with the record or the failure of each."""
    if min(workers, len(jobs)) > 1:
        yield from _in_processes(jobs, min(workers, len(jobs)), reporter)
        return
    for job in jobs:
        try:
            yield job, make_video(job, lambda frames, job=job: reporter.advanced(job, frames))  # type: ignore[misc]
        except EmovidError as error:
            yield job, error


def _in_processes(jobs: Sequence[Job], workers: int, reporter: Reporter) -> Iterator[tuple[Job, Record | EmovidError]]:
    context = multiprocessing.get_context("spawn")  # forking a process with threads can deadlock
    stop, progress, over = context.Event(), context.SimpleQueue(), threading.Event()
    listener = threading.Thread(target=_listen, args=(progress, over, jobs, reporter), daemon=True)
    listener.start()
    pool = ProcessPoolExecutor(workers, context, _enter_worker, (stop, progress))
    try:
        futures: dict[Future[Record], Job] = {}
        with blocked_signals():  # a worker must not be interrupted before it can handle that
            for i, job in enumerate(jobs):
                futures[pool.submit(_work, i, job)] = job
        for future in as_completed(futures):
            try:
                yield futures[future], future.result()
            except EmovidError as error:
                yield futures[future], error
            except Stopped as error:
                yield futures[future], RenderError(f"{futures[future].target}: {error}")
    except BrokenProcessPool:
        raise RenderError("a worker process was killed: run again to make what is missing") from None
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)
        over.set()
        listener.join(1.0)  # a worker that was killed while it reported can leave it waiting


def _listen(progress: Any, over: threading.Event, jobs: Sequence[Job], reporter: Reporter) -> None:
    while not (over.wait(0.05) and progress.empty()):
        while not progress.empty():
            i, frames = progress.get()
            reporter.advanced(jobs[i], frames)


# --- in a worker process ---------------------------------------------------------------------------------------------

_stop: Any = None
_progress: Any = None


def _enter_worker(stop: Any, progress: Any) -> None:
    """Set up a worker process: it ends when the parent says so or is gone, not by a Ctrl-C of its own."""
    global _stop, _progress
    _stop, _progress = stop, progress
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    unblock_signals()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _on_sigterm(*_: object) -> None:
    raise Stopped("its worker process was terminated")


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)  # ffmpeg sees its input end; what it leaves has no final name


def _work(i: int, job: Job) -> Record:
    def on_frame(frames: int) -> None:
        if _stop.is_set():
            raise Stopped("stopped")
        _progress.put((i, frames))

    before = signal.signal(signal.SIGTERM, _on_sigterm)
    try:
        return make_video(job, on_frame)
    finally:
        signal.signal(signal.SIGTERM, before)
