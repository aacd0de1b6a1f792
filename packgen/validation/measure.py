"""From a solver's raw numbers to what is judged: the same for every solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check import wall_clearance
from packgen.errors import SolverError
from packgen.measure import hertz as law
from packgen.measure.forces import predicted_forces
from packgen.measure.particles import particle_count, particles_of
from packgen.validation.contacts import Contacts, pair_error
from packgen.validation.elastic import elastic_sinking, up_direction
from packgen.validation.results import GravityRun, Limits, StepZero
from packgen.validation.still import free_fall_time

POSITION_ERROR_MAX = 1.0e-9  # radii; the digits of the dumps


def check_loaded(bed: Bed, position: Float64Array, radius: Float64Array) -> None:
    """Make sure that the solver holds the spheres of the bed, (N, 3) and (N,) in the order of their ids.

    Raises:
        SolverError: It does not.
    """
    if len(position) != bed.count:
        raise SolverError(f"loaded {len(position)} spheres, expected {bed.count}")
    apart = position - bed.position
    length = bed.container.bounds[1] - bed.container.bounds[0]
    wraps = np.array(bed.container.periodic)
    apart[:, wraps] -= length[wraps] * np.round(apart[:, wraps] / length[wraps])
    error = np.maximum(np.abs(apart).max(axis=1), np.abs(radius - bed.radius)) / bed.radius
    # The dumps have 15 digits, which far from the origin are more than a billionth of a radius.
    allowed = POSITION_ERROR_MAX + 1e-14 * np.abs(bed.position).max(axis=1) / bed.radius
    worst = int((error - allowed).argmax())
    if not error[worst] <= allowed[worst]:
        raise SolverError(
            f"sphere {worst} is off by {error[worst]:.3g} of its radius in the solver: the deck"
            " is not the bed's"
        )


def step_zero(bed: Bed, pairs: Contacts, walls: Contacts, wall_error: float) -> StepZero:
    """Return the verdict's numbers on the forces at step 0.

    Args:
        bed: The bed.
        pairs: Contacts between spheres.
        walls: Contacts with walls.
        wall_error: How far the forces of the walls are off Hertz' law, as the solver's walls have it.
    """
    weight = law.mean_weight(bed)
    assert pairs.second is not None
    smaller = np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
    worst_pair, worst_wall = _worst(pairs.force), _worst(walls.force)
    prediction = predicted_forces(bed)
    beyond = outside(bed, bed.position, np.arange(bed.count))
    return StepZero(
        pair_count=len(pairs.force),
        wall_count=len(walls.force),
        pair_overlap_max=float((pairs.overlap / smaller).max(initial=0.0)),
        wall_overlap_max=float((walls.overlap / bed.radius[walls.first]).max(initial=0.0)),
        pair_force_max=float(pairs.force.max(initial=0.0)) / weight,
        wall_force_max=float(walls.force.max(initial=0.0)) / weight,
        worst_pair=None
        if worst_pair is None
        else (int(pairs.first[worst_pair]), int(pairs.second[worst_pair])),
        worst_wall_sphere=None if worst_wall is None else int(walls.first[worst_wall]),
        law_error=float(np.maximum(pair_error(bed, pairs), wall_error)),  # passes nan on
        predicted_force_max=prediction.force_max,
        outside_count=len(beyond),
        worst_outside=int(beyond[0]) if len(beyond) else None,
    )


@dataclass(frozen=True, eq=False, slots=True)
class Trajectory:
    """The raw outcome of a gravity run.

    Attributes:
        timestep: Time step [s].
        steps: Steps that were run.
        steps_wanted: Steps that were asked for.
        index: Spheres that are left, as indices in the bed, ascending, shape (M,).
        position: Where they are, not wrapped around [m], shape (M, 3).
        energy: Samples of the kinetic energy [J], rotation included, shape (K,).
        still: Whether the run ended since nothing moved any more.
    """

    timestep: float
    steps: int
    steps_wanted: int
    index: Int64Array
    position: Float64Array
    energy: Float64Array
    still: bool = False


def gravity_run(bed: Bed, start: Float64Array, run: Trajectory) -> GravityRun:
    """Return the verdict's numbers on a gravity run that began at positions ``start`` [m], shape (N, 3)."""
    radius = law.mean_radius(bed)
    unit = law.mean_weight(bed) * particle_count(bed) * radius
    gone = np.setdiff1d(np.arange(bed.count), run.index)
    escaped = outside(bed, run.position, run.index)
    lost = np.union1d(gone, escaped)
    bodies = particles_of(bed)
    if bodies is not None:
        # A body is lost as a whole, and told by its row.
        lost = bodies.touched(lost)
        kept = ~np.isin(bodies.row[run.index], lost)
    else:
        kept = ~np.isin(run.index, lost)
    index, position = run.index[kept], run.position[kept]
    way = position - start[index]
    before, after = _heights(bed, start[index], index), _heights(bed, position, index)
    elastic = elastic_sinking(bed, position, index) - elastic_sinking(bed, start[index], index)
    left = way + elastic[:, None] * up_direction(bed)
    mass = law.sphere_mass(bed)[index]
    number = index
    if bodies is not None:
        number, way = bodies.means(index, way)
        _, left = bodies.means(index, left)
    moved, rest = np.linalg.norm(way, axis=1), np.linalg.norm(left, axis=1)
    worst = int(moved.argmax()) if len(moved) else 0
    return GravityRun(
        timestep=run.timestep,
        timestep_rayleigh=run.timestep / law.rayleigh_time(bed),
        steps=run.steps,
        steps_wanted=run.steps_wanted,
        free_fall_times=run.steps * run.timestep / free_fall_time(bed),
        lost=tuple(int(each) for each in lost),
        energy_peak=float(run.energy.max()) / unit,
        energy_end=float(run.energy[-1]) / unit,
        displacement_mean=float(moved.mean()) / radius if len(moved) else float("nan"),
        displacement_max=float(moved[worst]) / radius if len(moved) else float("nan"),
        worst_displaced=int(number[worst]) if len(moved) else -1,
        displacement_rest_mean=float(rest.mean()) / radius if len(rest) else float("nan"),
        sinking=(before[0] - after[0]) / before[0],
        sinking_elastic=float(np.average(elastic, weights=mass)) / before[0] if len(mass) else float("nan"),
        height_change=(after[1] - before[1]) / before[1],
        still=run.still,
    )


