"""From a solver's raw numbers to what is judged: the same for every solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check import wall_clearance
from packgen.errors import SolverError
from packgen.validation import law
from packgen.validation.prediction import predicted_forces, primitive_wall_forces
from packgen.validation.results import GravityRun, Limits, StepZero

FORCE_FLOOR = 1.0e-3  # mean sphere weights: smaller forces are compared with the law absolutely
POSITION_ERROR_MAX = 1.0e-9  # radii; the digits of the dumps


@dataclass(frozen=True, eq=False, slots=True)
class Contacts:
    """Contacts that a solver found.

    Attributes:
        first: Index of the sphere, shape (C,), int64.
        second: Index of the other sphere, shape (C,), int64; None: contacts with walls.
        force: Size of the force [N], shape (C,), float64.
        overlap: Overlap [m], shape (C,), float64.
    """

    first: Int64Array
    second: Int64Array | None
    force: Float64Array
    overlap: Float64Array


def check_loaded(bed: Bed, solver: str, position: Float64Array, radius: Float64Array) -> None:
    """Make sure that the solver holds the spheres of the bed, (N, 3) and (N,) in the order of their ids.

    Raises:
        SolverError: It does not.
    """
    if len(position) != bed.count:
        raise SolverError(f"{solver}: loaded {len(position)} spheres, expected {bed.count}")
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
            f"{solver}: sphere {worst} is off by {error[worst]:.3g} of its radius in the solver: the deck"
            " is not the bed's"
        )


def step_zero(bed: Bed, pairs: Contacts, walls: Contacts | None, wall_force: Float64Array) -> StepZero:
    """Return the verdict's numbers on the forces at step 0.

    Args:
        bed: The bed.
        pairs: Contacts between spheres.
        walls: Contacts with walls; None where the solver does not list them.
        wall_force: What the walls do to each sphere [N], shape (N, 3): used where ``walls`` is None.
    """
    weight = law.mean_weight(bed)
    types = bed.type_index
    assert pairs.second is not None
    radii = bed.radius[pairs.first], bed.radius[pairs.second]
    moduli = law.modulus_table(bed)[types[pairs.first], types[pairs.second]]
    expected = law.hertz_force(moduli, law.effective_radius(*radii), pairs.overlap)
    error = _law_error(pairs.force, expected, weight)
    if walls is None:
        walls, wall_error = _primitive_contacts(bed, wall_force, weight)
    else:
        moduli = law.wall_modulus(bed, types)[walls.first]
        expected = law.hertz_force(moduli, bed.radius[walls.first], walls.overlap)
        wall_error = _law_error(walls.force, expected, weight)
    worst_pair, worst_wall = _worst(pairs.force), _worst(walls.force)
    prediction = predicted_forces(bed)
    outside = _outside(bed, bed.position, np.arange(bed.count))
    return StepZero(
        pair_count=len(pairs.force),
        wall_count=len(walls.force),
        pair_overlap_max=float((pairs.overlap / np.minimum(*radii)).max(initial=0.0)),
        wall_overlap_max=float((walls.overlap / bed.radius[walls.first]).max(initial=0.0)),
        pair_force_max=float(pairs.force.max(initial=0.0)) / weight,
        wall_force_max=float(walls.force.max(initial=0.0)) / weight,
        worst_pair=None
        if worst_pair is None
        else (int(pairs.first[worst_pair]), int(pairs.second[worst_pair])),
        worst_wall_sphere=None if worst_wall is None else int(walls.first[worst_wall]),
        law_error=float(np.maximum(error, wall_error)),  # passes nan on
        predicted_force_max=prediction.force_max,
        outside_count=len(outside),
        worst_outside=int(outside[0]) if len(outside) else None,
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
    """

    timestep: float
    steps: int
    steps_wanted: int
    index: Int64Array
    position: Float64Array
    energy: Float64Array


