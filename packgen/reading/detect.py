"""Which format a file has: by its ending where that is binary, else by what stands in it."""

from __future__ import annotations

from pathlib import Path

from packgen.errors import ReadError
from packgen.filefaults import fault
from packgen.reading import dump, extxyz, lammps_data, mfix, table
from packgen.reading.npz import read_npz
from packgen.reading.spheres import SphereFile
from packgen.reading.steps import refuse_step
from packgen.reading.text import read_text
from packgen.reading.vtk import read_vtk
from packgen.units import LENGTHS

VTK_SUFFIXES = (".vtp", ".vtu", ".vtk")


def read_spheres(path: Path, *, step: int | None = None, units: str | None = None) -> SphereFile:
    """Read the spheres of a file: ``bed.npz``, csv and text, LIGGGHTS, LAMMPS, YADE, VTK, XYZ, MFiX.

    Args:
        path: The file.
        step: Which step of a dump, or of an XYZ file; None: the last one.
        units: Unit of its lengths, a key of `packgen.units.LENGTHS`; None: metres. A file that names another
            one is refused. Densities are in kg/m3 all the same.

    Returns:
        What the file says; lengths in metres.

    Raises:
        ReadError: The file cannot be read, or is not what it claims; a line a fault.
    """
    refuse_no_file(path)
    try:
        return _read(path, step, units).scaled(LENGTHS[units or "m"])
    except OSError as error:
        reason = error.strerror or str(error)
        raise ReadError(f"{path}: cannot be read: {reason}; expected a file of spheres") from error
    except MemoryError as error:
        raise ReadError(f"{path}: needs more memory than there is") from error


def refuse_no_file(path: Path) -> None:
    """Refuse a path at which there is no file.

    Raises:
        ReadError: There is nothing, or a directory.
    """
    if path.is_dir():
        inside = path / "bed.npz"
        remedy = f"name a file in it, such as {inside}" if inside.exists() else "name a file in it"
        raise fault(path, "a directory", "a file of spheres", remedy=remedy)
    if not path.exists():
        raise fault(path, "no such file", "a file of spheres")


def _read(path: Path, step: int | None, units: str | None) -> SphereFile:
    suffix = path.suffix.lower()
    if suffix == ".npz" or suffix in VTK_SUFFIXES:
        refuse_step(path, f"{suffix[1:]} file", step)
        return read_npz(path) if suffix == ".npz" else read_vtk(path)
    text = read_text(path)
    start = text.data.lstrip()[:100]
    if start.startswith(b"ITEM:"):
        return dump.read_dump(text, step, units)
    if extxyz.is_extxyz(text.head(2)):
        return extxyz.read_extxyz(text, step)
    refuse_step(path, "file of one state", step)
    if mfix.is_mfix(text.data):
        return mfix.read_mfix(text)
    if lammps_data.is_data(text.data):
        return lammps_data.read_data(text)
    return table.read_table(text, units)
