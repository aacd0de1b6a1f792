from __future__ import annotations

import io
from dataclasses import dataclass

import pytest

from packgen.cli import progress
from packgen.cli.progress import Pace, Share, duration, show_progress
from packgen.cli.screen import table


@dataclass
class Step:
    placed: int
    total: int | None = None
    height: float = 0.0
    stage: str = "arrange"


@pytest.mark.parametrize(
    ("seconds", "text"), [(3.4, "3 s"), (59.6, "1 min 00 s"), (185, "3 min 05 s"), (7800, "2 h 10 min")]
)
def test_durations_read_as_people_say_them(seconds, text):
    assert duration(seconds) == text


def line_after(first, later, seconds):
    """What is said of the later of two steps."""
    pace = Pace()
    pace.describe(first, 100.0)
    return pace.describe(later, 100.0 + seconds)


def test_a_counted_zone_tells_rate_and_time_left_by_number():
    line = line_after(Step(0, 1000, 0.1), Step(250, 1000, 0.1), 10.0)
    assert line == "arrange: 250 of 1,000 spheres, 25/s, 30 s left"


def test_an_endless_zone_tells_time_left_by_height():
    assert line_after(Step(0), Step(250, None, 0.5), 10.0) == "arrange: 250 spheres, 25/s, 10 s left"


def test_time_before_the_first_step_does_not_count():
    assert Pace().describe(Step(50, 1000), 60.0) == "arrange: 50 of 1,000 spheres"
    assert line_after(Step(500, 1000), Step(750, 1000), 5.0).endswith("50/s, 5 s left")


def test_a_solver_tells_its_share():
    line = line_after(Share("liggghts, gravity run", 0.0), Share("liggghts, gravity run", 0.25), 10.0)
    assert line == "liggghts, gravity run: 25%, 30 s left"


def test_elsewhere_than_on_a_terminal_lines_are_few(monkeypatch):
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    stream = io.StringIO()
    with show_progress(stream) as listen:
        for placed in range(1, 121):
            now = 0.1 * placed
            listen(Step(placed, 120))
    assert len(stream.getvalue().splitlines()) == 2
    assert "\x1b" not in stream.getvalue()


def test_quiet_says_nothing():
    stream = io.StringIO()
    with show_progress(stream, quiet=True) as listen:
        listen(Step(1))
    assert stream.getvalue() == ""


def test_a_terminal_gets_a_bar():
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    stream = Terminal()
    with show_progress(stream) as listen:
        listen(Step(50, 100))
    assert "\x1b" in stream.getvalue()


def test_a_table_is_aligned():
    assert table([("a", "1"), ("long", "2")]) == "a     1\nlong  2"
