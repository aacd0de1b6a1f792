"""The data file that LIGGGHTS' and LAMMPS' ``read_data`` share: atom style sphere (granular).

Format: LAMMPS manual, page "read_data": a title line, the header, the section ``Atoms``, a blank line, and
    one row a
sphere, ``id type diameter density x y z``. The third column is the diameter. A centre on the upper face of
the box, or beyond it, is not assigned to any processor and stops the solver, so the box is wider than the
bed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic_core import to_json

from exporters.contact import Types
from packgen.bed import Bed

ROWS_PER_CHUNK = 8192
HEAD_ROOM = 0.25  # of the container's height, above an open rim: what a run may throw up is not lost


def simulation_box(bed: Bed, *, open_top: bool) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the lower and upper corner of the solver's box [m], shape (2, 3), float64.

    It holds the container and all centres with a diameter of the largest sphere to spare, and more than that
    above an open top. Along periodic directions it is the container's box exactly.
    """
    diameter_max = 2 * float(bed.radius.max())
    low = np.minimum(bed.container.bounds[0], bed.position.min(axis=0)) - diameter_max
    high = np.maximum(bed.container.bounds[1], bed.position.max(axis=0)) + diameter_max
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


def write_data(
    bed: Bed, path: Path, types: Types, box: np.ndarray[tuple[int, ...], np.dtype[np.float64]], title: str
) -> Path:
    """Write the spheres of a bed as a data file; the id of a sphere is its index in the bed plus one.

    Every number is the shortest text that reads back as the same float64 (pydantic's JSON writer does that
    five times faster than ``%.17g``). Rows are made in chunks: the bed is never copied as a whole.

    Args:
        bed: What is written.
        path: The file.
        types: Types of the sets.
        box: Lower and upper corner of the box [m], shape (2, 3).
        title: First line, which the solvers skip.
    """
    density = np.array([each.density for each in bed.particle_sets], dtype=np.float64)
    sphere_type = np.array(types.by_set, dtype=np.int64)
    lines = [f"# {title}", "", f"{bed.count} atoms", f"{len(types.materials)} atom types", ""]
    lines += [
        f"{low!r} {high!r} {axis}lo {axis}hi" for axis, (low, high) in zip("xyz", box.T.tolist(), strict=True)
    ]
    lines += ["", "Atoms", ""]
    with path.open("wb") as file:
        file.write("\n".join(lines).encode("ascii") + b"\n")
        for start in range(0, bed.count, ROWS_PER_CHUNK):
            part = slice(start, min(start + ROWS_PER_CHUNK, bed.count))
            set_index = bed.set_index[part]
            rows = zip(
                range(part.start + 1, part.stop + 1),
                sphere_type[set_index].tolist(),
                (2 * bed.radius[part]).tolist(),
                density[set_index].tolist(),
                *bed.position[part].T.tolist(),
                strict=True,
            )
            # [[1,1,0.1],[2,1,0.1]] as JSON is the rows but for its brackets and commas.
            file.write(to_json(list(rows))[2:-2].replace(b"],[", b"\n").replace(b",", b" ") + b"\n")
    return path
