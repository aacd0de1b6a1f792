"""Bonds as CSV: ``bonds.csv``, a line a pair of spheres that touch or nearly do; SI units.

Columns: ``id_1`` and ``id_2`` (indices in the bed plus one, as in ``bed.csv`` and the decks; the smaller one
first), ``distance`` of the centres and ``gap`` of the surfaces [m], negative where they overlap. Spheres of
one clump are not bonded.
"""

from __future__ import annotations

from pathlib import Path

from exporters.protocol import Outlook
from exporters.shared import deck, table
from exporters.shared.bonds import BondOptions, find_bonds, refuse_narrow_box
from packgen.bed import Bed

NAME = "bonds"
NEEDS: tuple[str, ...] = ()
COLUMNS = ("id_1", "id_2", "distance", "gap")
Options = BondOptions


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write ``bonds.csv`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, a number in it is not finite, or its box is narrower than two bonds.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    bonds = find_bonds(bed, options.gap, NAME)
    columns = [bonds.first + 1, bonds.second + 1, bonds.distance, bonds.gap]
    return [table.write_rows(folder / "bonds.csv", columns, head=",".join(COLUMNS) + "\n", separator=",")]


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a box that is narrower than two bonds of the smallest spheres.

    Raises:
        ExportError: It is.
    """
    with outlook.placed("container"):
        refuse_narrow_box(outlook.container, outlook.radius_min, options.gap, NAME)
