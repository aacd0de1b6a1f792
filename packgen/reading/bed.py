"""A bed from the spheres of a file, and from what is known besides; what is not known is left open.

A density that is not known is NaN, materials that are not known are missing, and the box around the spheres
stands for walls that are not known: `unknowns` names what of that a use would need.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import UNKNOWN, AnyBed, Bed
from packgen.container.primitives import box_surface
from packgen.errors import ReadError
from packgen.geometry import Box, Container
from packgen.geometry.cells import cell_container, into_cell
from packgen.reading.detect import read_spheres
from packgen.reading.known import earlier_by_provenance, known_by_provenance, known_by_scene
from packgen.reading.plausible import refuse_other_units, size_remark
from packgen.reading.sets import sets_of, with_densities
from packgen.reading.spheres import SphereFile
from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.scene import Scene

GRAVITY = (0.0, 0.0, -9.81)
TOLERANCE = 1.0e-6
DENSITY, MATERIALS, WALLS = "density", "materials", "walls"


def _ignore(_line: str) -> None:
    """Drop a warning."""


def read_bed(
    path: Path | str,
    container: Container | None = None,
    *,
    scene: Scene | None = None,
    density: float | Mapping[str, float] | None = None,
    step: int | None = None,
    units: str | None = None,
    warn: Callable[[str], None] = _ignore,
) -> Bed:
    """Read a bed from a file of any format that packgen reads.

    What neither file nor arguments say is left open: densities are NaN, there are no materials, and the
    container is the box around the spheres, with ``walls_known`` false. Nothing is made up in silence:
    `unknowns` names what is not known.

    Args:
        path: The file.
        container: The vessel; None: the scene's, else the one that the file knows.
        scene: Says sets, densities, materials, walls and gravity.
        density: Density of all spheres whose density is not known [kg/m3], or densities by name of the set.
        step: Which step of a dump, or of an XYZ file; None: the last one.
        units: Unit of the file's lengths: m, cm, mm, um, in or ft; None: metres, unless they look like
            another unit, which is refused.
        warn: Called with a line for each thing that looks wrong.

    Returns:
        The bed; its spheres are in the order of their ids where the file has any.

    Raises:
        ReadError: The file is not what it claims, or does not fit the scene; a line a fault.
    """
    spheres = read_spheres(Path(path), step=step, units=units)
    given = density if isinstance(density, Mapping) else {} if density is None else {"": density}
    return complete_bed(spheres, container, scene=scene, density=given, units=units, warn=warn)


def complete_bed(
    spheres: SphereFile,
    container: Container | None = None,
    *,
    scene: Scene | None = None,
    density: Mapping[str, float] = MappingProxyType({}),
    units: str | None = None,
    warn: Callable[[str], None] = _ignore,
) -> Bed:
    """Return the bed of spheres that have been read, as `read_bed` does.

    Args:
        spheres: The spheres.
        container: The vessel; None: the scene's, else the one that the file knows.
        scene: Says sets, densities, materials, walls and gravity.
        density: Densities [kg/m3] by name of the set; "" stands for all that are not known.
        units: Unit in which the spheres were read; None: metres, unless they look like another unit.
        warn: Called with a line for each thing that looks wrong.

    Raises:
        ReadError: The spheres do not fit scene or container; a line a fault.
    """
    if scene is None:
        known = known_by_provenance(spheres.provenance)
    else:
        from packgen.container import load_container

        known = known_by_scene(scene, container or load_container(scene, warn))
    in_cell = spheres.cell is not None and spheres.cell.vectors is not None
    vessel = None if in_cell else container or known.container
    if units is None:
        refuse_other_units(spheres, vessel)
        remark = size_remark(spheres) if vessel is None else None
        if remark is not None:
            warn(remark)
    if vessel is None:
        vessel = _own_container(spheres)
        if not vessel.walls_known:
            warn(
                f"{spheres.path}: walls are not in the file: figures are of the box around the spheres; "
                "--scene or --container says otherwise"
            )
    sets, set_index = sets_of(spheres, known, walls=not all(vessel.periodic), warn=warn)
    if known.gravity is None:
        warn(f"{spheres.path}: gravity is not in the file: -z is taken for down; --scene says otherwise")
    nothing = np.zeros(spheres.count, np.int32)
    zones, batches = spheres.zone_index, spheres.batch_index
    return Bed(
        wrapped(spheres.position, vessel), spheres.radius, set_index,
        nothing if zones is None else zones, nothing if batches is None else batches,
        with_densities(sets, density), known.materials, known.wall_material, vessel,
        np.array(GRAVITY) if known.gravity is None else known.gravity,
        TOLERANCE if not known.source else known.tolerance,
        provenance_of(spheres.path, spheres.format, known.provenance, walls_known=vessel.walls_known),
        spheres.body_index,
        None if zones is None else earlier_by_provenance(spheres.provenance),
        spheres.bodies,
    )  # fmt: skip


def unknowns(bed: AnyBed, needs: Iterable[str]) -> list[str]:
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
    if WALLS in needed and not bed.container.walls_known:
        lines.append("walls are not in the file: give --scene, or --container")
    return lines


def _own_container(spheres: SphereFile) -> Container:
    """Return the box around the spheres, and that of the file along axes where it wraps around."""
    if spheres.cell is not None and spheres.cell.vectors is not None:
        return cell_container(spheres.cell.vectors)
    low = (spheres.position - spheres.radius[:, None]).min(axis=0)
    high = (spheres.position + spheres.radius[:, None]).max(axis=0)
    periodic = (False, False, False)
    if spheres.cell is not None:
        periodic = spheres.cell.periodic
        wraps = np.array(periodic)
        low[wraps], high[wraps] = spheres.cell.bounds[:, wraps]
    box = Box(low, high)
    volume = float(np.prod(high - low))
    return Container(
        "box", box, box_surface(box), np.stack([low, high]), volume, periodic, walls_known=all(periodic)
    )


def wrapped(position: Float64Array, container: Container) -> Float64Array:
    """Return positions inside the period of a container that wraps around; dumps may leave it."""
    if container.cell is not None:
        return into_cell(position, container.cell)
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


def provenance_of(path: Path, kind: str, known: Mapping[str, Any], *, walls_known: bool) -> dict[str, Any]:
    """Return the provenance of a bed that was read from a file of some kind."""
    said = {"packgen": __version__, "scene": "none", "seed": "none", **known}
    said.pop("walls", None)
    walls = {} if walls_known else {"walls": UNKNOWN}
    return said | {"read_from": path.name, "format": kind} | walls


def refuse_unknown(path: Path, bed: AnyBed, needs: Iterable[str]) -> None:
    """Refuse a bed that lacks something that is needed; see `unknowns`.

    Raises:
        ReadError: It does; a line for each thing.
    """
    lines = [f"{path}: {line}" for line in unknowns(bed, needs)]
    if lines:
        raise ReadError("\n".join(lines))
