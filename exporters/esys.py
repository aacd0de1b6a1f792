"""ESyS-Particle: ``bed.geo``, GenGeo's LSMGeometry 1.2; YADE reads it too (``ymport.gengeoFile``).

Reference: ESyS-Particle tutorial, section on GenGeo files: the head, ``BeginParticles``, ``Simple``, the
number of spheres, a line a sphere ``x y z radius id tag``, and ``BeginConnect`` with a line a bond, ``id id
tag``. The tag of a sphere is the number of the particle set, that of a bond is 0; ids are from 0. Without
``gap`` there are no bonds.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from exporters.protocol import Outlook
from exporters.shared import deck, table
from exporters.shared.bonds import find_bonds, refuse_narrow_box
from packgen.bed import Bed

NAME = "esys"
NEEDS = ("walls",)


class Options(BaseModel):
    """Options of the file.

    Attributes:
        gap: Largest gap of two spheres that are bonded, as a fraction of the smaller radius; None: no bonds.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    gap: float | None = Field(default=None, ge=0)


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write ``bed.geo`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, a number in it is not finite, or its box is narrower than two bonds.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    bounds = " ".join(repr(each) for each in bed.container.bounds.ravel().tolist())
    periodic = " ".join(str(int(each)) for each in bed.container.periodic)
    head = (
        f"LSMGeometry 1.2\nBoundingBox {bounds}\nPeriodicBoundaries {periodic}\nDimension 3D\n"
        f"BeginParticles\nSimple\n{bed.count}\n"
    )
    path, columns = folder / "bed.geo", [*bed.position.T, bed.radius, table.ids(bed, start=0), bed.set_index]
    if options.gap is None:
        foot = "EndParticles\nBeginConnect\n0\nEndConnect\n"
        return [table.write_rows(path, columns, head=head, foot=foot)]
    bonds = find_bonds(bed, options.gap, NAME)
    table.write_rows(path, columns, head=head, foot="EndParticles\n")
    head = f"BeginConnect\n{len(bonds.first)}\n"
    columns = [bonds.first, bonds.second, np.zeros_like(bonds.first)]
    return [table.write_rows(path, columns, head=head, foot="EndConnect\n", append=True)]


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a box that is narrower than two bonds of the smallest spheres.

    Raises:
        ExportError: It is.
    """
    if options.gap is None:
        return
    with outlook.placed("container"):
        refuse_narrow_box(outlook.container, outlook.radius_min, options.gap, NAME)
