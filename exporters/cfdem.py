"""CFDEMcoupling: the DEM half of a case, laid out as its tutorials are.

Reference: CFDEMcoupling-PUBLIC, tutorials ``cfdemSolverPiso/ErgunTestMPI``: ``DEM/in.liggghts_init`` makes
the bed and writes ``DEM/post/restart/liggghts.restart``; ``DEM/in.liggghts_run``, which the coupled solver
reads in ``CFD``, starts from that file. ``parDEMrun.sh`` runs the first. What a CFD half needs of the bed
beside it is the solid fraction (exporter ``fraction``).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import Field

from exporters import liggghts
from exporters.protocol import Outlook
from exporters.shared import deck, lengths
from packgen.bed import AnyBed
from packgen.errors import ExportError

NAME = "cfdem"
IS_DECK = True
STREAMS = True
TEMPLATES = {
    "DEM/in.liggghts_init": "cfdem/in.liggghts_init.j2",
    "DEM/in.liggghts_run": "cfdem/in.liggghts_run.j2",
    "parDEMrun.sh": "cfdem/parDEMrun.sh.j2",
}


class Options(liggghts.Options):
    """Options of a case: those of LIGGGHTS' deck, and the coupling.

    Attributes:
        couple_every: DEM steps from one exchange with CFD to the next.
    """

    couple_every: int = Field(default=100, ge=1)


def write(bed: AnyBed, folder: Path, options: Options) -> list[Path]:
    """Write the case's DEM half into an existing folder and return the paths of its files.

    Raises:
        ExportError: LIGGGHTS cannot take the bed, or only in another unit of length.
    """
    deck.check_exportable(bed, NAME)
    _check_size(bed, options)
    (folder / "DEM").mkdir(exist_ok=True)
    paths = liggghts.write(bed, folder / "DEM", options)
    values = liggghts.deck_values(bed, options) | {
        "wall_folder": "../DEM/",
        "couple_every": options.couple_every,
    }
    for name, template in TEMPLATES.items():
        paths.append(deck.write_text(folder / name, deck.render(template, values, options.templates)))
    (folder / "parDEMrun.sh").chmod(0o755)
    return paths


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a scene whose beds LIGGGHTS cannot take, or only in another unit of length.

    Raises:
        ExportError: LIGGGHTS refuses it, or the container is too small or too large.
    """
    with outlook.placed("container"):
        _check_size(outlook, options)
    liggghts.check_outlook(outlook, options)


def _check_size(bed: AnyBed | Outlook, options: Options) -> None:
    if liggghts.length_unit(bed, options) != 1.0:
        size = np.ptp(bed.container.bounds, axis=0).max()
        raise ExportError(
            f"cfdem: found a container of {size:.3g} m, expected {lengths.MESH_SIZE_MIN:g} to"
            f" {lengths.MESH_SIZE_MAX:g} m: LIGGGHTS' mesh walls want other units there, and CFD has metres;"
            " scale the scene, or take a box or an upright cylinder, whose walls are no mesh"
        )
