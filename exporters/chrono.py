"""Chrono DEM-Engine: ``bed.csv`` with the columns X,Y,Z,r,family, that of its own sphere output.

Reference: DEM-Engine source, ``DEM/Structs.h`` and ``WriteSphereFile``. A sphere of each radius is a clump
type of its own there: read the file, ``LoadSphereType(mass, r, material)`` for each radius, and place it.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "chrono"
NEEDS: tuple[str, ...] = ()
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.csv`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    columns = [*bed.position.T, bed.radius, bed.set_index]
    return [table.write_rows(folder / "bed.csv", columns, head="X,Y,Z,r,family\n", separator=",")]
