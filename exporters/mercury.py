"""MercuryDPM: ``bed.data``, format 14, which ``readDataFile("bed.data", 14)`` loads.

Reference: MercuryDPM source, ``DPMBase::readNextDataFile``: a line ``N time xmin ymin zmin xmax ymax zmax``,
then a line a sphere, ``x y z vx vy vz radius  a b c  wx wy wz  info``: position, velocity, radius, rotation,
angular velocity, and the index of the species, which is that of the particle set. Densities are the species'.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "mercury"
NEEDS = ("walls",)
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.data`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    zero = table.constant(bed, 0)
    columns = [*bed.position.T, *[zero] * 3, bed.radius, *[zero] * 6, bed.set_index]
    bounds = " ".join(repr(each) for each in bed.container.bounds.ravel().tolist())
    return [table.write_rows(folder / "bed.data", columns, head=f"{bed.count} 0 {bounds}\n")]
