"""The scheduler and its workers: limits on parallel items and attempts; the death of a worker affects only its item."""

import os
import signal
import time
import warnings
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from multiprocessing import Pipe
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emovid.batch import workers
from emovid.batch.scheduler import run
from emovid.batch.workers import InProcess, Processes, _Slot
from emovid.errors import EmovidError, SourceError


class DeathError(Exception):
    pass


class Threads:
    """A pool that counts running items, with workers that die as configured."""

    attempts, deaths = 3, (DeathError,)

    def __init__(self, slots: int, dies: dict[int, int]) -> None:
        self.slots, self.dies = slots, dict(dies)
        self.under_way = self.most = 0
        self.threads = ThreadPoolExecutor(slots)

    def submit(self, work, item) -> Future:
        self.under_way += 1
        self.most = max(self.most, self.under_way)
        future = self.threads.submit(self._do, work, item)
        future.add_done_callback(self._end)
        return future

    def _do(self, work, item):
        if self.dies.get(item, 0) > 0:
            self.dies[item] -= 1
            raise DeathError
        return work(item, None)

    def _end(self, _: Future) -> None:
        self.under_way -= 1


@given(st.integers(1, 3), st.integers(0, 12), st.dictionaries(st.integers(0, 11), st.integers(0, 5)))
@settings(max_examples=50)
def test_every_item_ends_once_although_workers_die(slots, count, dies) -> None:
    told: list[tuple[int, int]] = []
    pool = Threads(slots, dies)
    with pool.threads:
        ended = list(run(_double, range(count), pool, lambda item, attempt: told.append((item, attempt))))
    assert sorted(item for item, _ in ended) == list(range(count))
    assert pool.most <= slots
    for item, outcome in ended:
        deaths = dies.get(item, 0)
        assert sorted(attempt for other, attempt in told if other == item) == list(range(1, min(deaths, 2) + 1))
        if deaths < 3:
            assert outcome == item * 2
        else:
            assert str(outcome) == "its worker died in every attempt: killed, or out of memory"


def _double(item, on_step):
    return item * 2


def _fail(item, on_step):
    raise item


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (SourceError("x.yaml:3", "too many", key="robots"), "x.yaml:3: robots: too many"),
        (OSError(28, "No space left on device"), "no space left on device"),
        (MemoryError(), "not enough memory: fewer robots, a longer control_period or a shorter duration need less"),
    ],
)
def test_failure_is_reported_in_one_line(error, message) -> None:
    ((_, outcome),) = run(_fail, [error], InProcess(lambda *_: None))
    assert isinstance(outcome, EmovidError)
    assert str(outcome) == message


def test_unexpected_error_names_its_location_in_the_code(tmp_path) -> None:
    ((_, outcome),) = run(_fail, [ZeroDivisionError("division by zero")], InProcess(lambda *_: None))
    assert str(outcome).startswith("unexpected ZeroDivisionError: division by zero, at test_scheduler.py:")
    ((_, outcome),) = run(_fail, [ValueError("not one line,\n  but two")], InProcess(lambda *_: None))
    assert str(outcome).startswith("unexpected ValueError: not one line, but two, at test_scheduler.py:")


def test_interrupt_is_not_reported_as_a_failed_item() -> None:
    with pytest.raises(KeyboardInterrupt):
        list(run(_fail, [KeyboardInterrupt()], InProcess(lambda *_: None)))


# --- real processes ---------------------------------------------------------------------------------------------------


def _work(item, on_step):
    """Run an item: (name, file that counts attempts, number of attempts that end in this signal)."""
    name, file, deaths, number = item
    with file.open("a") as tries:
        tries.write(f"{os.getpid()}\n")
    if len(file.read_text().splitlines()) <= deaths:
        os.kill(os.getpid(), number)
        time.sleep(60)
    on_step(1, 2)
    deadline = time.monotonic() + 60
    while not file.with_suffix(".heard").exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return name


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_dead_worker_affects_only_its_item(tmp_path, number) -> None:
    deaths = {"a": 0, "b": 2, "c": 0, "d": 9, "e": 0}
    work = [(name, tmp_path / name, count, number) for name, count in deaths.items()]
    heard, died = [], []

    def hear(item, done, total) -> None:
        heard.append((item[0], done, total))
        item[1].with_suffix(".heard").touch()

    with closing(Processes(2, hear)) as pool:
        ended = dict(run(_work, work, pool, lambda item, attempt: died.append((item[0], attempt))))
    assert {item[0] for item, outcome in ended.items() if isinstance(outcome, EmovidError)} == {"d"}
    assert sorted(died) == [("b", 1), ("b", 2), ("d", 1), ("d", 2)]
    tries = {name: len((tmp_path / name).read_text().splitlines()) for name in deaths}
    assert tries == {"a": 1, "b": 3, "c": 1, "d": 3, "e": 1}
    assert sorted(heard) == [(name, 1, 2) for name in "abce"]


def test_progress_of_a_replacement_worker_arrives_after_a_late_death_notice() -> None:
    slot, (last, its_end) = _Slot(), Pipe()
    its_end.close()
    with closing(Processes(1, lambda *_: None)) as pool:
        pool._slots.append(slot)  # a process that ends with the pool
        slot.submit(_succeed, 1).result(60)
        slot.receive(last, lambda *_: None)
        assert slot.open_lines


def test_a_worker_that_died_while_idle_is_replaced() -> None:
    with closing(Processes(1, lambda *_: None)) as pool:
        idle = pool.submit(_pid, 1).result(60)
        os.kill(idle, signal.SIGKILL)
        executor = pool._slots[0]._pool
        assert executor
        deadline = time.monotonic() + 60
        while not executor._broken:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert pool.submit(_pid, 2).result(60) != idle


def test_late_progress_reports_are_dropped() -> None:
    slot, (line, worker) = _Slot(), Pipe()
    heard = []
    slot._number = 2
    for number, done in ((1, 8), (2, 3)):
        worker.send((number, done, 9))
        slot.receive(line, lambda *told: heard.append(told))
    assert heard == [(None, 3, 9)]


def _pid(item, on_step) -> int:
    return os.getpid()


def _succeed(item, on_step) -> bool:
    return True


def test_worker_warnings_are_one_line(capfd) -> None:
    with closing(Processes(1, lambda *_: None)) as pool:
        pool.submit(_warn, "mind the gap").result(60)
    assert capfd.readouterr().err == "warning: mind the gap\n"


def _warn(item: str, on_step) -> None:
    warnings.warn(item, RuntimeWarning, stacklevel=1)


def _sleep(item: Path, on_step) -> None:
    item.touch()
    try:
        time.sleep(60)
    finally:
        item.unlink()


def test_closing_a_pool_diskards_unfinished_work(tmp_path) -> None:
    marks = [tmp_path / name for name in "ab"]
    with closing(Processes(2, lambda *_: None)) as pool:
        for mark in marks:
            pool.submit(_sleep, mark)
        deadline = time.monotonic() + 60
        while not all(mark.exists() for mark in marks):
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert list(tmp_path.iterdir()) == []


def _hang(item: Path, on_step) -> None:
    workers._GRACE = 0.1  # in this worker
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    item.touch()
    time.sleep(30)
    item.write_text("undisturbed")


def test_worker_that_ignores_sigterm_is_killed(tmp_path) -> None:
    with closing(Processes(1, lambda *_: None)) as pool:
        pool.submit(_hang, tmp_path / "a")
        deadline = time.monotonic() + 60
        while not (tmp_path / "a").exists():
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert (tmp_path / "a").read_text() == ""
