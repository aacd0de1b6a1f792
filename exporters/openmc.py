"""OpenMC: ``spheres.csv`` in centimetres, and ``bed.py``, which makes a TRISO lattice of it.

``bed.py`` is a module for the case's own script: ``from bed import lattice`` and ``cell.fill =
lattice({"pellets": universe}, background)`` with a universe for each particle set and the material between
the spheres; nothing of materials is in it. Of a bed that wraps around, spheres that cross a seam are there on
both sides.

Reference: OpenMC documentation, ``openmc.model.TRISO`` and ``openmc.model.create_triso_lattice``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from exporters.protocol import Outlook
from exporters.shared import deck, table
from packgen.bed import Bed, with_owned_images

NAME = "openmc"
NEEDS: tuple[str, ...] = ()
CENTIMETRE = 0.01
CELL_DIAMETERS = 3.0  # size of the lattice's cells, in largest diameters


class Options(BaseModel):
    """Options of the files.

    Attributes:
        cell_diameters: Size of the lattice's cells, in largest diameters; at least 1.
        templates: The user's own templates; None: packgen's.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    cell_diameters: float = Field(default=CELL_DIAMETERS, ge=1)
    templates: Path | None = None


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the files into an existing folder and return their paths.

    Raises:
        ExportError: The bed is empty, a number in it is not finite, or a template is wrong.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    position, radius, owner = with_owned_images(bed)
    centre = position / CENTIMETRE
    columns = [*centre.T, radius / CENTIMETRE, bed.set_index[owner]]
    low, high = bed.container.bounds / CENTIMETRE
    cells = np.maximum(1, np.floor((high - low) / (options.cell_diameters * 200 * float(bed.radius.max()))))
    values = {
        **deck.provenance_values(bed),
        "count": bed.count,
        "images": len(owner) - bed.count,
        "sets": [deck.comment_text(each.name) for each in bed.particle_sets],
        "low": low.tolist(),
        "pitch": ((high - low) / cells).tolist(),
        "shape": [int(each) for each in cells],
    }
    return [
        table.write_rows(folder / "spheres.csv", columns, head="x,y,z,r,set\n", separator=","),
        deck.write_text(folder / "bed.py", deck.render("openmc/bed.py.j2", values, options.templates)),
    ]


def check_outlook(_outlook: Outlook, options: Options) -> None:
    """Refuse a folder of templates that does not exist.

    Raises:
        ExportError: It does not exist.
    """
    deck.check_templates(options.templates)
