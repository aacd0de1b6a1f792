"""CSV: ``bed.csv``, a line a sphere, the names of the columns in the first one; SI units.

Columns: ``id`` (index in the bed plus one), ``x``, ``y``, ``z``, ``radius`` [m], ``density`` [kg/m3],
``set``, ``zone`` and ``batch`` (from 0), and ``body`` (from 0) where spheres belong to bodies. pandas, R,
spreadsheets, ParaView ("Table to Points") and OVITO read it. Where shape and place of the bodies are known,
``bodies.csv`` has a line for each: ``body``, ``template`` (its name, ``sphere`` of single ones), ``spheres``
(their number), ``scale``, centre of mass ``x``, ``y``, ``z`` [m], quaternion ``qw``, ``qx``, ``qy``, ``qz``,
``volume`` [m3] and ``mass`` [kg], overlaps counted once.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exporters.shared import deck, table
from exporters.shared.clumps import body_density, template_label
from packgen.bed import AnyBed, Bed, Bodies, numbered

NAME = "csv"
NEEDS = ("density",)
STREAMS = True
CELLS = True
CLUMPS = True
COLUMNS = ("id", "x", "y", "z", "radius", "density", "set", "zone", "batch")
OF_BODIES = (
    "body", "template", "spheres", "scale", "x", "y", "z", "qw", "qx", "qy", "qz", "volume", "mass",
)  # fmt: skip
Options = table.NoOptions


def write(bed: AnyBed, folder: Path, _options: Options) -> list[Path]:
    """Write ``bed.csv``, and ``bodies.csv`` where there are any, and return their paths.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS, clumps=True)
    parts = (
        [
            table.ids(chunk, start=start + 1), *chunk.position.T, chunk.radius, chunk.density,
            chunk.set_index, chunk.zone_index, chunk.batch_index,
            *([] if chunk.body_index is None else [chunk.body_index]),
        ]
        for start, chunk in numbered(bed)
    )  # fmt: skip
    joined = isinstance(bed, Bed) and bed.body_index is not None
    head = ",".join([*COLUMNS, *(["body"] if joined else [])]) + "\n"
    paths = [table.write_parts(folder / "bed.csv", parts, head=head, separator=",")]
    if isinstance(bed, Bed) and bed.bodies is not None:
        paths.append(_write_bodies(folder / "bodies.csv", bed, bed.bodies))
    return paths


def _write_bodies(path: Path, bed: Bed, bodies: Bodies) -> Path:
    names = np.array([*(template_label(bodies, number) for number in range(len(bodies.templates))), "sphere"])
    columns = [
        np.arange(len(bodies)), names[bodies.template_index], bodies.sphere_count, bodies.scale,
        *bodies.position.T, *bodies.orientation.T, bodies.volume, body_density(bed) * bodies.volume,
    ]  # fmt: skip
    return table.write_rows(path, columns, head=",".join(OF_BODIES) + "\n", separator=",")
