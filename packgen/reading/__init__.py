"""Beds from elsewhere: a module a format, and what makes a bed of a file's spheres.

A reader gives back what was written, to the format's digits. It says what the file says and nothing more:
density, materials and walls that are not in it are left open, or come from a scene.
"""

from __future__ import annotations

from packgen.reading.bed import complete_bed, read_bed, refuse_unknown, unknowns
from packgen.reading.detect import read_spheres, refuse_no_file
from packgen.reading.pieces import read_pieces
from packgen.reading.plausible import rounding_remark
from packgen.reading.spheres import SphereFile

__all__ = [
    "SphereFile", "complete_bed", "read_bed", "read_pieces", "read_spheres", "refuse_no_file",
    "refuse_unknown", "rounding_remark", "unknowns",
]  # fmt: skip
