"""A signal that comes while a layer is arranged raises its own error, and never ends the process."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
import signal, sys
import numpy as np
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import settle
from packgen.arrange.space.walls import wall_table
from packgen.geometry import Box

walls = wall_table([Box(np.zeros(3), np.ones(3))], np.array([[0.0] * 3, [1.0] * 3]), 0.05)
rng, down = np.random.default_rng(1), np.array([0.0, 0.0, -1.0])
ball = np.column_stack([rng.random((60, 3)), np.full(60, 0.05)])
settle(ball, 60, walls, down, Recipe())

class Stop(Exception):
    pass

def stop(*_):
    raise Stop

signal.signal(signal.SIGALRM, stop)
heard = 0
while heard < 100:
    try:
        signal.setitimer(signal.ITIMER_REAL, 1e-4 + 0.01 * rng.random())
        for _ in range(1000):
            settle(ball, 60, walls, down, Recipe())
    except Stop:
        heard += 1
signal.setitimer(signal.ITIMER_REAL, 0.0)
print(heard)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no timers")
def test_a_signal_inside_a_compiled_loop_is_heard_as_itself():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-1000:]
    assert done.stdout == "100\n"
