"""Kratos DEMApplication: ``bedDEM.mdpa``, spheres as ``SphericParticle3D`` of one part a particle set.

Reference: Kratos wiki, "Input data" (mdpa format): blocks of nodes, elements, nodal data and submodel parts,
numbered from 1. ``MaterialsDEM.json`` of the case gives each part ``DEMParts_<n>`` its material.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exporters.shared import deck, table
from packgen.bed import Bed

NAME = "kratos"
NEEDS: tuple[str, ...] = ()
Options = table.NoOptions


def write(bed: Bed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bedDEM.mdpa`` into an existing folder and return its path.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    path = folder / "bedDEM.mdpa"
    ids, zero = table.ids(bed), table.constant(bed, 0)
    head = "Begin ModelPartData\nEnd ModelPartData\n\nBegin Properties 0\nEnd Properties\n\nBegin Nodes\n"
    table.write_rows(path, [ids, *bed.position.T], head=head, foot="End Nodes\n\n")
    head = "Begin Elements SphericParticle3D\n"
    table.write_rows(path, [ids, zero, ids], head=head, foot="End Elements\n\n", append=True)
    head = "Begin NodalData RADIUS\n"
    table.write_rows(path, [ids, zero, bed.radius], head=head, foot="End NodalData\n\n", append=True)
    for index in range(len(bed.particle_sets)):
        members = np.flatnonzero(bed.set_index == index) + 1
        head = f"Begin SubModelPart DEMParts_{index}\nBegin SubModelPartNodes\n"
        table.write_rows(path, [members], head=head, foot="End SubModelPartNodes\n", append=True)
        foot = "End SubModelPartElements\nEnd SubModelPart\n\n"
        table.write_rows(path, [members], head="Begin SubModelPartElements\n", foot=foot, append=True)
    return [path]
