from __future__ import annotations

import signal
import sys

import pytest

from packgen.stopping import answer, close, heed, held, stop_seen, stoppable


@pytest.fixture(autouse=True)
def stopping():
    def tell():
        raise AssertionError("the main thread ends by itself")

    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT), sys.unraisablehook
    with stoppable(tell):
        yield
    assert before == (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT), sys.unraisablehook)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_stops(number):
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(number)
    assert stop_seen()


def test_a_stop_waits_until_what_must_be_whole_is_done():
    done = []

    def work():
        with held():
            with held():
                signal.raise_signal(signal.SIGTERM)
                done.append("inner")
            done.append("outer")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == ["inner", "outer"]


def test_after_an_answer_stops_are_ignored_until_they_are_heeded_again():
    answer()
    signal.raise_signal(signal.SIGTERM)
    assert not stop_seen()
    heed()
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGTERM)


def test_the_last_line_is_not_cut():
    close()
    signal.raise_signal(signal.SIGTERM)


def test_what_is_ignored_stays_so():
    former = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stoppable(lambda: 0):
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, former)
