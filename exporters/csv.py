"""CSV: ``bed.csv``, a line a sphere, the names of the columns in the first one; SI units.

Columns: ``id`` (index in the bed plus one), ``x``, ``y``, ``z``, ``radius`` [m], ``density`` [kg/m3],
``set``, ``zone`` and ``batch`` (from 0). pandas, R, spreadsheets, ParaView ("Table to Points") and OVITO read
it.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import AnyBed, numbered

NAME = "csv"
NEEDS = ("density",)
STREAMS = True
CELLS = True
COLUMNS = ("id", "x", "y", "z", "radius", "density", "set", "zone", "batch")
Options = table.NoOptions


def write(bed: AnyBed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.csv`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    parts = (
        [
            table.ids(chunk, start=start + 1), *chunk.position.T, chunk.radius, chunk.density,
            chunk.set_index, chunk.zone_index, chunk.batch_index,
        ]
        for start, chunk in numbered(bed)
    )  # fmt: skip
    head = ",".join(COLUMNS) + "\n"
    return [table.write_parts(folder / "bed.csv", parts, head=head, separator=",")]
