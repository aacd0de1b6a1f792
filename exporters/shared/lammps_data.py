"""The data file that LIGGGHTS' and LAMMPS' ``read_data`` share: atom style sphere (granular).

Format: LAMMPS manual, page "read_data": a title line, the header, the section ``Atoms``, a blank line, and
one row a sphere, ``id type diameter density x y z``. The third column is the diameter. A centre on the upper
face of the box, or beyond it, is not assigned to any processor and stops the solver, so the box is wider than
the bed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exporters.shared import deck, table
from exporters.shared.clumps import Clumps
from exporters.shared.contact import Types
from packgen.bed import AnyBed, Bed, numbered

# Both programs sort spheres by bins of half the neighbour distance and stop beyond 2^31 of them.
SORT_BINS_MAX = 1.0e8
SPHERES_AT_A_TIME = 65536  # written at once: the bed is never copied as a whole
HEAD_ROOM = 0.25  # room above an open rim [container heights]: spheres that a run throws up are kept

Float64Array = NDArray[np.float64]


def simulation_box(bed: AnyBed, *, open_top: bool, walls: Float64Array | None = None) -> Float64Array:
    """Return the lower and upper corner of the solver's box [m], shape (2, 3), float64.

    It holds the container and all centres with a diameter of the largest sphere to spare, and more than that
    above an open top. Along periodic directions it is the container's box exactly; of a cell of any shape,
    the box that its tilts make the cell.

    Args:
        bed: The bed.
        open_top: Whether the container is open at its top.
        walls: Lower and upper corner of what walls that move reach [m], shape (2, 3); None: the container's.
    """
    if bed.container.cell is not None:
        return np.stack((np.zeros(3), np.diag(bed.container.cell)))
    diameter_max = 2 * max(bed.census.radius_max)
    bounds = bed.container.bounds if walls is None else walls
    low = np.minimum(bounds[0], bed.census.low) - diameter_max
    high = np.maximum(bounds[1], bed.census.high) + diameter_max
    strength = float(np.linalg.norm(bed.gravity))
    if open_top and strength > 0:
        up = -bed.gravity / strength
        height = float(np.abs(up) @ (bed.container.bounds[1] - bed.container.bounds[0]))
        room = max(HEAD_ROOM * height, 10 * diameter_max)
        low += room * np.minimum(up, 0)
        high += room * np.maximum(up, 0)
    periodic = np.array(bed.container.periodic)
    low[periodic] = bed.container.bounds[0][periodic]
    high[periodic] = bed.container.bounds[1][periodic]
    return np.stack((low, high))


def box_values(bed: AnyBed, box: Float64Array) -> dict[str, Any]:
    """Return the values of the solver's box and neighbour search that both programs' templates place.

    Args:
        bed: The bed.
        box: Lower and upper corner of the box [m], shape (2, 3).
    """
    skin = 0.5 * min(bed.census.radius_min)
    bins = float(np.prod(np.ceil((box[1] - box[0]) / (max(bed.census.radius_max) + skin / 2))))
    return {
        "boundary": " ".join("p" if wraps else "f" for wraps in bed.container.periodic),
        "sort": bins <= SORT_BINS_MAX,
        "skin": skin,
    }


def write_data(bed: AnyBed, path: Path, types: Types, box: Float64Array) -> Path:
    """Write the spheres of a bed as a data file; the id of a sphere is its index in the bed plus one.

    Args:
        bed: What is written.
        path: The file.
        types: Types of the sets.
        box: Lower and upper corner of the box [m], shape (2, 3).
    """
    head = data_head(bed, types, box, [], "Atoms")
    density = np.array([each.density for each in bed.particle_sets], dtype=np.float64)
    sphere_type = np.array(types.by_set, dtype=np.int64)

    def parts() -> Iterator[list[NDArray[Any]]]:
        for before, chunk in numbered(bed):
            for start in range(0, chunk.count, SPHERES_AT_A_TIME):
                some = slice(start, min(start + SPHERES_AT_A_TIME, chunk.count))
                set_index = chunk.set_index[some]
                yield [
                    np.arange(before + some.start + 1, before + some.stop + 1), sphere_type[set_index],
                    2 * chunk.radius[some], density[set_index], *chunk.position[some].T,
                ]  # fmt: skip

    return table.write_parts(path, parts(), head=head)


def write_spheres(
    bed: AnyBed, folder: Path, types: Types, box: Float64Array, clumps: Clumps | None, *, motion: bool
) -> list[Path]:
    """Write ``bed.data`` as `write_data` does, of a bed with clumps as `write_clumps` does."""
    if clumps is None:
        return [write_data(bed, folder / "bed.data", types, box)]
    assert isinstance(bed, Bed)
    return write_clumps(bed, folder, types, box, clumps, motion=motion)


def write_clumps(
    bed: Bed, folder: Path, types: Types, box: Float64Array, clumps: Clumps, *, motion: bool
) -> list[Path]:
    """Write ``bed.data`` in the style that has molecules, and what each body of ``clumps`` is.

    Rows: ``id type x y z diameter density molecule`` and the images of the box; molecule 0 is no clump.
    Bodies: ``clumps.infile``, whose rows have molecule, mass, centre of mass and inertia (xx yy zz xy xz yz),
    and end as LAMMPS has it: velocity, angular momentum, image of the box. LIGGGHTS takes no more than the
    first eleven.

    Args:
        bed: What is written.
        folder: Where to.
        types: Types of the sets.
        box: Lower and upper corner of the box [m], shape (2, 3).
        clumps: Its clumps.
        motion: Whether the file of the bodies ends with their motion and images.
    """
    place, image = clumps.member.copy(), np.zeros((bed.count, 3), np.int64)
    low, high = bed.container.bounds
    for axis in np.flatnonzero(bed.container.periodic):
        size = high[axis] - low[axis]
        image[:, axis] = np.floor((place[:, axis] - low[axis]) / size)
        along = place[:, axis] - size * image[:, axis]
        place[:, axis] = np.where(along >= high[axis], low[axis], np.maximum(along, low[axis]))
    columns = [
        table.ids(bed), np.array(types.by_set, np.int64)[bed.set_index], *place.T, 2 * bed.radius,
        clumps.density, clumps.molecule, *image.T,
    ]  # fmt: skip
    head = data_head(bed, types, box, [], "Atoms # hybrid")
    data = table.write_rows(folder / "bed.data", columns, head=head)
    return [data, _write_infile(folder / "clumps.infile", clumps, motion=motion)]


def clump_values(clumps: Clumps | None, values: dict[str, Any]) -> dict[str, Any]:
    """Return what both programs' templates place of clumps: ``clumps``, None where there are none.

    Args:
        clumps: The clumps of a bed.
        values: What the template places besides.
    """
    if clumps is None:
        return {"clumps": None}
    # Ghosts have to reach over a whole body from the sphere that owns it.
    cutoff = 2 * max(clumps.reach, values["radius_max"]) + 2 * values["skin"]
    return {"clumps": {"count": clumps.count, "singles": clumps.has_singles, "cutoff": cutoff}}


def _write_infile(path: Path, clumps: Clumps, *, motion: bool) -> Path:
    inertia = clumps.inertia
    zero = np.zeros(clumps.count, np.int64)
    entries = [inertia[:, row, column] for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    columns = [clumps.row + 1, clumps.mass, *clumps.position.T, *entries, *(9 * [zero] if motion else [])]
    return table.write_rows(path, columns, head=f"{clumps.count}\n")


def data_head(bed: AnyBed, types: Types, box: Float64Array, counts: list[str], section: str) -> str:
    """Return what a data file has before its first row.

    Args:
        bed: The bed.
        types: Types of the sets.
        box: Lower and upper corner of the box [m], shape (2, 3).
        counts: More lines of the header, such as ``12 bonds``.
        section: Name of the first section.
    """
    told = deck.provenance_values(bed)
    title = f"{bed.count} spheres, packgen {told['version']}, scene {told['scene']}, seed {told['seed']}"
    lines = [f"# {title}", "", f"{bed.count} atoms", f"{len(types.materials)} atom types", *counts, ""]
    lines += [
        f"{low!r} {high!r} {axis}lo {axis}hi" for axis, (low, high) in zip("xyz", box.T.tolist(), strict=True)
    ]
    if bed.container.cell is not None:
        (_, _, _), (xy, _, _), (xz, yz, _) = bed.container.cell.tolist()
        lines.append(f"{xy!r} {xz!r} {yz!r} xy xz yz")
    return "\n".join([*lines, "", section, ""]) + "\n"
