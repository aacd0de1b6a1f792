"""The solids of a text STL file by name: parts of one surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packgen.arrays import Int64Array
from packgen.container.meshfile import clean_surface, read_surface
from packgen.errors import GeometryError
from packgen.geometry import Surface

NAMED_MAX = 8  # names of solids that a message lists


@dataclass(frozen=True, eq=False, slots=True)
class NamedSurfaces:
    """The surfaces of a file by name.

    Attributes:
        surfaces: In metres, by name; "" for what has none.
        names: All names in the file.
        mended: A sentence for each kind of fault that was mended.
    """

    surfaces: dict[str, Surface]
    names: tuple[str, ...]
    mended: tuple[str, ...]


def read_solids(path: Path, scale: float, place: str) -> NamedSurfaces:
    """Read the solids of a text STL file, each as a surface; those of one name are one.

    Args:
        path: The file.
        scale: Metres a unit of the file.
        place: Where the scene names the file, for messages.

    Raises:
        GeometryError: The file cannot be read, or has no solids by name.
    """
    read_surface(path, scale, place)  # says what is wrong with a file that cannot be read
    with path.open("rb") as file:
        head = file.read(512)
    if path.suffix.lower() != ".stl" or b"\0" in head or not head.lstrip().lower().startswith(b"solid"):
        raise GeometryError(
            f"{place}: {path.name} has no solids by name, expected a text STL file that has, or a mesh with "
            "named groups such as gmsh's .msh; give each of the `walls` a `path`"
        )
    solids: dict[str, list[list[float]]] = {}
    corners: list[list[float]] = []
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.split()
            if not words:
                continue
            if words[0].lower() == "solid":
                corners = solids.setdefault(" ".join(words[1:]), [])
            elif words[0].lower() == "vertex":
                corners.append([float(each) for each in words[1:4]])
    surfaces, mended = {}, []
    for name, rows in solids.items():
        if not rows:
            continue
        vertices = np.array(rows, np.float64) * scale
        faces: Int64Array = np.arange(len(vertices), dtype=np.int64).reshape(-1, 3)
        try:
            surfaces[name], said = clean_surface(vertices, faces)
        except GeometryError as error:
            raise GeometryError(f"{place}: {path.name}: solid {name or 'without a name'}: {error}") from error
        mended += [f"solid {name}: {sentence}" for sentence in said]
    return NamedSurfaces(surfaces, tuple(surfaces), tuple(mended))


def listed(names: Sequence[str]) -> str:
    """Return the names of solids for a message."""
    known = [name for name in names if name]
    shown = ", ".join(known[:NAMED_MAX]) or "none with a name"
    return f"{shown} and {len(known) - NAMED_MAX} more" if len(known) > NAMED_MAX else shown
