"""A lattice of spheres made by hand, and a reader of data files that shares no code with the exporters."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from packgen.bed import Bed
from packgen.geometry import Container, Surface
from tests.beds import box_container, make_bed

RADIUS = 2.5e-3
PROVENANCE = {"packgen": "0.1.0", "scene": "lattice.yaml", "seed": 7}


def open_at_the_top(container: Container) -> Container:
    """Return the container without the facets of its upper end."""
    surface = container.surface
    height = surface.vertices[:, 2]
    lid = (height[surface.faces] >= height.max()).all(axis=1)
    without = Surface(surface.vertices, surface.faces[~lid])
    return Container(container.name, container.shape, without, container.bounds, container.volume)


def lattice(
    counts: tuple[int, int, int] = (4, 4, 5), *, overlap: float = 0.0, lid: bool = True, **changes: Any
) -> Bed:
    """Return a cubic lattice of spheres in a box, overlapping each other and the walls by ``overlap`` r."""
    spacing = (2 - overlap) * RADIUS
    grid = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing="ij"), axis=-1).reshape(
        -1, 3
    )
    position = grid * spacing + (1 - overlap) * RADIUS
    high = (np.array(counts) - 1) * spacing + 2 * (1 - overlap) * RADIUS
    container = box_container(np.zeros(3), high)
    container = container if lid else open_at_the_top(container)
    return make_bed(position, RADIUS, container, **{"provenance": PROVENANCE, **changes})


def read_data_file(path: Path) -> tuple[dict[str, list[float]], np.ndarray]:
    """Read a LAMMPS data file as its manual has it: header values by keyword, and the rows of ``Atoms``."""
    head, rows = path.read_text(encoding="ascii").split("\nAtoms\n\n")
    header: dict[str, list[float]] = {}
    for line in head.splitlines()[1:]:
        words = line.split()
        numbers = [float(word) for word in words if word[0] in "-0123456789"]
        if words:
            header[" ".join(words[len(numbers) :])] = numbers
    return header, np.array([[float(word) for word in row.split()] for row in rows.splitlines()])
