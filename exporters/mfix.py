"""MFiX: ``particle_input.dat``, version 2.0, for ``GENER_PART_CONFIG = .FALSE.``.

Reference: MFiX 21.3 source, ``model/des/read_particle_input.f``: 18 lines that are skipped, of which the
first names the version, dimension and number, 3 lines, 8 lines that say which columns there are (T) or the
value for all (F), 3 lines, and the columns from line 35 on; no line may be empty. The phase is the number of
the particle set plus one, so that ``D_p0`` and ``RO_s0`` of the case's phases come in that order.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "mfix"
NEEDS = ("density",)
FILE = "particle_input.dat"  # the name that MFiX looks for
Options = table.NoOptions

RULE = "=" * 80
INSTRUCTIONS = """\
Columns of this file, SI units:
 x y z           centre of a sphere
 phase           solids phase, from 1
 diameter        of a sphere, not the radius
 density         of a sphere
What is the same for all is given below after F.
The run has to be in three dimensions, its domain has to hold all spheres,
and the keyword gener_part_config has to be .FALSE.
Temperature, species and scalars are read only where the run has them.
Change their values below where they matter."""


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``particle_input.dat`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    told = deck.provenance_values(bed)
    lines = [
        "Version 2.0",
        RULE,
        f"Spheres by packgen {told['version']}, scene {told['scene']}, seed {told['seed']}",
        RULE,
        *INSTRUCTIONS.splitlines(),
    ]
    lines += [RULE] * (18 - len(lines))
    lines += [
        "Dimension: 3",
        f"Particles: {bed.count}",
        RULE,
        "Variable: read it from the columns (T) or not (F)",
        RULE,
    ]
    lines += ["Coordinates: T", "Phase_ID: T", "Diameter: T", "Density: T", "Velocity: F 0.0 0.0 0.0"]
    lines += ["Temperature: F 293.15", "Species: F 1.0", "User_Scalar: F 0.0"]
    lines += [RULE, "x y z phase diameter density", RULE]
    columns = [*bed.position.T, bed.set_index + 1, 2 * bed.radius, bed.density]
    return [table.write_rows(folder / FILE, columns, head="\n".join(lines) + "\n")]
