"""The runs of a sweep, several at once, each a process of its own: one that crashes ends no other."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import IO, Generic, TypeVar

from packgen.stopping import held, tidied, unhurried

__all__ = ["Ended", "run_all"]

POLL = 0.05  # seconds between two looks
GRACE = 5.0  # seconds that a run has to tidy up after a stop

Key = TypeVar("Key")


@dataclass(frozen=True, slots=True)
class Ended(Generic[Key]):
    """A process that ended.

    Attributes:
        key: What it was started for.
        code: Its exit code.
        said: What it wrote on standard error.
    """

    key: Key
    code: int
    said: str


@dataclass(frozen=True, slots=True)
class _Running(Generic[Key]):
    key: Key
    process: subprocess.Popen[bytes]
    errors: IO[bytes]


def run_all(commands: Sequence[tuple[Key, Sequence[str]]], jobs: int) -> Iterator[Ended[Key]]:
    """Run packgen several times.

    Args:
        commands: The arguments of each run, with what it is called.
        jobs: How many run at once.

    Yields:
        Each run that has ended, at once.
    """
    waiting, running = deque(commands), list[_Running[Key]]()
    with contextlib.ExitStack() as ends:
        # A stop may come while this waits; the runs then tidy up first.
        ends.enter_context(unhurried())
        ends.enter_context(tidied(lambda: _end_all(running)))
        ends.callback(_end_all, running)
        while waiting or running:
            while waiting and len(running) < jobs:
                key, arguments = waiting.popleft()
                with held():
                    running.append(_start(key, arguments))
            for each in [one for one in running if one.process.poll() is not None]:
                running.remove(each)
                yield _ended(each)
            time.sleep(POLL)


def _start(key: Key, arguments: Sequence[str]) -> _Running[Key]:
    errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed when the run has ended)
    # -P: the current folder may hold one called packgen.
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "packgen", *arguments],
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors, start_new_session=True,
    )  # fmt: skip
    return _Running(key, process, errors)


def _ended(run: _Running[Key]) -> Ended[Key]:
    code = run.process.returncode
    run.errors.seek(0)
    said = run.errors.read().decode(errors="replace")
    run.errors.close()
    if code < 0:
        hint = "; was there enough memory?" if -code == signal.SIGKILL else ""
        said += f"\npackgen: was ended by signal {signal.Signals(-code).name}{hint}"
    return Ended(run.key, code, said)


def _end_all(running: Sequence[_Running[Key]]) -> None:
    """End what still runs, gently first: a run tidies up within a second."""
    left = [each.process for each in running if each.process.poll() is None]
    for process in left:
        with contextlib.suppress(ProcessLookupError):
            process.terminate()
    last = time.monotonic() + GRACE
    for process in left:
        try:
            process.wait(timeout=max(last - time.monotonic(), 0.1))
        except subprocess.TimeoutExpired:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
