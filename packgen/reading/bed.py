"""A bed from the spheres of a file, and from what is known besides; what is not known is left open.

A density that is not known is NaN, materials that are not known are missing, walls that are not known have no
surface: `unknowns` names what of that a use would need.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.errors import ReadError
from packgen.geometry import Box, Container, Surface
from packgen.reading.detect import read_spheres
from packgen.reading.known import Known, known_by_provenance, known_by_scene
from packgen.reading.sets import sets_of, with_densities
from packgen.reading.spheres import SphereFile
from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.scene import Scene

GRAVITY = (0.0, 0.0, -9.81)
TOLERANCE = 1.0e-6
DENSITY, MATERIALS, WALLS = "density", "materials", "walls"
NO_WALLS = "spheres"  # name of the box around spheres whose walls are not known


def _ignore(_line: str) -> None:
    """Drop a warning."""


def read_bed(
    path: Path | str,
    container: Container | None = None,
    *,
    scene: Scene | None = None,
    density: float | Mapping[str, float] | None = None,
    step: int | None = None,
    units: str = "m",
    warn: Callable[[str], None] = _ignore,
) -> Bed:
    """Read a bed from a file of any format that packgen reads.

    What neither file nor arguments say is left open: densities are NaN, there are no materials, and the
    container is the box around the spheres, without a surface. Nothing is made up; exporters refuse a bed
    that lacks what they write.

    Args:
        path: The file.
        container: The vessel; None: the scene's, else the one that the file knows.
        scene: Says sets, densities, materials, walls and gravity.
        density: Density of all spheres whose density is not known [kg/m3], or densities by name of the set.
        step: Which step of a dump, or of an XYZ file; None: the last one.
        units: Unit of the file's lengths: m, cm, mm, um, in or ft.
        warn: Called with a line for each thing that looks wrong.

    Returns:
        The bed; its spheres are in the order of their ids where the file has any.

    Raises:
        ReadError: The file is not what it claims, or does not fit the scene; a line a fault.
    """
    spheres = read_spheres(Path(path), step=step, units=units)
    if scene is None:
        known = known_by_provenance(spheres.provenance)
    else:
        from packgen.container import load_container

        known = known_by_scene(scene, container or load_container(scene, warn))
    given = density if isinstance(density, Mapping) else {} if density is None else {"": density}
    return bed_of(spheres, known, container, density=given, warn=warn)


def bed_of(
    spheres: SphereFile,
    known: Known,
    container: Container | None = None,
    *,
    density: Mapping[str, float] = MappingProxyType({}),
    warn: Callable[[str], None] = _ignore,
) -> Bed:
    """Return the bed of a file's spheres.

    Args:
        spheres: The spheres.
        known: What is known of the bed.
        container: The vessel, where it is not the known one.
        density: Densities [kg/m3] by name of the set; "" stands for all that are not known.
        warn: Called with a line for each thing that looks wrong.

    Raises:
        ReadError: File and scene do not fit.
    """
    vessel = container or known.container or _own_container(spheres)
    sets, set_index = sets_of(spheres, known, walls=not all(vessel.periodic), warn=warn)
    if known.gravity is None:
        warn(f"{spheres.path}: gravity is not in the file: -z is taken for down; --scene says otherwise")
    nothing = np.zeros(spheres.count, np.int32)
    zones, batches = spheres.zone_index, spheres.batch_index
    return Bed(
        _wrapped(spheres.position, vessel), spheres.radius, set_index,
        nothing if zones is None else zones, nothing if batches is None else batches,
        with_densities(sets, density), known.materials, known.wall_material, vessel,
        np.array(GRAVITY) if known.gravity is None else known.gravity,
        TOLERANCE if not known.source else known.tolerance,
        _provenance(spheres, known),
        spheres.body_index,
    )  # fmt: skip


def unknowns(bed: Bed, needs: Iterable[str]) -> list[str]:
    """Return a line for each thing of a bed that is needed and not known.

    Args:
        bed: The bed.
        needs: ``density``, ``materials``, ``walls``; or fewer.
    """
    needed, lines = set(needs), []
    if DENSITY in needed:
        lines += [
            f"density of {each.name} is not in the file: give --scene, or --density {each.name}=VALUE"
            for each in bed.particle_sets
            if np.isnan(each.density)
        ]
    if MATERIALS in needed and not bed.materials:
        lines.append(
            "materials (Young's modulus, Poisson's ratio, restitution, friction) are not in the file: "
            "give --scene"
        )
    if WALLS in needed and not has_known_walls(bed.container):
        lines.append("walls are not in the file: give --scene, or --container")
    return lines


def has_known_walls(container: Container) -> bool:
    """Return whether the walls of a container are known, or it is known to have none."""
    return len(container.surface.faces) > 0 or all(container.periodic)


def _own_container(spheres: SphereFile) -> Container:
    """Return the box around the spheres, and that of the file along axes where it wraps around."""
    low = (spheres.position - spheres.radius[:, None]).min(axis=0)
    high = (spheres.position + spheres.radius[:, None]).max(axis=0)
    periodic = (False, False, False)
    if spheres.cell is not None:
        periodic = spheres.cell.periodic
        wraps = np.array(periodic)
        low[wraps], high[wraps] = spheres.cell.bounds[:, wraps]
    surface = Surface(np.stack([low, high]), np.zeros((0, 3), np.int64))
    bounds = np.stack([low, high])
    return Container(NO_WALLS, Box(low, high), surface, bounds, float(np.prod(high - low)), periodic)


def _wrapped(position: Float64Array, container: Container) -> Float64Array:
    """Return positions inside the period of a container that wraps around; dumps may leave it."""
    low, high = container.bounds
    wrapped = position
    for axis in np.flatnonzero(container.periodic):
        along, size = wrapped[:, axis], high[axis] - low[axis]
        out = (along < low[axis]) | (along >= high[axis])
        if out.any():
            wrapped = wrapped.copy() if wrapped is position else wrapped
            inside = low[axis] + np.mod(along[out] - low[axis], size)
            wrapped[out, axis] = np.where(inside >= high[axis], low[axis], inside)
    return wrapped


def _provenance(spheres: SphereFile, known: Known) -> dict[str, Any]:
    said = {"packgen": __version__, "scene": "none", "seed": "none", **known.provenance}
    return said | {"read_from": spheres.path.name, "format": spheres.format}


def refuse_unknown(path: Path, lines: Iterable[str]) -> None:
    """Raise what is not known and needed, a line each.

    Raises:
        ReadError: There is something.
    """
    found = [f"{path}: {line}" for line in lines]
    if found:
        raise ReadError("\n".join(found))
