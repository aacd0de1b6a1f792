"""LAMMPS, bonded particles (package BPM): ``bed.data`` with ``Bonds``, and ``in.bed`` with ``bond_coeff``.

The bonds are the pairs of spheres whose gap is at most ``gap``. ``bed.data`` is of the atom style bpm/sphere:
rows ``id molecule type diameter density x y z``, all of molecule 1, and a section ``Bonds`` of one bond type,
``number type id id``; LAMMPS takes the lengths at the start of the first run for those of bonds at rest. How
stiff and strong bonds are no scene says: ``in.bed`` is written where ``bond_coeff`` says it.

Reference: LAMMPS manual, pages "Howto bpm", "bond_style bpm/rotational", "atom_style", "read_data". Debian's
LAMMPS of 2021 lacks the package.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import Field, field_validator

from exporters import lammps
from exporters.protocol import Outlook
from exporters.shared import deck, lammps_data, table
from exporters.shared.bonds import GAP, Bonds, find_bonds, refuse_narrow_box
from exporters.shared.contact import Types
from packgen.bed import Bed

NAME = "bpm"
IS_DECK = True
COEFFICIENTS = "Kr Ks Kt Kb fcr fcs tct tcb gn gs gr gt"


class Options(lammps.Options):
    """Options of a bonded bed.

    Attributes:
        gap: Largest gap of two spheres that are bonded, as a fraction of the smaller radius.
        bond_coeff: The twelve numbers of ``bond_coeff`` for bpm/rotational: Kr Ks Kt Kb fcr fcs tct tcb gn gs
            gr gt; None: no ``in.bed`` is written.
    """

    gap: float = Field(default=GAP, ge=0, allow_inf_nan=False)
    bond_coeff: str | None = None

    @field_validator("bond_coeff")
    @classmethod
    def _twelve_numbers(cls, value: str | None) -> str | None:
        if value is None:
            return None
        try:
            numbers = [float(word) for word in value.split()]
        except ValueError:
            numbers = []
        if len(numbers) != len(COEFFICIENTS.split()) or not np.isfinite(numbers).all() or min(numbers) < 0:
            raise ValueError(f"expected twelve numbers, none below 0: {COEFFICIENTS}")
        return " ".join(map(repr, numbers))


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the files of a bed into an existing folder and return their paths.

    Raises:
        ExportError: LAMMPS cannot take the bed: it is empty, a material is outside the limits, the container
            is not convex, or its box is narrower than two bonds.
    """
    deck.check_exportable(bed, NAME)
    types, box, values = lammps.deck_values(bed, options, NAME)
    bonds = find_bonds(bed, options.gap, NAME)
    paths = [_write_data(bed, folder / "bed.data", types, box, bonds)]
    if options.bond_coeff is not None:
        # Ghosts have to reach as far as a bond that is stretched.
        longest = max(2 * values["radius_max"], float(bonds.distance.max(initial=0.0)))
        values |= {"bond_coeff": options.bond_coeff, "bond_reach": 2 * longest}
        text = deck.render("lammps/in.bed.j2", values, options.templates)
        paths.append(deck.write_text(folder / "in.bed", text))
    return paths


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a scene whose beds LAMMPS cannot take.

    Raises:
        ExportError: As of the exporter ``lammps``, or the box is narrower than two bonds.
    """
    lammps.check_outlook(outlook, options)
    with outlook.placed("container"):
        refuse_narrow_box(outlook.container, outlook.radius_min, options.gap, NAME)


def _write_data(bed: Bed, path: Path, types: Types, box: lammps_data.Float64Array, bonds: Bonds) -> Path:
    counts = [f"{len(bonds.first)} bonds", "1 bond types"]
    head = lammps_data.data_head(bed, types, box, counts, "Atoms # bpm/sphere")
    molecule, sphere_type = table.constant(bed, 1), np.array(types.by_set)[bed.set_index]
    columns = [table.ids(bed), molecule, sphere_type, 2 * bed.radius, bed.density, *bed.position.T]
    table.write_rows(path, columns, head=head)
    if len(bonds.first):
        rows = [
            np.arange(1, len(bonds.first) + 1),
            np.ones_like(bonds.first),
            bonds.first + 1,
            bonds.second + 1,
        ]
        table.write_rows(path, rows, head="\nBonds\n\n", append=True)
    return path
