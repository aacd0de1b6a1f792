"""The particles of a bed: spheres, and clumps of them; a clump counts, weighs and measures as one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed, has_clumps
from packgen.bodies import SINGLE, Template, UnbalancedError, rotations, sphere_shares

__all__ = [
    "Particles",
    "alone",
    "as_particles",
    "in_grains",
    "member_mass",
    "member_share",
    "particle_count",
    "particle_radius",
    "particles_of",
]

GRAINS = 120  # balls that a clump becomes, about, where its space is measured


def particle_count(bed: Bed) -> int:
    """Return the number of particles."""
    return len(bed.bodies) if has_clumps(bed) and bed.bodies is not None else bed.count


def particle_radius(bed: Bed) -> Float64Array:
    """Return the radius of each particle [m], of a clump that of the sphere of its volume, shape (M,)."""
    return bed.bodies.equivalent_radius if has_clumps(bed) and bed.bodies is not None else bed.radius


def alone(bed: Bed) -> BoolArray:
    """Return which spheres are particles of their own, shape (N,), bool."""
    if not has_clumps(bed) or bed.bodies is None:
        return np.ones(bed.count, bool)
    return np.asarray(bed.bodies.sphere_count[bed.body_index] == 1)


def member_share(bed: Bed) -> Float64Array:
    """Return the share of its particle's mass that each sphere stands for, shape (N,).

    Where no shares of a template's spheres have its centre of mass, those of the spheres' volumes.
    """
    share = np.ones(bed.count)
    if not has_clumps(bed) or bed.bodies is None or bed.body_index is None:
        return share
    order = np.argsort(bed.body_index, kind="stable")
    try:
        share[order] = sphere_shares(bed.bodies)
    except UnbalancedError:
        own = bed.radius**3
        share = own / np.bincount(bed.body_index, own)[bed.body_index]
    return share


def member_mass(bed: Bed) -> Float64Array:
    """Return the mass that each sphere of a bed with clumps stands for [kg], shape (N,)."""
    assert bed.bodies is not None
    return np.asarray(bed.density * member_share(bed) * bed.bodies.volume[bed.body_index])


class Particles:
    """What is known of spheres, told of the particles that they are of.

    Args:
        bed: The bed, which has clumps.

    Attributes:
        row: Row of each sphere's body, shape (N,), int64.
    """

    def __init__(self, bed: Bed) -> None:
        assert bed.body_index is not None
        self.row = bed.body_index.astype(np.int64)
        self._share = member_share(bed)

    def touched(self, sphere: Int64Array) -> Int64Array:
        """Return the rows of the bodies of some spheres, rising, each once."""
        return np.unique(self.row[sphere])

    def means(self, sphere: Int64Array, values: Float64Array) -> tuple[Int64Array, Float64Array]:
        """Return the rows of whole bodies, rising, and the means over the spheres of each.

        Args:
            sphere: All spheres of some bodies, shape (n,).
            values: A vector of each, shape (n, 3): of their places the mean is the centre of mass.

        Returns:
            Rows, shape (b,), and means by the spheres' shares of the mass, shape (b, 3).
        """
        rows, place = np.unique(self.row[sphere], return_inverse=True)
        part = self._share[sphere, None] * values
        sums = [np.bincount(place, part[:, axis], len(rows)) for axis in range(3)]
        return rows, np.stack(sums, axis=1)


def particles_of(bed: Bed) -> Particles | None:
    """Return the particles of a bed with clumps; None of one whose spheres are its particles."""
    return Particles(bed) if has_clumps(bed) else None


def as_particles(bed: Bed) -> Bed:
    """Return a bed with a sphere a particle: of each clump that of its volume, at its centre of mass.

    Volumes, masses, numbers and sizes of the particles are those of that bed; its spheres may overlap.
    """
    if not has_clumps(bed) or bed.bodies is None or bed.body_index is None:
        return bed
    bodies = bed.bodies
    first = np.unique(bed.body_index, return_index=True)[1]
    return replace(
        bed,
        position=_inside(bodies.position, bed),
        radius=bodies.size,
        set_index=bed.set_index[first],
        zone_index=bed.zone_index[first],
        batch_index=bed.batch_index[first],
        body_index=None,
        bodies=None,
    )


def in_grains(bed: Bed) -> Bed:
    """Return a bed whose spheres have the space that clumps have, each place once, to measure it.

    Each clump becomes about `GRAINS` balls on a grid over the union of its spheres, which have its volume and
    its centre: what a plane cuts off of it is right to about a hundredth, of many clumps to much less.
    """
    if not has_clumps(bed) or bed.bodies is None or bed.body_index is None:
        return bed
    bodies = bed.bodies
    first = np.unique(bed.body_index, return_index=True)[1]
    turn = rotations(bodies.orientation)
    grids = [_grid(template) for template in bodies.templates] + [np.zeros((1, 3))]
    place, row = [], []
    for number, grid in zip([*range(len(bodies.templates)), SINGLE], grids, strict=True):
        own = np.flatnonzero(bodies.template_index == number)
        turned = np.einsum("mij,kj->mki", turn[own], grid) * bodies.scale[own, None, None]
        place.append((bodies.position[own, None] + turned).reshape(-1, 3))
        row.append(np.repeat(own, len(grid)))
    position, body = np.concatenate(place), np.concatenate(row)
    count = np.bincount(body, minlength=len(bodies))
    return replace(
        bed,
        position=_inside(position, bed),
        radius=(bodies.equivalent_radius / np.cbrt(count))[body],
        set_index=bed.set_index[first[body]],
        zone_index=bed.zone_index[first[body]],
        batch_index=bed.batch_index[first[body]],
        body_index=None,
        bodies=None,
    )


def _grid(template: Template) -> Float64Array:
    """Return the points of a cubic grid in the union of a template's spheres, about their centre, (k, 3)."""
    centre, radius = template.spheres[:, :3], template.spheres[:, 3]
    low, high = (centre - radius[:, None]).min(axis=0), (centre + radius[:, None]).max(axis=0)
    pitch = float(np.cbrt(template.volume / GRAINS))
    axes = [
        np.arange(0.5 * pitch + 0.5 * ((end - start) % pitch) - pitch, end - start + pitch, pitch) + start
        for start, end in zip(low, high, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = np.zeros(len(points), bool)
    for place, size in zip(centre, radius, strict=True):
        inside |= ((points - place) ** 2).sum(axis=1) <= size * size
    kept = points[inside] if inside.any() else np.zeros((1, 3))
    return np.asarray(kept - kept.mean(axis=0))


def _inside(position: Float64Array, bed: Bed) -> Float64Array:
    """Return places inside the box, along axes along which it wraps around."""
    low, high = bed.container.bounds
    inside = np.array(position)
    for axis in np.flatnonzero(bed.container.periodic):
        inside[:, axis] = low[axis] + np.mod(position[:, axis] - low[axis], high[axis] - low[axis])
    return inside
