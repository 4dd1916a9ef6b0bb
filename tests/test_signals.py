"""Signals that come at a bad moment: they act later, and none is lost."""

import signal
import threading

import pytest

from emovid.signals import held_signals


class SentError(BaseException):
    """What a signal raises here; no `Exception`, as what ends a program is none."""


@pytest.fixture(autouse=True, params=[signal.SIGINT, signal.SIGTERM])
def number(request):
    def act(number, _):
        raise SentError(number)

    before = signal.signal(request.param, act)
    yield request.param
    signal.signal(request.param, before)


def test_held_signal_is_raised_at_the_end_of_the_block(number) -> None:
    done = []

    @held_signals()
    def work() -> None:
        signal.raise_signal(number)
        done.append("the rest")

    with pytest.raises(SentError):
        work()
    assert done == ["the rest"]
    with pytest.raises(SentError):
        signal.raise_signal(number)


def test_held_signal_is_raised_at_the_end_of_the_outermost_block(number) -> None:
    done = []

    @held_signals()
    def work() -> None:
        with held_signals():
            signal.raise_signal(number)
        done.append("the rest")

    with pytest.raises(SentError):
        work()
    assert done == ["the rest"]


def test_held_signal_takes_precedence_over_an_error(number) -> None:
    @held_signals()
    def fail() -> None:
        signal.raise_signal(number)
        raise ValueError

    with pytest.raises(SentError):
        fail()


def test_holding_signals_in_other_threads_has_no_effect(number) -> None:
    inside, over = threading.Event(), threading.Event()

    def hold() -> None:
        with held_signals():
            inside.set()
            over.wait(60)

    thread = threading.Thread(target=hold)
    thread.start()
    inside.wait(60)
    with pytest.raises(SentError):
        signal.raise_signal(number)
    over.set()
    thread.join()
