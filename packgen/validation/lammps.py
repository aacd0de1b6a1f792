"""LAMMPS as a judge; see ``lammps_family``. It lists contacts of pairs; walls are told from what is left."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.geometry import Polyhedron
from packgen.validation.contacts import Contacts
from packgen.validation.convex_walls import convex_contacts
from packgen.validation.dump import read_dump
from packgen.validation.lammps_family import Dialect, FirstForces
from packgen.validation.lammps_family import measure as measure_family

# Planes that cost as much as the rest of a step. Measured with 2,000 spheres in drums of 8 to 290 planes: a
# step takes 0.13 + 0.014 P microseconds a sphere, LIGGGHTS' 0.11.
PLANES_AS_A_STEP = 9
# Without "cutoff radius" in both, the two computes list different pairs.
CONTACTS = """\
compute packgen_ids all property/local patom1 patom2 cutoff radius
compute packgen_pairs all pair/local dist fx fy fz cutoff radius
dump packgen_pairs all local 1 packgen_pairs.dump c_packgen_ids[1] c_packgen_ids[2] &
  c_packgen_pairs[1] c_packgen_pairs[2] c_packgen_pairs[3] c_packgen_pairs[4]
dump_modify packgen_pairs format line "%.0f %.0f %.17g %.17g %.17g %.17g"
"""


def budget_share(bed: Bed) -> float:
    """Return the share of the work budget: LAMMPS asks every plane of a polyhedron for every sphere."""
    shape = bed.container.shape
    return 1 / (1 + len(shape.offset) / PLANES_AS_A_STEP) if isinstance(shape, Polyhedron) else 1.0


def _contact_input(_deck: str) -> str:
    return CONTACTS


def _read_contacts(bed: Bed, folder: Path, contact_force: Float64Array, unit: float) -> FirstForces:
    assert unit == 1.0, "LAMMPS has no meshes: its decks are in metres"
    rows = read_dump(folder / "packgen_pairs.dump", 6)
    first, second = rows[:, 0].astype(np.int64) - 1, rows[:, 1].astype(np.int64) - 1
    overlap = bed.radius[first] + bed.radius[second] - rows[:, 2]
    pairs = Contacts(first, second, np.linalg.norm(rows[:, 3:6], axis=1), overlap)
    wall_force = contact_force.copy()
    np.subtract.at(wall_force, first, rows[:, 3:6])
    np.add.at(wall_force, second, rows[:, 3:6])
    return pairs, *convex_contacts(bed, wall_force)


DIALECT = Dialect(
    name="lammps",
    format_word="line ",
    version=r"LAMMPS \([^)]*\)",
    contact_input=_contact_input,
    read_contacts=_read_contacts,
    budget_share=budget_share,
    weighs_members=False,
)
measure = partial(measure_family, DIALECT)
