"""Beds in files: written by the exporters, and by hand."""

from __future__ import annotations

import exporters
from packgen.bedfile import save_bed
from packgen.reading import read_spheres
from tests.exporters.test_vtk import mixed_bed

WRITTEN = {
    "npz": "bed.npz", "csv": "bed.csv", "liggghts": "bed.data", "lammps": "bed.data", "yade": "bed.txt",
    "vtk": "bed.vtp", "vtu": "bed.vtu", "extxyz": "bed.xyz", "mfix": "particle_input.dat",
    "chrono": "bed.csv", "geotaichi": "bed_0.txt", "bpm": "bed.data",
}  # fmt: skip
"""What each format's file of spheres is called."""


def write(bed, name, folder):
    """Write a bed in a format, and return its file of spheres."""
    if name == "npz":
        save_bed(bed, folder / WRITTEN[name])
    else:
        exporter = exporters.get("vtk" if name == "vtu" else name)
        options = exporter.Options(unstructured=True) if name == "vtu" else exporter.Options()
        exporter.write(bed, folder, options)
    return folder / WRITTEN[name]


def text_file(folder, text, name="spheres.txt"):
    path = folder / name
    path.write_text(text)
    return path


def dump_text(
    rows, columns="id type x y z radius", *, step=0, count=None, flags="ff ff ff", box=((0, 3),) * 3
):
    """A frame of a LIGGGHTS or LAMMPS dump."""
    bounds = "".join(" ".join(map(str, row)) + "\n" for row in box)
    lines = "".join(" ".join(map(repr, row)) + " \n" for row in rows)
    return (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows) if count is None else count}\n"
        f"ITEM: BOX BOUNDS {flags}\n{bounds}ITEM: ATOMS {columns} \n{lines}"
    )


__all__ = ["WRITTEN", "dump_text", "mixed_bed", "read_spheres", "text_file", "write"]
