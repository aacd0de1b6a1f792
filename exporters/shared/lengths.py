"""Another unit of length for a solver whose meshes have limits of their own: the bed, in that unit.

With lengths in units of u metres, times in u seconds and masses in u^3 kilograms, densities [kg/m3], moduli
[Pa] and velocities [m/s] keep their SI numbers. Lengths and times are divided by u, accelerations multiplied;
forces come out in u^2 N, energies in u^3 J. Nothing but the numbers changes: the equations of motion, Hertz'
law and Coulomb's are the same in every consistent set of units.

What LIGGGHTS 3.8 does with small and large meshes (found by running it, and read in its source): it stops at
meshes whose coordinates span less than 1e-4 ("dimensions too small - use different unit system"), takes
corners closer than 1e-8 for one, whatever ``precision`` says, and takes the distance of a sphere from a facet
for 1e7 at most, so that it finds walls that are not there in a vessel of 1e9 m. Its primitive walls, LAMMPS
and YADE run vessels of 1e-7 to 1e9 m in metres.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from packgen.bed import AnyBed, Bed, Census, Head, Material, ParticleSet
from packgen.geometry import (
    Ball,
    Box,
    Cone,
    Container,
    Mesh,
    Motion,
    Polyhedron,
    Rotation,
    Shape,
    Surface,
    Vibration,
)

# Sizes that keep a factor of ten from those that LIGGGHTS refuses or gets wrong [m].
MESH_SIZE_MIN = 1.0e-3
MESH_SIZE_MAX = 1.0e6


def mesh_unit(container: Container) -> float:
    """Return the unit of length [m] in which LIGGGHTS takes the container's mesh: 1, or a power of 1000."""
    size = float(np.ptp(container.bounds, axis=0).max())
    if MESH_SIZE_MIN <= size <= MESH_SIZE_MAX:
        return 1.0
    return float(f"1e{3 * math.floor(math.log10(size) / 3)}")


@dataclass(frozen=True, eq=False, slots=True)
class _InUnit(Head):
    """A bed in pieces, in another unit of length."""

    bed: AnyBed
    unit: float
    particle_sets: tuple[ParticleSet, ...]
    materials: tuple[Material, ...]
    wall_material: str
    container: Container
    gravity: NDArray[np.float64]
    provenance: Mapping[str, Any]
    census: Census

    @property
    def count(self) -> int:
        """Number of spheres."""
        return self.bed.count

    def chunks(self) -> Iterator[Bed]:
        """Yield the spheres, some at a time."""
        for chunk in self.bed.chunks():
            yield _bed_in_unit(chunk, self.unit)


def in_unit(bed: AnyBed, unit: float) -> AnyBed:
    """Return a bed with lengths in units of ``unit`` metres, and gravity to match; the bed itself for 1."""
    if unit == 1.0:
        return bed
    if isinstance(bed, Bed):
        return _bed_in_unit(bed, unit)
    census: Census | None = None
    for chunk in bed.chunks():
        own = _bed_in_unit(chunk, unit).census
        census = own if census is None else census.join(own)
    assert census is not None  # an empty bed has been refused
    return _InUnit(
        bed, unit, bed.particle_sets, bed.materials, bed.wall_material, _container(bed.container, unit),
        bed.gravity * unit, bed.provenance, census,
    )  # fmt: skip


def _bed_in_unit(bed: Bed, unit: float) -> Bed:
    return replace(
        bed,
        position=bed.position / unit,
        radius=bed.radius / unit,
        bodies=None if bed.bodies is None else bed.bodies.scaled(1.0 / unit),
        gravity=bed.gravity * unit,
        container=_container(bed.container, unit),
    )


def _container(container: Container, unit: float) -> Container:
    return replace(
        container,
        shape=_shape(container.shape, unit),
        surface=_surface(container.surface, unit),
        bounds=container.bounds / unit,
        volume=container.volume / unit**3,
        parts=tuple(replace(each, motion=_motion(each.motion, unit)) for each in container.parts),
    )


def _motion(motion: Motion | None, unit: float) -> Motion | None:
    """Return a motion in the unit, in which velocities are what they were."""
    if isinstance(motion, Rotation):
        return Rotation(motion.origin / unit, motion.axis, motion.period / unit)
    if isinstance(motion, Vibration):
        return Vibration(motion.amplitude / unit, motion.period / unit)
    return motion


def _surface(surface: Surface, unit: float) -> Surface:
    return Surface(surface.vertices / unit, surface.faces)


def _shape(shape: Shape, unit: float) -> Shape:
    if isinstance(shape, Box):
        return Box(shape.min / unit, shape.max / unit)
    if isinstance(shape, Cone):
        return replace(
            shape,
            base=shape.base / unit,
            height=shape.height / unit,
            radius_bottom=shape.radius_bottom / unit,
            radius_top=shape.radius_top / unit,
        )
    if isinstance(shape, Ball):
        return Ball(shape.center / unit, shape.radius / unit)
    if isinstance(shape, Polyhedron):
        return Polyhedron(shape.normal, shape.offset / unit, _surface(shape.surface, unit))
    assert isinstance(shape, Mesh)
    return Mesh(_surface(shape.surface, unit))


def unit_values(unit: float) -> dict[str, object]:
    """Return what a template says of the units: ``unit`` and its powers, ``None`` where all is SI."""
    if unit == 1.0:
        return {"unit": None}
    power = round(math.log10(unit))
    return {
        "unit": {
            "length": f"1e{power}",
            "mass": f"1e{3 * power}",
            "force": f"1e{2 * power}",
            "energy": f"1e{3 * power}",
            "acceleration": f"1e{-power}",
            "why": "small" if unit < 1 else "large",
        }
    }
