"""Beds from elsewhere: a module a format, and what makes a bed of a file's spheres.

A reader gives back what was written, to the format's digits. It says what the file says and nothing more:
density, materials and walls that are not in it are left open, or come from a scene.
"""

from __future__ import annotations

from packgen.reading.bed import bed_of, has_known_walls, read_bed, unknowns
from packgen.reading.detect import read_spheres
from packgen.reading.known import Known, known_by_provenance, known_by_scene
from packgen.reading.spheres import SphereFile

__all__ = [
    "Known", "SphereFile", "bed_of", "has_known_walls", "known_by_provenance", "known_by_scene", "read_bed",
    "read_spheres", "unknowns",
]  # fmt: skip
