"""Signals that end a run: within a second, with all tidied up, and never in the middle of what must be whole.

A stop is a ``KeyboardInterrupt`` in the main thread. Compiled code and libraries may hold it up, or turn it
into another error, or lose it; a thread that needs no turn of the main one then ends the process instead.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")  # Windows has no SIGHUP
PATIENCE = 0.6  # seconds that the main thread has to end by itself
LINE_TIME = 0.2  # seconds that the last line may take where nobody reads it


@dataclass
class _State:
    seen: bool = False  # a stop has come
    due: bool = False  # it came while it was held back
    answered: bool = False  # it has been heard; what follows is not to be cut
    closing: bool = False  # nothing but the last line is left
    held: int = 0
    unhurried: int = 0
    tidying: list[Callable[[], object]] = field(default_factory=list)


_state = _State()  # signals belong to the process, and so does what is known of them
_whole = threading.RLock()


def stop_seen() -> bool:
    """Return whether a stop has come that is not answered: any error after it is its work."""
    return _state.seen and not _state.answered


def answer() -> None:
    """Take the stop as heard: what follows is short, worth keeping, and not cut by another."""
    _state.answered, _state.seen, _state.due = True, False, False


def close() -> None:
    """Let no further stop cut the last line; where nobody reads it, the process ends without."""
    _state.closing = True


def heed() -> None:
    """Be stoppable again after an answer."""
    _state.answered = False


@contextmanager
def held() -> Iterator[None]:
    """Hold stops back until what is inside is done.

    Raises:
        KeyboardInterrupt: At the end, where one has come.
    """
    _state.held += 1
    try:
        with _whole:
            yield
    finally:
        _state.held -= 1
    if _state.due and not _state.held:
        _state.due = False
        raise KeyboardInterrupt


@contextmanager
def unhurried() -> Iterator[None]:
    """Let what is inside take its time to end after a stop, as it leaves something worth keeping."""
    _state.unhurried += 1
    try:
        yield
    finally:
        _state.unhurried -= 1


@contextmanager
def tidied(tidy: Callable[[], object]) -> Iterator[None]:
    """Have something done where the process is ended while in here; it may run beside the main thread."""
    _state.tidying.append(tidy)
    try:
        yield
    finally:
        _state.tidying.remove(tidy)


@contextmanager
def stoppable(tell: Callable[[], int], *, for_good: bool = False) -> Iterator[None]:
    """Let signals stop what is inside as Ctrl-C does.

    Args:
        tell: Says the last line and returns the exit code, where the main thread cannot.
        for_good: Ignore these signals afterwards: the process has said its last line and ends.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # Python handles signals in the main thread only
        return
    former = _handlers()
    _state.seen = _state.due = _state.answered = _state.closing = False
    ended = threading.Event()
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    former_hook, sys.unraisablehook = sys.unraisablehook, _unraisable
    former_fd = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(receiver, set(former), ended, tell), daemon=True).start()
    for number in former:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        close()
        ended.set()
        for number, handler in former.items():
            signal.signal(number, signal.SIG_IGN if for_good else handler)
        signal.set_wakeup_fd(former_fd)
        sender.close()
        if not for_good:
            sys.unraisablehook = former_hook


def _handlers() -> dict[int, Any]:
    """Return the signals to stop at, with their handlers; what is ignored stays so: nohup means it."""
    numbers = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    handlers = {number: signal.getsignal(number) for number in numbers}
    return {number: each for number, each in handlers.items() if each not in (signal.SIG_IGN, None)}


def _stop(_number: int, _frame: FrameType | None) -> None:
    if _state.answered or _state.closing:
        return
    _state.seen = True
    if _state.held:
        _state.due = True
        return
    raise KeyboardInterrupt


def _unraisable(error: sys.UnraisableHookArgs) -> None:
    """Say nothing of errors in callbacks and finalizers that a stop has cut."""
    if not stop_seen():
        sys.__unraisablehook__(error)


def _watch(
    receiver: socket.socket, numbers: set[int], ended: threading.Event, tell: Callable[[], int]
) -> None:
    """End the process where the main thread does not, soon after a stop."""
    with receiver:
        # A signal's number is written at once, also while compiled code keeps the main thread.
        while byte := receiver.recv(1):
            if byte[0] not in numbers:
                continue
            last = time.monotonic() + PATIENCE
            while not (ended.wait(0.05) or _state.answered):
                if time.monotonic() > last and not _state.unhurried:
                    _end_process(ended, tell)
                    break


def _end_process(ended: threading.Event, tell: Callable[[], int]) -> None:
    with _whole:  # what must be whole comes first, and nothing of the kind begins any more
        if ended.is_set() or _state.answered:
            return
        codes: list[int] = []
        for tidy in reversed(list(_state.tidying)):
            with contextlib.suppress(Exception):
                tidy()
        teller = threading.Thread(target=lambda: codes.append(tell()), daemon=True)
        teller.start()
        teller.join(LINE_TIME)
        os._exit(codes[0] if codes else 128 + signal.SIGINT)
