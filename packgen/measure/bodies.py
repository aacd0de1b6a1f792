"""What the clumps of a bed are like: how many of which shape, how heavy, and how they lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed, has_clumps
from packgen.bodies import Template, rotations
from packgen.check import near_pairs, wall_clearance
from packgen.measure.contacts import GAP_EDGES, GAPS, HELD_MIN, Contacts, Gaps

UNLIKE = 1.0e-3  # share by which moments of inertia differ that tell an axis


@dataclass(frozen=True, slots=True)
class ClumpShape:
    """The clumps of one template.

    Attributes:
        name: Name of the template.
        count: Number of clumps.
        spheres: Spheres of each.
        radius_mean: Mean radius of the spheres of their volumes [m].
        mass: Mass of all [kg]; None where the density is not known.
        inertia: Mean principal moments of inertia [kg m2], rising; None likewise.
        axis: Which axis tells how a clump lies: ``longest``, that of the least moment of inertia, or
            ``shortest``, that of the greatest, whichever is the one unlike the other two; None of a shape
            whose moments are all alike.
        order: How much those axes lie alike: the largest eigenvalue of the mean of (3 n n - 1) / 2 over the
            axes n, 1 of parallel ones, of M random ones about 1 / sqrt(M); None without an axis.
        director: The direction that they have, the eigenvector, shape (3,); None without an axis.
        angle_to_gravity: Mean angle between axis and gravity [degrees], 57.3 of random ones; None without an
            axis, and without gravity.
    """

    name: str
    count: int
    spheres: int
    radius_mean: float
    mass: float | None
    inertia: tuple[float, float, float] | None
    axis: str | None
    order: float | None
    director: tuple[float, float, float] | None
    angle_to_gravity: float | None

    def lie(self) -> str:
        """Return how they lie, as text."""
        if self.order is None:
            return "no axis"
        angle = "" if self.angle_to_gravity is None else f", {self.angle_to_gravity:.1f} degrees to gravity"
        return f"{self.axis} axis: order {self.order:.3f}{angle}{' (random: 57.3)' if angle else ''}"


@dataclass(frozen=True, slots=True)
class BodyMeasures:
    """The particles of a bed with clumps.

    Attributes:
        body_count: Number of particles, single spheres among them.
        clump_count: Number of clumps.
        single_count: Number of single spheres.
        shapes: The clumps of each template that some clump has.
    """

    body_count: int
    clump_count: int
    single_count: int
    shapes: tuple[ClumpShape, ...]

    def line(self) -> str:
        """Return how many there are, as text."""
        singles = f", {self.single_count:,} single spheres" if self.single_count else ""
        return f"{self.clump_count:,} clumps{singles}"


def body_measures(bed: Bed) -> BodyMeasures | None:
    """Return what the clumps of a bed are like; None of a bed without clumps."""
    if not has_clumps(bed) or bed.bodies is None or bed.body_index is None:
        return None
    bodies = bed.bodies
    density = bed.density[np.unique(bed.body_index, return_index=True)[1]]
    several = bodies.sphere_count > 1
    shapes = [
        _shape(bed, template, np.flatnonzero(bodies.template_index == number), density)
        for number, template in enumerate(bodies.templates)
        if template.count > 1 and (bodies.template_index == number).any()
    ]
    clumps = int(np.count_nonzero(several))
    return BodyMeasures(len(bodies), clumps, len(bodies) - clumps, tuple(shapes))


def _shape(bed: Bed, template: Template, own: Int64Array, density: Float64Array) -> ClumpShape:
    assert bed.bodies is not None
    bodies, mass = bed.bodies[own], density[own] * bed.bodies.volume[own]
    moments, axes = template.properties.principal()
    kind, place = _telling(moments)
    known = bool(np.isfinite(mass).all())
    heavy = np.asarray(np.mean(density[own] * bodies.scale**5) * moments)
    order = director = angle = None
    if place is not None:
        direction = rotations(bodies.orientation) @ axes[:, place]
        values, vectors = np.linalg.eigh(1.5 * direction.T @ direction / len(own) - 0.5 * np.eye(3))
        order, director = float(values[-1]), _tuple(vectors[:, -1] * np.sign(vectors[_largest(vectors), -1]))
        if bed.gravity.any():
            along = np.abs(direction @ bed.down)
            angle = float(np.degrees(np.arccos(np.minimum(along, 1.0))).mean())
    return ClumpShape(
        name=template.name,
        count=len(own),
        spheres=template.count,
        radius_mean=float(bodies.equivalent_radius.mean()),
        mass=float(mass.sum()) if known else None,
        inertia=_tuple(heavy) if known else None,
        axis=kind,
        order=order,
        director=director,
        angle_to_gravity=angle,
    )


def _largest(vectors: Float64Array) -> int:
    return int(np.abs(vectors[:, -1]).argmax())


def _tuple(values: Float64Array) -> tuple[float, float, float]:
    a, b, c = (float(each) for each in values)
    return a, b, c


def _telling(moments: Float64Array) -> tuple[str | None, int | None]:
    """Return which axis is unlike the other two, by the moments about all, rising, shape (3,)."""
    low, middle, high = moments.tolist()
    if high - low <= UNLIKE * high:
        return None, None
    return ("longest", 0) if middle - low >= high - middle else ("shortest", 2)


def body_contacts(
    bed: Bed, clearance: Float64Array | None = None, gaps: Sequence[float] = GAPS
) -> tuple[tuple[Contacts, ...], Gaps]:
    """Return the contacts a body, one for each pair of bodies, and the gaps of all near pairs of them.

    The gap of two bodies is the least one of their spheres, as a fraction of the smaller radius of these two.

    Args:
        bed: The bed, which has clumps.
        clearance: Distance of each sphere's centre from the nearest wall [m], exact as far as a contact,
            where it is known; shape (N,).
        gaps: Largest gaps that count as contacts, none below 0.
    """
    assert bed.bodies is not None
    assert bed.body_index is not None
    count, row = len(bed.bodies), bed.body_index.astype(np.int64)
    widest = max(*gaps, GAP_EDGES[-1])
    if clearance is None:
        clearance = wall_clearance(bed.container, bed.position, bed.radius * (1.0 + widest))
    keys, shares = [np.zeros(0, np.int64)], [np.zeros(0)]
    for pairs in near_pairs(
        bed.position, bed.radius, gap_fraction=widest, period=bed.container.period,
        body_index=bed.body_index,
    ):  # fmt: skip
        one, other = row[pairs.first], row[pairs.second]
        keys.append(np.minimum(one, other) * count + np.maximum(one, other))
        shares.append(pairs.gap / np.minimum(bed.radius[pairs.first], bed.radius[pairs.second]))
    key, place = np.unique(np.concatenate(keys), return_inverse=True)
    share = np.full(len(key), np.inf)
    np.minimum.at(share, place, np.concatenate(shares))
    to_wall = np.full(count, np.inf)
    np.minimum.at(to_wall, row, clearance / bed.radius - 1.0)
    found = []
    for gap in gaps:
        ends = np.concatenate([key[share <= gap] // count, key[share <= gap] % count])
        number, at_wall = np.bincount(ends, minlength=count), to_wall <= gap
        found.append(
            Contacts(
                gap=gap,
                mean=float(number.mean()),
                wall_mean=float(at_wall.mean()),
                none=float(((number == 0) & ~at_wall).mean()),
                rattlers=float((number + at_wall < HELD_MIN).mean()),
                spread=tuple(np.bincount(number).tolist()),
            )
        )
    counted = np.bincount(np.searchsorted(GAP_EDGES, share), minlength=len(GAP_EDGES) + 1)[: len(GAP_EDGES)]
    return tuple(found), Gaps(GAP_EDGES, tuple(counted.tolist()))
