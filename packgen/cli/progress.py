"""Progress on screen: a bar with rate and time left on a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, TextIO, cast

from packgen.cli.screen import Screen, say, show
from packgen.stopping import tidied

PLAIN_INTERVAL = 5.0  # seconds between plain lines
SHOW_CURSOR = "\x1b[?25h"  # a bar hides it


class Step(Protocol):
    """What the core tells of its progress."""

    @property
    def stage(self) -> str:
        """What is being done."""

    @property
    def placed(self) -> int:
        """Spheres placed so far."""

    @property
    def total(self) -> int | None:
        """Spheres to place; None: until full."""

    @property
    def height(self) -> float:
        """Filled fraction, from 0 to 1."""


Listener = Callable[[Any], None]


@dataclass(frozen=True, slots=True)
class Share:
    """Progress of something that counts no spheres: what is being done, and the share of it that is."""

    stage: str
    height: float
    placed: int = 0
    total: int | None = None


def done_fraction(step: Step) -> float:
    """Return how much of the work is done, from 0 to 1: by number where it is known, else by height."""
    share = step.placed / step.total if step.total else step.height
    return min(max(share, 0.0), 1.0)


class Pace:
    """Rate and time left, counted from the first step: what came before it is compilation."""

    def __init__(self) -> None:
        self._first: tuple[float, int, float] | None = None

    def describe(self, step: Step, now: float) -> str:
        """Return a line of progress: stage, spheres, rate, time left.

        Args:
            step: Where the core is.
            now: Time on any clock [s].

        Returns:
            Such as ``arrange: 12,000 of 430,062 spheres, 31,000/s, 14 s left``.
        """
        done = done_fraction(step)
        if self._first is None:
            self._first = now, step.placed, done
        since, placed, fraction = now - self._first[0], step.placed - self._first[1], done - self._first[2]
        if step.placed == 0 and not step.total:
            text = f"{step.stage}: {done:.0%}"
        else:
            of_total = f" of {step.total:,}" if step.total else ""
            text = f"{step.stage}: {step.placed:,}{of_total} spheres"
        if placed > 0 and since > 0.0:
            text += f", {placed / since:,.0f}/s"
        if fraction > 0.0 and done < 1.0:
            text += f", {duration(since * (1.0 - done) / fraction)} left"
        return text


def duration(seconds: float) -> str:
    """Return a duration in words that suit its size: ``14 s``, ``3 min 05 s``, ``2 h 10 min``."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


@contextmanager
def show_progress(stream: TextIO, *, quiet: bool = False) -> Iterator[Listener]:
    """Give the function that the core calls with its progress.

    Args:
        stream: Where to write, standard error as a rule.
        quiet: Write nothing.

    Yields:
        The listener.
    """
    if quiet:
        yield lambda _: None
    elif stream.isatty():
        with _terminal(stream) as listener:
            yield listener
    else:
        yield _plain(stream)


def _plain(stream: TextIO) -> Listener:
    pace = Pace()
    last = time.monotonic()

    def listen(step: Any) -> None:
        nonlocal last
        now = time.monotonic()
        text = pace.describe(step, now)
        if now - last >= PLAIN_INTERVAL:
            last = now
            say(text, stream)

    return listen


@contextmanager
def _terminal(stream: TextIO) -> Iterator[Listener]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    pace = Pace()
    console = Console(file=cast("TextIO", Screen(stream)))
    columns = BarColumn(), TextColumn("{task.percentage:>3.0f}% {task.description}")
    with (
        Progress(*columns, console=console, transient=True) as bar,
        tidied(partial(show, SHOW_CURSOR, stream)),
    ):
        task = bar.add_task("starting", total=1.0)

        def listen(step: Any) -> None:
            text = pace.describe(step, time.monotonic())
            bar.update(task, completed=done_fraction(step), description=text)

        yield listen
