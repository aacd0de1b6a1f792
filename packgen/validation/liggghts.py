"""LIGGGHTS as a judge; see ``lammps_family``. It lists contacts of pairs and with the walls of one mesh."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.validation.contacts import Contacts, listed_error, primitive_contacts
from packgen.validation.dump import read_dump
from packgen.validation.lammps_family import Dialect, FirstForces
from packgen.validation.lammps_family import measure as measure_family

CONTACTS = """\
compute packgen_{kind} all {style} id force delta
dump packgen_{kind} all local 1 packgen_{kind}.dump {columns}
dump_modify packgen_{kind} format "%.0f %.0f %.0f %.15g %.15g %.15g %.15g"
"""


def _contact_input(deck: str) -> str:
    kinds = {"pairs": "pair/gran/local"}
    # The other compute knows mesh walls only, and stops LIGGGHTS where there are none.
    if re.search(r"^\s*fix\b.*\bwall/gran\b.*\bn_meshes\b", deck, re.MULTILINE):
        kinds["walls"] = "wall/gran/local"
    return "".join(
        CONTACTS.format(
            kind=kind, style=style, columns=" ".join(f"c_packgen_{kind}[{column}]" for column in range(1, 8))
        )
        for kind, style in kinds.items()
    )


def _read_contacts(bed: Bed, folder: Path, contact_force: Float64Array, unit: float) -> FirstForces:
    rows = _in_si(read_dump(folder / "packgen_pairs.dump", 7), unit)
    pairs = _contacts(rows, 0, 1)
    if (folder / "packgen_walls.dump").exists():
        listed = _in_si(read_dump(folder / "packgen_walls.dump", 7), unit)
        walls = _contacts(listed, 2, None)
        if bed.container.parts:
            # Meshes are numbered in the order of the deck: first the walls without a name, if there are any.
            first = int((bed.container.part_index < 0).any())
            walls = replace(walls, part=listed[:, 0].astype(np.int64) - first)
        return pairs, walls, listed_error(bed, walls)
    wall_force = contact_force.copy()
    for column, sign in ((0, 1.0), (1, -1.0)):
        np.subtract.at(wall_force, rows[:, column].astype(np.int64) - 1, sign * rows[:, 3:6])
    return pairs, *primitive_contacts(bed, wall_force)


def _in_si(rows: Float64Array, unit: float) -> Float64Array:
    """Return rows of three indices, a force and an overlap in newtons and metres, shape (C, 7)."""
    in_si: Float64Array = rows * np.array([1.0, 1.0, 1.0, *3 * [unit**2], unit])
    return in_si


def _contacts(rows: Float64Array, first: int, second: int | None) -> Contacts:
    return Contacts(
        first=rows[:, first].astype(np.int64) - 1,
        second=None if second is None else rows[:, second].astype(np.int64) - 1,
        force=np.linalg.norm(rows[:, 3:6], axis=1),
        overlap=rows[:, 6],
    )


DIALECT = Dialect(
    name="liggghts",
    format_word="",
    version=r"LIGGGHTS-\S+ [\d.]+",
    contact_input=_contact_input,
    read_contacts=_read_contacts,
)
measure = partial(measure_family, DIALECT)
