"""Settled by a solver: a deck runs under its own friction until nothing moves, or for a time.

What the solver leaves becomes the bed: the spheres, their radii and their order stay those of the bed, the
positions are the solver's to the last digit, with the overlaps by which its contacts carry the load. The run
leaves a state for the solver to go on from, and keeps one now and then, so that a stop loses little.

Example::

    settled = settle(bed, Path("furnace/liggghts"), solver="liggghts")
    print(settled.still, settled.free_fall_times)

The rule of stillness is that of ``packgen.validation.still``, at a tenth of the speed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from packgen.bed import Bed
from packgen.bodies import in_one_piece, moved_bodies
from packgen.errors import SolverError
from packgen.measure.hertz import mean_radius
from packgen.measure.particles import particles_of
from packgen.reading.bed import wrapped
from packgen.settling import lammps_family, yade
from packgen.settling.run import TIMES_MAX, Left, Order, Settled, Tell
from packgen.stopping import answer, stop_seen
from packgen.validation.measure import outside
from packgen.validation.process import find_solver
from packgen.validation.still import free_fall_time

__all__ = ["TIMES_MAX", "Settled", "settle"]

_RUNS: Mapping[str, Callable[[Order], Left]] = {
    "liggghts": lammps_family.liggghts,
    "lammps": lammps_family.lammps,
    "yade": yade.run,
}
NAMED_MAX = 10


def settle(
    bed: Bed,
    folder: Path,
    *,
    solver: str = "liggghts",
    time: float | None = None,
    on_progress: Tell | None = None,
) -> Settled:
    """Let a solver run a deck, and return the bed that it leaves.

    Args:
        bed: The bed that the deck was written from; it has gravity, and something to lie on.
        folder: The deck; the run writes into it.
        solver: Name of the solver.
        time: How long it runs [s]; None: until the bed is still, or for `TIMES_MAX` free-fall times.
        on_progress: Called with what is to be told and the share of the run that is done, 0 to 1.

    Returns:
        The bed and how it came about. A stop, Ctrl-C, ends the run: what was reached is returned, and the
        stop is answered.

    Raises:
        SolverError: The solver is missing or unknown (exit code 2), or it failed or lost spheres (exit code
            1).
    """
    find_solver(solver, option="--settle")
    if not bed.rests:
        raise SolverError(f"{solver}: the bed has nothing to fall on: it cannot be settled", exit_code=2)
    order = Order(bed, folder, time, on_progress or (lambda _stage, _share: None))
    try:
        left = _RUNS[solver](order)
    except (Exception, KeyboardInterrupt) as error:
        if not (isinstance(error, KeyboardInterrupt) or stop_seen()):
            raise
        answer()
        return _reached(order, solver)
    return _settled(bed, solver, left)


def _reached(order: Order, solver: str) -> Settled:
    """Return what a run that was stopped had reached; the bed as it was where that is none."""
    try:
        return replace(_settled(order.bed, solver, order.kept.latest()), interrupted=True)
    except SolverError:  # spheres were lost
        return replace(_settled(order.bed, solver, order.kept.unmoved()), interrupted=True)


def _settled(bed: Bed, solver: str, left: Left) -> Settled:
    """Return the settled bed.

    Raises:
        SolverError: Spheres are missing, or outside the container.
    """
    free_fall = free_fall_time(bed)
    order = np.argsort(left.index, kind="stable")
    index, position = left.index[order], left.position[order]
    gone = np.setdiff1d(np.arange(bed.count), index)
    lost = np.union1d(gone, outside(bed, position, index))
    if len(lost) or len(index) != bed.count:
        named = ", ".join(str(each) for each in lost[:NAMED_MAX]) + (", ..." if len(lost) > NAMED_MAX else "")
        raise SolverError(
            f"{solver}: {len(lost)} of {bed.count} spheres were lost within {left.time / free_fall:.3g} "
            f"free-fall times (sphere {named}); a shorter time step helps: "
            f"--export-option {solver}.timestep_fraction=0.05"
        )
    way, bodies = position - bed.position, bed.bodies
    if bodies is not None and bed.body_index is not None:
        joined = in_one_piece(position, bed.body_index, bed.container.period)
        bodies = moved_bodies(bodies, joined, bed.body_index)
        for axis, size in enumerate(bed.container.period):
            if size is not None:  # the deck puts the spheres of a body side by side
                way[:, axis] -= size * np.rint(way[:, axis] / size)
    particles = particles_of(bed)
    if particles is not None:
        _, way = particles.means(index, way)
    moved = np.linalg.norm(way, axis=1) / mean_radius(bed)
    return Settled(
        bed=replace(bed, position=wrapped(position, bed.container), bodies=bodies),
        solver=solver,
        version=left.version or solver,
        time=left.time,
        steps=left.steps,
        free_fall_times=left.time / free_fall,
        speed=left.speed,
        still=left.still,
        interrupted=False,
        displacement_mean=float(moved.mean()),
        displacement_max=float(moved.max()),
        restart=left.restart,
    )
