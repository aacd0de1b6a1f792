"""YADE settles a bed: ``bed.py``, run in parts until it is still, and kept as it goes on."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from packgen.errors import SolverError
from packgen.settling.run import RUN_MAX, SILENCE_MAX, STILL_SPEED, TIMES_MAX, Left, Order
from packgen.validation.process import describe_output, find_solver, run_solver
from packgen.validation.still import CALM_TIMES, LOOKS, Looks, free_fall_time, speed_unit

NAME = "yade"
SCRIPT = "packgen_settle.py"
KEPT, RESTART = "packgen_kept.npz", "packgen_kept.yade.gz"

SETTLE = """\
import os

import numpy as np

setup_only = True
exec(compile(open("bed.py").read(), "bed.py", "exec"))
spheres = [O.bodies[index] for index in range({count})]


def keep(done, speed, still):
    # Each file appears whole or not at all.
    position = [tuple(each.state.pos) for each in spheres]
    np.savez("packgen_part.npz", position=position, steps=done, speed=speed, still=still, timestep=O.dt)
    O.save("packgen_part.yade.gz")
    os.replace("packgen_part.yade.gz", "{restart}")
    os.replace("packgen_part.npz", "{kept}")


every = max(1, int({free_fall!r} / {looks} / O.dt))
steps = max(1, int(np.ceil({seconds!r} / O.dt)))
done = calm = 0
kept, speed = -1, 0.0
print("packgen run", steps, every, repr(O.dt), flush=True)
while done < steps and not (calm and calm * every * O.dt >= {calm_time!r}):
    if done // (every * {looks}) > kept:
        kept = done // (every * {looks})
        keep(done, speed, False)
    part = min(every, steps - done)
    O.run(part, True)
    done += part
    speed = sum(each.state.vel.norm() for each in spheres) / {count}
    calm = calm + 1 if speed < {still_speed!r} else 0
    print("packgen look", done, repr(speed), flush=True)
keep(done, speed, bool(calm and calm * every * O.dt >= {calm_time!r}))
print("packgen done", flush=True)
"""


def run(order: Order) -> Left:
    """Settle a bed.

    Raises:
        SolverError: YADE does not run the deck to the end.
    """
    bed, folder = order.bed, order.folder
    free_fall = free_fall_time(bed)
    text = SETTLE.format(
        count=bed.count, restart=RESTART, kept=KEPT, looks=LOOKS, free_fall=free_fall,
        seconds=TIMES_MAX * free_fall if order.time is None else order.time,
        calm_time=CALM_TIMES * free_fall,
        still_speed=STILL_SPEED * speed_unit(bed) if order.time is None else 0.0,
    )  # fmt: skip
    (folder / SCRIPT).write_text(text, encoding="ascii")
    (folder / KEPT).unlink(missing_ok=True)
    order.kept.read = lambda: _left(order)
    tell = None

    def on_line(line: str) -> None:
        nonlocal tell
        told = re.fullmatch(r"packgen run (\d+) (\d+) (\S+)", line.strip())
        if told:
            looks = order.looks(float(told[3]))
            tell = order.progress(Looks(int(told[1]), int(told[2]), looks.calm, looks.speed), float(told[3]))
        seen = re.fullmatch(r"packgen look (\d+) (\S+)", line.strip())
        if seen and tell is not None:
            tell(int(seen[1]), float(seen[2]))

    command = [str(find_solver(NAME)), "-n", "-x", "-j1", SCRIPT]
    output = run_solver(NAME, command, folder, silence_max=SILENCE_MAX, seconds_max=RUN_MAX, on_line=on_line)
    left = _left(order, "\n".join(output))
    if left is None or "packgen done" not in output:
        raise SolverError(f"{NAME}: ended before its last step; it said:\n{describe_output(output)}")
    return left


def _left(order: Order, output: str = "") -> Left | None:
    """Return what was kept last; None where nothing was, or it cannot be read."""
    try:
        with np.load(order.folder / KEPT) as file:
            steps, timestep = int(file["steps"]), float(file["timestep"])
            version = re.search(r"Yade [^\s,]+", output)
            restart: Path = order.folder / RESTART
            return Left(
                index=np.arange(order.bed.count),
                position=file["position"].reshape(-1, 3),
                steps=steps,
                time=steps * timestep,
                speed=float(file["speed"]) / speed_unit(order.bed),
                still=bool(file["still"]),
                version=version.group() if version else "",
                restart=restart if restart.exists() else None,
            )
    except (OSError, ValueError, KeyError, EOFError):
        return None
