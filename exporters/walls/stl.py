"""STL files of walls and of other surfaces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array

ROWS_PER_CHUNK = 8192


def write_stl(path: Path, triangles: Float64Array, *, binary: bool = False) -> Path:
    """Write facets as an STL file, by default as ASCII in full double precision.

    The head of a binary file does not start with ``solid``, which makes readers take it for ASCII.

    Args:
        path: The file.
        triangles: Corners [m], shape (F, 3, 3).
        binary: Write the binary form, in single precision.
    """
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    if binary:
        row = np.dtype([("facet", "<f4", (4, 3)), ("attribute", "<u2")])
        rows = np.zeros(len(triangles), dtype=row)
        rows["facet"] = np.concatenate((normal[:, None], triangles), axis=1)
        path.write_bytes(b"packgen wall".ljust(80, b"\0") + np.uint32(len(rows)).tobytes() + rows.tobytes())
        return path
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write("solid wall\n")
        file.writelines(_ascii_chunks(np.concatenate((normal[:, None], triangles), axis=1)))
        file.write("endsolid wall\n")
    return path


def write_solids(path: Path, solids: Mapping[str, Iterable[Float64Array]]) -> Path:
    """Write solids one behind the other into an ASCII STL file, in ten digits.

    Args:
        path: The file.
        solids: Parts of each solid by its name, corners [m], shapes (F, 3, 3).
    """
    with path.open("w", encoding="ascii", newline="\n") as file:
        for name, parts in solids.items():
            file.write(f"solid {name}\n")
            for triangles in parts:
                normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
                normal /= np.linalg.norm(normal, axis=1, keepdims=True)
                file.writelines(_ascii_chunks(np.concatenate((normal[:, None], triangles), axis=1), "%.10g"))
            file.write(f"endsolid {name}\n")
    return path


def _ascii_chunks(facets: Float64Array, number: str = "%.17g") -> Iterator[str]:
    vertex = f"  vertex {number} {number} {number}\n"
    form = f"facet normal %.9g %.9g %.9g\n outer loop\n{vertex}{vertex}{vertex} endloop\nendfacet\n"
    for start in range(0, len(facets), ROWS_PER_CHUNK):
        part = facets[start : start + ROWS_PER_CHUNK]
        yield form * len(part) % tuple(part.ravel().tolist())
