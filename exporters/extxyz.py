"""Extended XYZ: ``bed.xyz``, for OVITO and ASE.

Reference: OVITO manual, page "XYZ file reader", and ASE, page "extxyz": the number of spheres, a line with
``Lattice``, ``Origin``, ``pbc`` and ``Properties``, and a row a sphere. The species is the name of the
particle set, the lattice the container's box; OVITO takes ``radius`` for the size.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exporters.shared import deck, table
from packgen.bed import AnyBed, Bed, numbered

NAME = "extxyz"
NEEDS: tuple[str, ...] = ()
STREAMS = True
CELLS = True
Options = table.NoOptions


def write(bed: AnyBed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.xyz`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    used = zip(bed.particle_sets, bed.census.counts, strict=True)
    known = all(np.isfinite(each.density) for each, count in used if count)
    properties = "species:S:1:pos:R:3:radius:R:1:id:I:1:set:I:1:zone:I:1:batch:I:1"
    properties += ":density:R:1" if known else ""
    low, high = bed.container.bounds
    vectors = np.diag(high - low)
    if bed.container.cell is not None:
        low, vectors = np.zeros(3), bed.container.cell
    lattice = " ".join(map(repr, vectors.ravel().tolist()))
    origin = " ".join(map(repr, low.tolist()))
    periodic = " ".join("T" if wraps else "F" for wraps in bed.container.periodic)
    told = deck.provenance_values(bed)
    head = (
        f'{bed.count}\nLattice="{lattice}" Origin="{origin}" pbc="{periodic}" Properties={properties}'
        f' packgen="{told["version"]}" scene="{told["scene"]}" seed="{told["seed"]}"\n'
    )
    parts = (_columns(chunk, start + 1, known=known) for start, chunk in numbered(bed))
    return [table.write_parts(folder / "bed.xyz", parts, head=head)]


def _columns(bed: Bed, first: int, *, known: bool) -> list[NDArray[Any]]:
    """Return the columns of spheres that are numbered from some id on, densities where they are known."""
    columns: list[NDArray[Any]] = [
        np.array([_species(each.name) for each in bed.particle_sets])[bed.set_index],
        *bed.position.T, bed.radius, table.ids(bed, start=first), bed.set_index, bed.zone_index,
        bed.batch_index,
    ]  # fmt: skip
    return [*columns, bed.density] if known else columns


def _species(name: str) -> str:
    """Return a set's name as a word that no reader takes apart."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", name)
