"""CSV: ``bed.csv``, a line a sphere, the names of the columns in the first one; SI units.

Columns: ``id`` (index in the bed plus one), ``x``, ``y``, ``z``, ``radius`` [m], ``density`` [kg/m3],
``set``, ``zone`` and ``batch`` (from 0). pandas, R, spreadsheets, ParaView ("Table to Points") and OVITO read
it.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "csv"
NEEDS = ("density",)
COLUMNS = ("id", "x", "y", "z", "radius", "density", "set", "zone", "batch")
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.csv`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    columns = [
        table.ids(bed), *bed.position.T, bed.radius, bed.density,
        bed.set_index, bed.zone_index, bed.batch_index,
    ]  # fmt: skip
    head = ",".join(COLUMNS) + "\n"
    return [table.write_rows(folder / "bed.csv", columns, head=head, separator=",")]
