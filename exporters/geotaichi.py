"""GeoTaichi: ``bed.txt`` with the columns x y z radius [m], one file a particle set.

Reference: GeoTaichi source, ``generator/LoadFromFile.py``: numpy.loadtxt, ``#`` starts a comment. A body of
spheres has one material, so a bed of several sets becomes ``bed_0.txt``, ``bed_1.txt`` and so on.
"""

from __future__ import annotations

from pathlib import Path

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "geotaichi"
NEEDS = ("density",)
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write the files into an existing folder and return their paths.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    paths = []
    for index, each in enumerate(bed.particle_sets):
        chosen = slice(None) if len(bed.particle_sets) == 1 else bed.set_index == index
        columns = [*bed.position[chosen].T, bed.radius[chosen]]
        if len(columns[0]) == 0:
            continue
        name = "bed.txt" if len(bed.particle_sets) == 1 else f"bed_{index}.txt"
        head = f"# {deck.comment_text(each.name)}, {each.density!r} kg/m3: x y z radius\n"
        paths.append(table.write_rows(folder / name, columns, head=head))
    return paths
