"""YADE as a judge: ``bed.py``, run unedited by a script that measures, in one process.

Step 0 is a step of all engines but the integrator. The gravity run has a fiftieth of the work budget, since
YADE takes ten to thirty times as long a sphere and step as LIGGGHTS.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed, has_clumps
from packgen.check.parts import NO_PART
from packgen.errors import SolverError
from packgen.measure.particles import particle_count
from packgen.validation.contacts import Contacts, listed_error
from packgen.validation.measure import Trajectory, check_loaded, gravity_run, step_zero, steps_wanted
from packgen.validation.process import describe_output, find_solver, run_solver
from packgen.validation.results import Limits, SolverReport
from packgen.validation.still import CALM_TIMES, LOOKS, free_fall_time, speed_unit

NAME = "yade"
BUDGET_SHARE = 0.02
SPHERES_LEAST = 150  # a smaller bed counts for as many: what a step costs beside its spheres
SAMPLES = 50  # of the kinetic energy
START_SECONDS = 600.0
SPHERE_STEPS_A_SECOND = 2.0e3  # far below any machine's; slower than that is a hang
# YADE takes a facet for a sphere of twice the radius of the one that touches it, a plane for one as large.
FACET_RADIUS_FACTOR = 2 / 3
PLANE_RADIUS_FACTOR = 1 / 2
SCRIPT = "packgen_judge.py"
RESULTS = "packgen_judge.npz"

JUDGE = """\
import numpy as np

setup_only = True
exec(compile(open("bed.py").read(), "bed.py", "exec"))
count = {count}
newton = [each for each in O.engines if isinstance(each, NewtonIntegrator)][0]
newton.dead = True
O.step()
ids, values = [], []
for each in O.interactions:
    if each.isReal:
        ids.append((each.id1, each.id2))
        plane = any(isinstance(O.bodies[body].shape, Wall) for body in ids[-1])
        material = O.bodies[max(ids[-1])].material.id
        values.append((each.phys.normalForce.norm(), each.geom.penetrationDepth, plane, material))
spheres = [O.bodies[index] for index in range(count)]
start = [tuple(each.state.pos) for each in spheres]
radius = [each.shape.radius for each in spheres]
print("packgen timestep", repr(O.dt), flush=True)
steps = min(int({seconds!r} / O.dt) + 1, {steps_max})
newton.dead = False
energy, done, calm = [kineticEnergy()], 0, 0
every = max(1, min(steps // {samples}, int({calm_time!r} / {looks} / O.dt)))
while done < steps and calm * every * O.dt < {calm_time!r}:
    part = min(every, steps - done)
    O.run(part, True)
    done += part
    energy.append(kineticEnergy())
    speed = sum(each.state.vel.norm() for each in spheres) / count
    calm = calm + 1 if speed < {speed!r} else 0
    print("packgen step", done, "of", steps, flush=True)
end = [tuple(each.state.pos) for each in spheres]
np.savez("{results}", ids=np.array(ids, dtype=int).reshape(-1, 2),
         values=np.array(values, dtype=float).reshape(-1, 4), start=start, radius=radius,
         end=end, energy=energy, timestep=O.dt, steps=done,
         still=calm * every * O.dt >= {calm_time!r})
"""


def measure(
    bed: Bed, folder: Path, limits: Limits, on_progress: Callable[[str, float], None] | None
) -> SolverReport:
    """Run both measurements in ``folder``, a copy of the deck that may be written to.

    Raises:
        SolverError: YADE is missing, or does not run the deck to the end.
    """
    notify = on_progress or (lambda _stage, _share: None)
    notify("step 0", 0.0)

    def on_line(line: str) -> None:
        found = re.fullmatch(r"packgen step (\d+) of (\d+)", line.strip())
        if found:
            notify("gravity run", int(found[1]) / max(1, int(found[2])))

    allowed = replace(limits, work_budget=BUDGET_SHARE * limits.work_budget)
    steps_max = int(allowed.work_budget / max(bed.count, SPHERES_LEAST))
    text = JUDGE.format(
        count=bed.count,
        seconds=limits.free_fall_times * free_fall_time(bed),
        steps_max=steps_max,
        speed=limits.still_speed * speed_unit(bed),
        calm_time=CALM_TIMES * free_fall_time(bed),
        samples=SAMPLES,
        looks=LOOKS,
        results=RESULTS,
    )
    (folder / SCRIPT).write_text(text, encoding="ascii")
    seconds = START_SECONDS + allowed.work_budget / SPHERE_STEPS_A_SECOND
    command = [str(find_solver(NAME)), "-n", "-x", "-j1", SCRIPT]
    output = run_solver(
        NAME, command, folder, silence_max=limits.silence_max, seconds_max=seconds, on_line=on_line
    )
    try:
        return _report(bed, _results(folder), limits, allowed, output)
    except SolverError as error:
        raise SolverError(f"{NAME}: {error}; it said:\n{describe_output(output)}") from error


def _results(folder: Path) -> dict[str, Float64Array]:
    try:
        with np.load(folder / RESULTS) as file:
            return {name: file[name] for name in file.files}
    except FileNotFoundError:
        raise SolverError("the solver ended without writing its results") from None
    except (OSError, ValueError, EOFError) as error:
        raise SolverError(f"the solver's results cannot be read: {error}") from error


def _report(
    bed: Bed, found: dict[str, Float64Array], limits: Limits, allowed: Limits, output: tuple[str, ...]
) -> SolverReport:
    check_loaded(bed, found["start"].reshape(-1, 3), found["radius"])
    pairs, walls, factor = _contacts(bed, found)
    wanted, _ = steps_wanted(bed, allowed, float(found["timestep"]))
    steps = int(found["steps"])
    run = Trajectory(
        timestep=float(found["timestep"]),
        steps=steps,
        steps_wanted=max(wanted, steps),
        index=np.arange(bed.count),
        position=found["end"].reshape(-1, 3),
        energy=found["energy"],
        still=bool(found["still"]),
    )
    version = re.search(r"Yade \S+", "\n".join(output))
    return SolverReport(
        solver=NAME,
        version=version.group().rstrip(",") if version else NAME,
        sphere_count=bed.count,
        body_count=particle_count(bed) if has_clumps(bed) else None,
        step_zero=step_zero(bed, pairs, walls, listed_error(bed, walls, radius_factor=factor)),
        gravity_run=gravity_run(bed, found["start"], run),
        limits=limits,
    )


def _contacts(bed: Bed, found: dict[str, Float64Array]) -> tuple[Contacts, Contacts, Float64Array]:
    """Return contacts of spheres (ids below the bed's count), those with walls, and their radius factors."""
    low, high = found["ids"].min(axis=1), found["ids"].max(axis=1)
    at_wall = high >= bed.count
    force, overlap, plane, material = found["values"].T
    pairs = Contacts(low[~at_wall], high[~at_wall], force[~at_wall], overlap[~at_wall])
    factor = np.where(plane[at_wall], PLANE_RADIUS_FACTOR, FACET_RADIUS_FACTOR)
    part = None
    if bed.container.parts:
        # Materials are those of the sets, then of the parts, and last of the walls without a name.
        part = material[at_wall].astype(np.int64) - len(bed.particle_sets)
        part[part == len(bed.container.parts)] = NO_PART
    return pairs, Contacts(low[at_wall], None, force[at_wall], overlap[at_wall], part), factor
