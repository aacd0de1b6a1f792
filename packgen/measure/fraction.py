"""How much of a volume is solid, exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import AnyBed, Bed, with_images
from packgen.measure.core import Core, find_core
from packgen.measure.particles import in_grains
from packgen.measure.volumes import container_volume_below, sphere_volume, volume_below

TOP_SHARE = 0.95

# Corner order of a hexahedron: around the bottom, then around the top.
HEXAHEDRON = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
    dtype=np.float64,
)


@dataclass(frozen=True, slots=True)
class SolidFraction:
    """Solid fractions of a bed.

    Attributes:
        top: Height of the bed's top along the direction against gravity [m]: 95 % of the solid volume belongs
            to spheres with centres at or below it, so that neither the ragged surface nor a stray sphere
            moves it. A bed that is endless, or without gravity, has none: the container's upper side.
        filled_volume: The container's volume below the top [m3].
        filled: Solid fraction of that volume, spheres that the top cuts counted by their caps.
        core: Solid fraction of the core; None where the bed has no room for one.
        core_volume: Volume of the core [m3].
        core_rule: How the core was chosen.
    """

    top: float
    filled_volume: float
    filled: float
    core: float | None
    core_volume: float | None
    core_rule: str


def solid_fraction(bed: Bed) -> SolidFraction:
    """Return the solid fractions of a bed's filled volume and of its core.

    Args:
        bed: The bed.

    Returns:
        The fractions; zero for a bed without spheres.
    """
    return solid_fraction_with(bed, core_of(bed))


def solid_fraction_with(bed: Bed, core: Core | None) -> SolidFraction:
    """Return the solid fractions of a bed's filled volume and of a core that is known already.

    Clumps count as wholes, overlaps of their spheres once; those that are cut, as `in_grains` has them.

    Args:
        bed: The bed.
        core: What `core_of` gives.

    Returns:
        The fractions; zero for a bed without spheres.
    """
    up = against_gravity(bed)
    if bed.count == 0:
        return SolidFraction(float((bed.container.bounds @ up).min()), 0.0, 0.0, None, None, "no spheres")
    bed = in_grains(bed)
    top = _top(bed, up)
    filled_volume = float(container_volume_below(bed.container, up, np.array([top]))[0])
    part = volume_below(bed.position @ up, bed.radius, top) if bed.rests else sphere_volume(bed.radius)
    solid = float(part.sum())
    return SolidFraction(
        top=top,
        filled_volume=filled_volume,
        filled=solid / filled_volume if filled_volume > 0.0 else 0.0,
        core=solid_volume(*with_images(bed), core) / core.volume if core else None,
        core_volume=core.volume if core else None,
        core_rule=core.rule if core else _no_core(bed),
    )


def _no_core(bed: Bed) -> str:
    return "the bed is too small for a core" if bed.container.cell is None else "the whole cell"


def core_of(bed: Bed) -> Core | None:
    """Return the core of a bed, as `find_core` chooses it below the bed's top; None without one."""
    if bed.count == 0:
        return None
    up = against_gravity(bed)
    return find_core(bed, up, _top(in_grains(bed), up))


def _top(bed: Bed, up: Float64Array) -> float:
    if not bed.rests:
        return float((bed.container.surface.vertices @ up).max())
    return bed_top(bed.position @ up, bed.radius)


def against_gravity(bed: AnyBed) -> Float64Array:
    """Return the unit vector that points up, from what the bed lies on, shape (3,), float64."""
    return -bed.down + 0.0  # no negative zeros


def bed_top(height: Float64Array, radius: Float64Array) -> float:
    """Return the height [m] at or below which spheres with 95 % of the solid volume have their centres.

    Args:
        height: Heights of the centres [m], shape (N,), float64, N > 0.
        radius: Sphere radii [m], shape (N,), float64.

    Returns:
        The height [m].
    """
    order = np.argsort(height, kind="stable")
    share = np.cumsum(sphere_volume(radius[order]))
    place = int(np.searchsorted(share, TOP_SHARE * share[-1]))
    return float(height[order[min(place, len(order) - 1)]])


def solid_volume(position: Float64Array, radius: Float64Array, box: Core) -> float:
    """Return the volume of the spheres' parts inside a box, exactly.

    Spheres that the box holds wholly are summed; those that its faces cut go through the library ``overlap``
    (Strobl, Formella and Poeschel, J. Comput. Phys. 311, 2016, 158), in units of the mean radius around the
    box's centre.

    Args:
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        box: The box.

    Returns:
        Volume [m3].
    """
    if len(radius) == 0:
        return 0.0
    local = (position - box.center) @ box.axes.T
    room = (box.half - np.abs(local)).min(axis=1)
    whole = room >= radius
    cut = np.flatnonzero(~whole & (room > -radius))
    total = float(sphere_volume(radius[whole]).sum())
    if len(cut):
        from overlap import Hexahedron, Sphere, overlap_volume

        unit = float(radius[cut].mean())
        body = Hexahedron(HEXAHEDRON * box.half / unit)
        centers, radii = local[cut] / unit, radius[cut] / unit
        total += unit**3 * sum(
            overlap_volume(Sphere(center, size), body) for center, size in zip(centers, radii, strict=True)
        )
    return total
