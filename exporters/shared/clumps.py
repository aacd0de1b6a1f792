"""Rigid clumps as the decks of all solvers have them: which spheres are whose, and what a body weighs.

A solver that sums its spheres counts overlaps several times. So each sphere has a density that makes it stand
for its share of its body's mass: the shares add up to the body's true mass, and their centre is the body's.
Gravity on the spheres is then that on the body, and does not turn it. The inertia is given to the solver.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import SINGLE, AnyBed, Bed, Bodies, UnbalancedError, has_clumps, sphere_shares
from packgen.errors import ExportError

__all__ = ["WAYS", "Clumps", "body_density", "clumps_of", "refuse_clumps", "template_label"]

WAYS = "liggghts, lammps, yade, vtk, csv and chrono do"
"""What messages say of the formats that have clumps."""


@dataclass(frozen=True, eq=False, slots=True)
class Clumps:
    """The clumps of a bed; bodies of one sphere are none.

    Attributes:
        molecule: Row of each sphere's body plus one, 0 of spheres of their own, shape (N,), int64.
        density: Density of each sphere that makes it its share of the body's mass [kg/m3], shape (N,).
        row: Rows of the clumps in ``bed.bodies``, rising, shape (K,), int64.
        mass: Mass of each clump [kg], shape (K,).
        inertia: Inertia of each about its centre of mass, in the axes of the box [kg m2], shape (K, 3, 3).
        position: Centre of mass of each, inside a box that wraps around [m], shape (K, 3).
        member: Centre of each sphere beside its body's, not wrapped around [m], shape (N, 3).
        reach: Largest distance of a sphere's centre from that of its body [m].
    """

    molecule: Int64Array
    density: Float64Array
    row: Int64Array
    mass: Float64Array
    inertia: Float64Array
    position: Float64Array
    member: Float64Array
    reach: float

    @property
    def count(self) -> int:
        """Number of clumps."""
        return len(self.row)

    @property
    def has_singles(self) -> bool:
        """Whether there are spheres of their own beside them."""
        return bool((self.molecule == 0).any())


def clumps_of(bed: AnyBed, solver: str) -> Clumps | None:
    """Return the clumps of a bed; None of one without.

    Args:
        bed: The bed.
        solver: What messages call the format.

    Raises:
        ExportError: No masses of a template's spheres have the body's centre of mass.
    """
    if not (isinstance(bed, Bed) and has_clumps(bed)):
        return None
    assert bed.bodies is not None
    assert bed.body_index is not None
    bodies = bed.bodies
    try:
        share = sphere_shares(bodies)
    except UnbalancedError as error:
        raise ExportError(f"{solver}: {error}") from error
    # Spheres in the order of their bodies, and of the template.
    order = np.argsort(bed.body_index, kind="stable")
    body = bed.body_index[order].astype(np.int64)
    density = np.empty(bed.count)
    density[order] = bed.density[order] * share * bodies.volume[body] / _volume(bed.radius[order])
    several = bodies.sphere_count > 1
    row = np.flatnonzero(several)
    dense = body_density(bed)[row]
    place = _wrapped(bodies.position, bed)
    member = _beside(bed.position, place[bed.body_index], bed)
    away = np.linalg.norm(member - place[bed.body_index], axis=1)
    chosen = _part(bodies, several)
    return Clumps(
        molecule=np.where(several[bed.body_index], bed.body_index.astype(np.int64) + 1, 0),
        density=density,
        row=row,
        mass=dense * chosen.volume,
        inertia=dense[:, None, None] * chosen.inertia,
        position=place[row],
        member=member,
        reach=float(away.max()),
    )


def body_density(bed: Bed) -> Float64Array:
    """Return the density of each body of a bed [kg/m3], shape (M,)."""
    assert bed.bodies is not None
    assert bed.body_index is not None
    order = np.argsort(bed.body_index, kind="stable")
    return np.asarray(bed.density[order[np.searchsorted(bed.body_index[order], np.arange(len(bed.bodies)))]])


def template_label(bodies: Bodies, number: int) -> str:
    """Return what files call a template: its name, and its number where two have the same."""
    name = re.sub(r"[^A-Za-z0-9_.+-]", "_", bodies.templates[number].name) or "clump"
    alike = sum(each.name == bodies.templates[number].name for each in bodies.templates)
    return name if alike == 1 else f"{name}_{number}"


def refuse_clumps(bed: AnyBed, solver: str) -> None:
    """Refuse a bed of clumps for a format that has single spheres only.

    Raises:
        ExportError: The bed has clumps.
    """
    if isinstance(bed, Bed) and has_clumps(bed):
        raise ExportError(f"{solver}: the bed has clumps, which {solver} does not write; {WAYS}")


def _part(bodies: Bodies, chosen: BoolArray) -> Bodies:
    part = bodies[chosen]
    assert not (part.template_index == SINGLE).any()
    return part


def _volume(radius: Float64Array) -> Float64Array:
    return np.asarray(4.0 / 3.0 * np.pi * radius**3)


def _wrapped(position: Float64Array, bed: Bed) -> Float64Array:
    """Return places inside a box that wraps around."""
    low, high = bed.container.bounds
    wrapped = position.copy()
    for axis in np.flatnonzero(bed.container.periodic):
        size = high[axis] - low[axis]
        along = low[axis] + np.mod(position[:, axis] - low[axis], size)
        wrapped[:, axis] = np.where(along >= high[axis], low[axis], along)
    return wrapped


def _beside(position: Float64Array, near: Float64Array, bed: Bed) -> Float64Array:
    """Return the images of places (N, 3) that are nearest to others, where the box wraps around."""
    size = np.where(bed.container.periodic, bed.container.bounds[1] - bed.container.bounds[0], np.inf)
    shift = np.where(np.isfinite(size), size, 0.0) * np.round((position - near) / size)
    return np.asarray(position - shift)
