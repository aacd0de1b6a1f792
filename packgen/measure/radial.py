"""Porosity over the distance from the wall of a round container, and what is published of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.geometry import Container
from packgen.measure.core import MARGINS
from packgen.measure.cylinders import volume_in_cylinder_between
from packgen.measure.fraction import against_gravity, bed_top
from packgen.measure.particles import in_grains, particle_radius
from packgen.measure.roundness import RoundPart, round_part
from packgen.measure.volumes import mean_diameter

FINE_STEP, COARSE_STEP = 0.1, 0.5  # mean diameters: thickness of the shells near the wall, and beyond
FINE_REACH = 5.0  # mean diameters: a wall's order reaches no further
HEIGHT_MIN = 2.0  # mean diameters: a shallower part is not measured


@dataclass(frozen=True, slots=True)
class RadialProfile:
    """Porosity of the cylindrical shells of a round container.

    Attributes:
        radius: Radius of the container [m]; of a mesh, that of the circle of equal area.
        diameter: Mean diameter of the spheres by volume [m], the unit of ``wall_distance``.
        low: Height along the direction against gravity from which the bed was measured [m].
        high: Height up to which it was measured [m].
        wall_distance: Bounds of the shells as distances from the wall, in mean diameters, rising, one more
            than shells.
        porosity: Porosity of each shell, spheres cut exactly by its bounds.
        bulk: Mean porosity of the shells more than `FINE_REACH` diameters from the wall, that of the whole
            part where there are none.
        mueller: `mueller_porosity` averaged over each shell; empty where it does not hold.
        de_klerk: `de_klerk_porosity` averaged over each shell, its bulk porosity being this bed's.
    """

    radius: float
    diameter: float
    low: float
    high: float
    wall_distance: tuple[float, ...]
    porosity: tuple[float, ...]
    bulk: float
    mueller: tuple[float, ...]
    de_klerk: tuple[float, ...]


def radial_profile(bed: Bed) -> RadialProfile | None:
    """Return the porosity of a bed over the distance from the wall, where its container is round.

    The part measured is the longest upright cylinder of the walls, away from the container's floor and the
    bed's top by two mean diameters; in shallow beds by one, then half a diameter.

    Args:
        bed: The bed.

    Returns:
        The profile; None where the container is not round, or the bed too shallow.
    """
    if bed.count == 0:
        return None
    up = against_gravity(bed)
    part = round_part(bed.container, up)
    if part is None:
        return None
    diameter = mean_diameter(particle_radius(bed))
    bed = in_grains(bed)
    shells = shells_of(bed.container, part, diameter, bed_top(bed.position @ part.axis, bed.radius))
    if shells is None:
        return None
    return shells.profile(shells.solid(bed.position, bed.radius))


@dataclass(frozen=True, eq=False, slots=True)
class Shells:
    """The shells of a round part of a container.

    Attributes:
        part: The part.
        diameter: Mean diameter of the spheres by volume [m].
        bounds: Heights between which a bed is measured [m].
        distance: Bounds of the shells from the wall, in mean diameters, rising.
    """

    part: RoundPart
    diameter: float
    bounds: tuple[float, float]
    distance: Float64Array

    @property
    def radius(self) -> Float64Array:
        """Radii of the cylinders between the shells [m]."""
        return np.maximum(self.part.radius - self.distance * self.diameter, 0.0)

    def solid(self, position: Float64Array, radius: Float64Array) -> Float64Array:
        """Return the volume [m3] of spheres within each cylinder; that of more spheres adds to it."""
        part = self.part
        return solid_in_cylinders(position, radius, part.center, part.axis, self.radius, self.bounds)

    def profile(self, solid: Float64Array) -> RadialProfile:
        """Return the profile of a bed that has so much solid volume [m3] within each cylinder."""
        distance, bounds, part = self.distance, self.bounds, self.part
        end = part.radius / self.diameter
        room = np.pi * self.radius**2 * (bounds[1] - bounds[0])
        porosity = 1.0 - np.diff(solid) / np.diff(room)
        deep = int(np.searchsorted(distance, FINE_REACH)) if end > FINE_REACH + COARSE_STEP else 0
        bulk = float(1.0 - solid[deep] / room[deep])
        mueller = _averaged(lambda x: mueller_porosity(x, 2.0 * end), distance) if 2.0 * end >= 2.61 else ()
        return RadialProfile(
            radius=part.radius,
            diameter=self.diameter,
            low=bounds[0],
            high=bounds[1],
            wall_distance=tuple(distance.tolist()),
            porosity=tuple(porosity.tolist()),
            bulk=bulk,
            mueller=mueller,
            de_klerk=_averaged(lambda x: de_klerk_porosity(x, bulk), distance),
        )


def shells_of(container: Container, part: RoundPart, diameter: float, top: float) -> Shells | None:
    """Return the shells in which a bed is measured; None where it is too shallow.

    Args:
        container: The vessel.
        part: Its round part.
        diameter: Mean diameter of the spheres by volume [m].
        top: Height of the bed's top [m].
    """
    bounds = _measured_heights(container, part, diameter, top)
    if bounds is None:
        return None
    end = part.radius / diameter
    fine = np.arange(0.0, min(FINE_REACH, end) + 0.5 * FINE_STEP, FINE_STEP)
    fine = fine[fine < end - 0.5 * FINE_STEP]
    coarse = np.arange(fine[-1] + COARSE_STEP, end - 0.5 * COARSE_STEP, COARSE_STEP)
    return Shells(part, diameter, bounds, np.concatenate([fine, coarse, [end]]))


def _measured_heights(
    container: Container, part: RoundPart, diameter: float, top: float
) -> tuple[float, float] | None:
    """Heights [m] between which a round part of the walls holds an undisturbed bed."""
    floor = float((container.surface.vertices @ part.axis).min())
    for margin in MARGINS:
        low = max(part.low, floor + margin * diameter)
        high = min(part.high, top - margin * diameter)
        if high - low >= HEIGHT_MIN * diameter:
            return low, high
    return None


def solid_in_cylinders(
    position: Float64Array,
    radius: Float64Array,
    center: Float64Array,
    axis: Float64Array,
    cylinder: Float64Array,
    bounds: tuple[float, float],
) -> Float64Array:
    """Return the solid volume inside some coaxial cylinders between two planes across their axis.

    Args:
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        center: A point of the axis [m], shape (3,), float64.
        axis: Unit vector along the axis, shape (3,), float64.
        cylinder: Radii of the cylinders [m], shape (C,), float64.
        bounds: Heights ``axis @ x`` of the planes [m].

    Returns:
        Solid volumes [m3], shape (C,), float64; see `volume_in_cylinder_between` for their error.
    """
    relative = position - center
    across = np.linalg.norm(relative - (relative @ axis)[:, None] * axis, axis=1)
    height, size = position @ axis, radius
    near = (height + size > bounds[0]) & (height - size < bounds[1])
    order = np.flatnonzero(near)[np.argsort(across[near])]
    across, height, size = across[order], height[order], size[order]
    endless = np.full(len(order), 2.0 * (across.max(initial=0.0) + size.max(initial=0.0)))
    whole = volume_in_cylinder_between(across, height, size, endless, bounds)
    below = np.concatenate([[0.0], np.cumsum(whole)])
    reach = float(size.max(initial=0.0))
    solid = np.empty(len(cylinder))
    for place, each in enumerate(cylinder):
        # Only spheres near a cylinder are cut by it; those nearer to the axis count as a whole.
        first, last = np.searchsorted(across, [each - reach, each + reach])
        near_it = slice(first, last)
        cut = volume_in_cylinder_between(
            across[near_it], height[near_it], size[near_it], np.full(last - first, each), bounds
        )
        solid[place] = below[first] + cut.sum()
    return solid


def mueller_porosity(wall_distance: Float64Array, diameter_ratio: float) -> Float64Array:
    """Return the porosity of randomly packed equal spheres in a cylinder by Mueller's correlation.

    G. E. Mueller, Powder Technology 72 (1992) 269: ``e = eb + (1 - eb) J0(a x) exp(-b x)`` with
    ``eb = 0.379 + 0.078 / (D/d - 1.80)``, ``b = 0.304 - 0.724 d/D`` and ``a = 8.243 - 12.98 / (D/d + 3.156)``
    up to D/d = 13.0, ``a = 7.383 - 2.932 / (D/d - 9.864)`` above.

    Args:
        wall_distance: Distances x from the wall, in sphere diameters, any shape, float64.
        diameter_ratio: Diameter of the container over that of the spheres, D/d, at least 2.61.

    Returns:
        Porosities, shape of ``wall_distance``, float64.
    """
    from scipy.special import j0

    bulk = 0.379 + 0.078 / (diameter_ratio - 1.80)
    damping = 0.304 - 0.724 / diameter_ratio
    if diameter_ratio <= 13.0:
        wave = 8.243 - 12.98 / (diameter_ratio + 3.156)
    else:
        wave = 7.383 - 2.932 / (diameter_ratio - 9.864)
    porosity: Float64Array = bulk + (1.0 - bulk) * j0(wave * wall_distance) * np.exp(-damping * wall_distance)
    return porosity


def de_klerk_porosity(wall_distance: Float64Array, bulk: float) -> Float64Array:
    """Return the porosity of randomly packed equal spheres near a wall by de Klerk's correlation.

    A. de Klerk, AIChE Journal 49 (2003) 2022: ``2.14 x^2 - 2.53 x + 1`` up to x = 0.637, beyond
    ``eb + 0.29 exp(-0.6 x) cos(2.3 pi (x - 0.16)) + 0.15 exp(-0.9 x)``.

    Args:
        wall_distance: Distances x from the wall, in sphere diameters, any shape, float64.
        bulk: Porosity eb far from the wall.

    Returns:
        Porosities, shape of ``wall_distance``, float64.
    """
    x = np.asarray(wall_distance, dtype=np.float64)
    near = 2.14 * x**2 - 2.53 * x + 1.0
    wave = 0.29 * np.exp(-0.6 * x) * np.cos(2.3 * np.pi * (x - 0.16))
    return np.where(x <= 0.637, near, bulk + wave + 0.15 * np.exp(-0.9 * x))


def _averaged(curve: Callable[[Float64Array], Float64Array], distance: Float64Array) -> tuple[float, ...]:
    """Mean of a curve over each shell, at eleven places, so that it is compared like with like."""
    inside = np.linspace(distance[:-1], distance[1:], 11)
    weight = np.maximum(distance[-1] - inside, 0.0)  # a shell's area grows with its radius
    return tuple((np.sum(curve(inside) * weight, axis=0) / weight.sum(axis=0)).tolist())
