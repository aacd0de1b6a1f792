"""Template files: rows ``x y z r`` in metres, with the mass properties in ``#`` lines before them.

CLUMP, LIGGGHTS (``particletemplate/multisphere``) and Chrono's DEM-Engine read the rows. A ``.csv`` has
commas and the line ``x,y,z,r`` on top, as Chrono wants it, any other file has blanks, as LIGGGHTS wants it.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.bodies import MassProperties, Template
from packgen.clumps.template import template_of_spheres
from packgen.errors import ReadError
from packgen.filefaults import Faults

COLUMNS = ("x", "y", "z", "r")
SPHERES_MAX = 100_000
BYTES_MAX = 20_000_000
INERTIA = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
VOLUME_KEY, PLACE_KEY, INERTIA_KEY = "volume_m3", "centre_m", "inertia_m5"
LENGTHS_OF_KEYS = {VOLUME_KEY: 1, PLACE_KEY: 3, INERTIA_KEY: 6}


def template_text(template: Template, *, commas: bool) -> str:
    """Return a template as the text of a file.

    Args:
        template: The template.
        commas: Whether numbers are parted by commas below a line of column names; else by blanks.
    """
    moments, axes = template.properties.principal()
    tensor = [float(template.inertia[i, j]) for i, j in INERTIA]
    head = [
        f"packgen clump: {template.name}, {template.count} spheres, lengths in m",
        "rows: x y z r; origin: centre of mass of the body; axes: those of its mesh",
        f"{VOLUME_KEY}: {template.volume!r}",
        f"{PLACE_KEY}: {_numbers(template.place)}   (where the origin was in the file of the mesh)",
        f"{INERTIA_KEY}: {_numbers(tensor)}   (xx yy zz xy xz yz of density 1)",
        f"principal_moments_m5: {_numbers(moments)}",
        f"principal_axes: {_numbers(axes.T.ravel())}   (the three unit vectors, one after the other)",
    ]
    parted = "," if commas else " "
    lines = [parted.join(COLUMNS)] if commas else []
    lines += [f"# {line}" for line in head]
    lines += [parted.join(repr(float(each)) for each in row) for row in template.spheres]
    return "\n".join(lines) + "\n"


def _numbers(values: Float64Array | list[float]) -> str:
    return " ".join(repr(float(each)) for each in values)


def write_template(path: Path, template: Template) -> None:
    """Write a template: with commas where the file ends with ``.csv``, else with blanks."""
    path.write_text(template_text(template, commas=path.suffix.lower() == ".csv"), encoding="utf-8")


def read_template(path: Path) -> Template:
    """Read a template of packgen's, or any file of rows ``x y z r`` with ``#`` comments.

    Where no header has them the mass properties are those of the union of the spheres, each place counted
    once.

    Args:
        path: The file.

    Raises:
        ReadError: It cannot be read, or is no list of spheres.
    """
    if not path.is_file():
        raise ReadError(f"{path}: no such file, expected a clump: rows x y z r")
    if path.stat().st_size > BYTES_MAX:
        raise ReadError(
            f"{path}: found {path.stat().st_size / 1e6:,.0f} MB, expected the rows x y z r of one clump"
        )
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ReadError(f"{path}: cannot be read as text ({error}); expected rows x y z r") from error
    rows, said = _rows(lines, path)
    if not rows:
        raise ReadError(f"{path}: found no spheres, expected rows x y z r")
    if len(rows) > SPHERES_MAX:
        raise ReadError(f"{path}: found {len(rows):,} spheres, expected at most {SPHERES_MAX:,} of one clump")
    return _template(path, np.array(rows), said)


def _rows(lines: list[str], path: Path) -> tuple[list[list[float]], dict[str, list[float]]]:
    """Return the spheres and the mass properties of a file's lines.

    Raises:
        ReadError: Lines hold neither; see `Faults`.
    """
    rows: list[list[float]] = []
    said: dict[str, list[float]] = {}
    faults = Faults(path)
    for number, line in enumerate(lines, 1):
        row, _, comment = line.partition("#")
        _note(comment, said, faults, number)
        parts = row.replace(",", " ").replace(";", " ").split()
        if parts and (rows or tuple(each.lower() for each in parts[:4]) != COLUMNS):
            rows.append(_sphere(parts, faults, number))
    faults.check()
    return rows, said


def _sphere(parts: list[str], faults: Faults, number: int) -> list[float]:
    """Return the numbers of a row; where they are no sphere, add a fault."""
    found = repr(" ".join(parts))
    try:
        values = [float(each) for each in parts]
    except ValueError:
        faults.add(found, "four numbers x y z r", place=number)
        return []
    if len(values) != 4 or not all(map(math.isfinite, values)):
        faults.add(found, "four finite numbers x y z r", place=number)
    elif not values[3] > 0.0:
        faults.add(f"a radius of {values[3]:g}", "one above 0", place=number)
    return values


def _note(comment: str, said: dict[str, list[float]], faults: Faults, number: int) -> None:
    """Take a mass property out of a comment, where it has one; where its numbers are wrong, add a fault."""
    key, _, text = comment.strip().partition(":")
    if key not in LENGTHS_OF_KEYS:
        return
    try:
        values = [float(each) for each in text.partition("(")[0].split()]
    except ValueError:
        values = []
    if len(values) != LENGTHS_OF_KEYS[key] or not all(map(math.isfinite, values)):
        faults.add(repr(comment.strip()), f"{key} and {LENGTHS_OF_KEYS[key]} numbers", place=number)
    said[key] = values


def _template(path: Path, spheres: Float64Array, said: dict[str, list[float]]) -> Template:
    if VOLUME_KEY not in said or INERTIA_KEY not in said:
        return template_of_spheres(path.stem, spheres)
    inertia = np.empty((3, 3))
    for (i, j), value in zip(INERTIA, said[INERTIA_KEY], strict=True):
        inertia[i, j] = inertia[j, i] = value
    volume = said[VOLUME_KEY][0]
    if not volume > 0.0 or not MassProperties(volume, np.zeros(3), inertia).principal()[0][0] > 0.0:
        raise ReadError(
            f"{path}: found a volume of {volume:g} m3 and an inertia that no body has, expected more than 0; "
            "take their lines out to have them computed"
        )
    return Template(path.stem, spheres, volume, inertia, np.array(said.get(PLACE_KEY, [0.0, 0.0, 0.0])))
