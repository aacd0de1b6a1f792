"""ESyS-Particle: ``bed.geo``, GenGeo's LSMGeometry 1.2; YADE reads it too (``ymport.gengeoFile``).

Reference: ESyS-Particle tutorial, section on GenGeo files: the head, ``BeginParticles``, ``Simple``, the
number of spheres, a line a sphere ``x y z radius id tag``, and no bonds. The tag is the number of the
particle set.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "esys"
NEEDS = ("walls",)
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.geo`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    bounds = " ".join(repr(each) for each in bed.container.bounds.ravel().tolist())
    periodic = " ".join(str(int(each)) for each in bed.container.periodic)
    head = (
        f"LSMGeometry 1.2\nBoundingBox {bounds}\nPeriodicBoundaries {periodic}\nDimension 3D\n"
        f"BeginParticles\nSimple\n{bed.count}\n"
    )
    foot = "EndParticles\nBeginConnect\n0\nEndConnect\n"
    columns = [*bed.position.T, bed.radius, table.ids(bed, start=0), bed.set_index]
    return [table.write_rows(folder / "bed.geo", columns, head=head, foot=foot)]