def steps_wanted(bed: Bed, limits: Limits, timestep: float, *, least: int = 1) -> tuple[int, int]:
    """Return how many steps the limits ask for, and how many of them the work budget allows.

    Args:
        bed: The bed.
        limits: What is asked for.
        timestep: Time step [s].
        least: Spheres that a smaller bed counts for: a step has costs beside those of its spheres.
    """
    wanted = max(1, int(np.ceil(limits.free_fall_times * free_fall_time(bed) / timestep)))
    return wanted, min(wanted, int(limits.work_budget / max(bed.count, least)))


def _heights(bed: Bed, position: Float64Array, index: Int64Array) -> tuple[float, float]:
    """Return the heights of the centre of mass and of the bed, above the lowest point at the start."""
    if len(index) == 0:
        return float("nan"), float("nan")
    up = up_direction(bed)
    floor = float((bed.position @ up - bed.radius).min())
    height = position @ up - floor
    mass = law.sphere_mass(bed)[index]
    return float(np.average(height, weights=mass)), float((height + bed.radius[index]).max())


def outside(bed: Bed, position: Float64Array, index: Int64Array) -> Int64Array:
    """Return which of some spheres have their centre outside the container, farthest first."""
    if all(bed.container.periodic) or len(index) == 0:
        return np.zeros(0, dtype=np.int64)
    radius = bed.radius[index]
    finite = np.isfinite(position).all(axis=1)
    clearance = np.full(len(index), -np.inf)
    clearance[finite] = wall_clearance(bed.container, position[finite], radius[finite])
    order = np.argsort(clearance, kind="stable")
    return index[order[clearance[order] < 0]]


def _worst(force: Float64Array) -> int | None:
    return int(force.argmax()) if len(force) and not force.max() <= 0 else None  # nan is the worst