def gravity_run(bed: Bed, start: Float64Array, run: Trajectory) -> GravityRun:
    """Return the verdict's numbers on a gravity run that began at positions ``start`` [m], shape (N, 3)."""
    strength, radius = law.gravity_strength(bed), float(bed.radius.mean())
    unit = law.mean_weight(bed) * bed.count * radius
    gone = np.setdiff1d(np.arange(bed.count), run.index)
    escaped = _outside(bed, run.position, run.index)
    lost = np.union1d(gone, escaped)
    kept = ~np.isin(run.index, lost)
    index, position = run.index[kept], run.position[kept]
    moved = np.linalg.norm(position - start[index], axis=1)
    before, after = _heights(bed, start[index], index), _heights(bed, position, index)
    worst = int(moved.argmax()) if len(moved) else 0
    return GravityRun(
        timestep=run.timestep,
        timestep_rayleigh=run.timestep / law.rayleigh_time(bed),
        steps=run.steps,
        steps_wanted=run.steps_wanted,
        free_fall_times=run.steps * run.timestep / np.sqrt(2 * radius / strength),
        lost=tuple(int(each) for each in lost),
        energy_peak=float(run.energy.max()) / unit,
        energy_end=float(run.energy[-1]) / unit,
        displacement_mean=float(moved.mean()) / radius if len(moved) else float("nan"),
        displacement_max=float(moved[worst]) / radius if len(moved) else float("nan"),
        worst_displaced=int(index[worst]) if len(moved) else -1,
        sinking=(before[0] - after[0]) / before[0],
        height_change=(after[1] - before[1]) / before[1],
    )


def steps_wanted(bed: Bed, limits: Limits, timestep: float) -> tuple[int, int]:
    """Return how many steps the limits ask for, and how many of them the work budget allows."""
    free_fall = np.sqrt(2 * float(bed.radius.mean()) / law.gravity_strength(bed))
    wanted = max(1, int(np.ceil(limits.free_fall_times * free_fall / timestep)))
    return wanted, min(wanted, max(1, int(limits.work_budget / bed.count)))


def _heights(bed: Bed, position: Float64Array, index: Int64Array) -> tuple[float, float]:
    """Return the heights of the centre of mass and of the bed, above the lowest point at the start."""
    if len(index) == 0:
        return float("nan"), float("nan")
    strength = float(np.linalg.norm(bed.gravity))
    up = -bed.gravity / strength if strength > 0 else np.array([0.0, 0.0, 1.0])
    floor = float((bed.position @ up - bed.radius).min())
    height = position @ up - floor
    mass = law.sphere_mass(bed)[index]
    return float(np.average(height, weights=mass)), float((height + bed.radius[index]).max())


def _outside(bed: Bed, position: Float64Array, index: Int64Array) -> Int64Array:
    """Return which of some spheres have their centre outside the container, farthest first."""
    if all(bed.container.periodic) or len(index) == 0:
        return np.zeros(0, dtype=np.int64)
    radius = bed.radius[index]
    finite = np.isfinite(position).all(axis=1)
    clearance = np.full(len(index), -np.inf)
    clearance[finite] = wall_clearance(bed.container, position[finite], radius[finite])
    order = np.argsort(clearance, kind="stable")
    return index[order[clearance[order] < 0]]


def _primitive_contacts(bed: Bed, wall_force: Float64Array, weight: float) -> tuple[Contacts, float]:
    """Return contacts with primitive walls, told from the force that they leave on each sphere."""
    both = primitive_wall_forces(bed, wall_force)
    if both is None:
        raise SolverError(
            "the deck has no mesh walls, and the container is none that has primitive walls: their forces"
            " cannot be checked"
        )
    found, expected = both
    error = _law_error(found, expected, weight)
    # What is left of a sphere's forces after rounding is no contact.
    sphere, column = np.nonzero(np.abs(found) > 1e-9 * weight)
    force = np.abs(found[sphere, column])
    overlap = law.hertz_overlap(law.wall_modulus(bed, bed.type_index)[sphere], bed.radius[sphere], force)
    return Contacts(sphere.astype(np.int64), None, force, overlap), error


def _law_error(found: Float64Array, expected: Float64Array, weight: float) -> float:
    scale = np.maximum(np.abs(expected), FORCE_FLOOR * weight)
    return float((np.abs(found - expected) / scale).max(initial=0.0))


def _worst(force: Float64Array) -> int | None:
    return int(force.argmax()) if len(force) and not force.max() <= 0 else None  # nan is the worst
