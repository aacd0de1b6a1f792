"""Chrono DEM-Engine: ``bed.csv`` with the columns X,Y,Z,r,family, that of its own sphere output.

Reference: DEM-Engine source, ``DEM/Structs.h``, ``WriteSphereFile`` and ``ReadClumpXyzFromCsv``. A sphere of
each radius is a clump type of its own there: read the file, ``LoadSphereType(mass, r, material)`` for each
radius, and place it.

A bed with clumps is one of clumps: ``bed.csv`` has the columns X,Y,Z,Qw,Qx,Qy,Qz,clump_type, which
``ReadClumpXyzFromCsv`` and ``ReadClumpQuatFromCsv`` read, and ``clumps/`` has the spheres of each type, a
template of one size, as x,y,z,r about the centre of mass; a single sphere is a type of its radius.
``clump_types.csv`` has what ``LoadClumpType`` asks for besides: mass and the moments of inertia. DEM-Engine
takes a clump's frame for that of its principal axes, so that the spheres, and the quaternions, are those of
that frame.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exporters.shared import deck, table
from exporters.shared.clumps import body_density, template_label
from packgen.arrays import Float64Array, unique_rows
from packgen.bed import SINGLE, Bed, Bodies, has_clumps, quaternions, rotations
from packgen.errors import ExportError

NAME = "chrono"
NEEDS: tuple[str, ...] = ()
CLUMPS = True
TYPES_MAX = 1000  # clump types in a file each
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.csv``, and the clumps where there are any, into an existing folder and return the paths.

    Raises:
        ExportError: The bed is empty, a number in it is not finite, or it has too many sizes of clumps.
    """
    deck.check_exportable(bed, NAME, NEEDS, clumps=True)
    if has_clumps(bed):
        assert bed.bodies is not None
        return _write_clumps(bed, bed.bodies, folder)
    columns = [*bed.position.T, bed.radius, bed.set_index]
    return [table.write_rows(folder / "bed.csv", columns, head="X,Y,Z,r,family\n", separator=",")]


def _write_clumps(bed: Bed, bodies: Bodies, folder: Path) -> list[Path]:
    density = body_density(bed)
    known = np.isfinite(density).all()
    kinds = np.column_stack([bodies.template_index, bodies.scale, density if known else 0.0 * density])
    first, kind = unique_rows(kinds)
    if len(first) > TYPES_MAX:
        raise ExportError(
            f"chrono: found clumps of {len(first):,} sizes, expected at most {TYPES_MAX:,}, since each is a"
            " clump type of its own; give them fewer sizes"
        )
    frames = [_principal(each.inertia) for each in bodies.templates] + [
        (np.full(3, 8 / 15 * np.pi), np.eye(3))
    ]
    turn = rotations(bodies.orientation) @ np.array([axes for _, axes in frames])[bodies.template_index]
    names = np.array([f"{_label(bodies, place)}_{number}" for number, place in enumerate(first.tolist())])
    head = "X,Y,Z,Qw,Qx,Qy,Qz,clump_type\n"
    columns = [*bodies.position.T, *quaternions(turn).T, names[kind]]
    paths = [table.write_rows(folder / "bed.csv", columns, head=head, separator=",")]
    (folder / "clumps").mkdir(exist_ok=True)
    for name, place in zip(names, first.tolist(), strict=True):
        spheres = _spheres(bodies, place, frames[bodies.template_index[place]][1])
        file = folder / "clumps" / f"{name}.csv"
        paths.append(table.write_rows(file, list(spheres.T), head="x,y,z,r\n", separator=","))
    moments = np.array([frames[number][0] for number in bodies.template_index[first]])
    mass = density[first] if known else np.ones(len(first))
    rows = [names, mass * bodies.volume[first], *(mass[:, None] * moments * bodies.scale[first, None] ** 5).T]
    head = f"clump_type,{'mass' if known else 'volume'},Ixx,Iyy,Izz\n"
    return [*paths, table.write_rows(folder / "clump_types.csv", rows, head=head, separator=",")]


def _label(bodies: Bodies, place: int) -> str:
    number = int(bodies.template_index[place])
    return "sphere" if number == SINGLE else template_label(bodies, number)


def _principal(inertia: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the principal moments, rising, shape (3,), and their axes as columns, right-handed."""
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return moments, axes


def _spheres(bodies: Bodies, place: int, axes: Float64Array) -> Float64Array:
    """Return the spheres of a body in the frame of its principal axes [m], shape (n, 4)."""
    number = int(bodies.template_index[place])
    if number == SINGLE:
        return np.array([[0.0, 0.0, 0.0, bodies.scale[place]]])
    spheres = bodies.templates[number].spheres
    return np.asarray(bodies.scale[place] * np.column_stack([spheres[:, :3] @ axes, spheres[:, 3]]))
