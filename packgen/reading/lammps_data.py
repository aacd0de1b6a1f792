"""Data files of LIGGGHTS and LAMMPS (``read_data``, ``write_data``) whose atoms have a size.

Reference: LAMMPS manual, page "read_data": atom style sphere has rows ``id type diameter density x y z``, a
hybrid of sphere (or granular) and molecular ``id type x y z diameter density molecule``, bpm/sphere ``id
molecule type diameter density x y z``, whose molecules are no rigid bodies; all may end with three image
flags. The file's box is the solver's, wider than the bed, and says nothing of walls; one with a line of tilts
is a periodic cell, whose corner is the origin here.
"""

from __future__ import annotations

import re

import numpy as np

from packgen.arrays import Float64Array
from packgen.filefaults import fault
from packgen.reading.rows import NUMBER, SIZE, WHOLE, Column, Rows, read_columns
from packgen.reading.spheres import Cell, SphereFile, from_columns
from packgen.reading.text import Text
from packgen.reading.tilted import cell_of, tilted_vectors

KIND = "data file of LIGGGHTS or LAMMPS"
SECTION = re.compile(rb"^[ \t]*Atoms[ \t]*(#[^\n]*)?\r?$", re.MULTILINE)
NEXT = re.compile(rb"^[ \t]*[A-Za-z]", re.MULTILINE)
COUNT = re.compile(rb"^[ \t]*(\d+)[ \t]+atoms\b", re.MULTILINE)
TILT = re.compile(r"^(.*)\bxy[ \t]+xz[ \t]+yz\b", re.MULTILINE)
HEAD = 20_000  # bytes in which the head of a data file ends
SPHERE = ("id", "type", "diameter", "density", "x", "y", "z")
HYBRID = ("id", "type", "x", "y", "z", "diameter", "density", "molecule")
BONDED = ("id", "grain", "type", "diameter", "density", "x", "y", "z")
BONDED_STYLE = "bpm/sphere"
IMAGE_FLAGS = 3
RULES = {"id": WHOLE, "type": WHOLE, "molecule": WHOLE, "diameter": SIZE, "density": SIZE}


def is_data(data: bytes) -> bool:
    """Return whether a file has the head of a data file."""
    return COUNT.search(data[:HEAD]) is not None


def read_data(text: Text) -> SphereFile:
    """Read a data file.

    Raises:
        ReadError: It is not what a data file is, or its atoms have no size.
    """
    announced = COUNT.search(text.data[:HEAD])
    section = SECTION.search(text.data)
    if announced is None or section is None:
        raise fault(text.path, "no section Atoms", "one, with a row a sphere", remedy="is the file complete?")
    after = NEXT.search(text.data, section.end())
    rows = text.rows(section.end(), after.start() if after else None)
    names = _style(text, rows, text.line_at(section.start()), (section[1] or b"").decode("ascii", "replace"))
    columns = [Column(name, place, RULES.get(name, NUMBER)) for place, name in enumerate(names)]
    found = read_columns(rows, columns, width=len(names), count=int(announced[1]))
    if "molecule" in found:
        molecule = found.pop("molecule")
        # Molecule 0 is none: each such sphere is a body of its own.
        loose = molecule <= 0
        molecule[loose] = molecule.max(initial=0) + 1 + np.arange(np.count_nonzero(loose))
        found["body"] = molecule
    cell, low = _cell(text)
    for axis, name in enumerate("xyz"):
        found[name] = found[name] - low[axis]
    return from_columns(text.path, KIND, found, cell=cell)


def _cell(text: Text) -> tuple[Cell | None, Float64Array]:
    """Return the periodic cell of a box with tilts, and its corner [m], shape (3,); None: it has no tilts.

    Raises:
        ReadError: The box has a line of tilts and no bounds, or some that are none.
    """
    head = text.data[:HEAD].decode("ascii", "replace")
    tilt = TILT.search(head)
    if tilt is None:
        return None, np.zeros(3)
    lines = [re.search(rf"^(.*)\b{axis}lo[ \t]+{axis}hi\b", head, re.MULTILINE) for axis in "xyz"]
    try:
        bounds = np.array([[float(word) for word in line[1].split()] for line in lines if line], float)
        tilts = np.array([float(word) for word in tilt[1].split()])
        if bounds.shape != (3, 2) or tilts.shape != (3,) or not np.isfinite([*bounds.flat, *tilts]).all():
            raise ValueError
        if not (bounds[:, 0] < bounds[:, 1]).all():
            raise ValueError
    except ValueError:
        raise fault(
            text.path, "a tilted box without sound bounds", "lines xlo xhi, ylo yhi, zlo zhi and xy xz yz",
            place=text.line_at(tilt.start()),
        ) from None  # fmt: skip
    return cell_of(tilted_vectors(bounds[:, 1] - bounds[:, 0], tilts)), bounds[:, 0]


def _style(text: Text, rows: Rows, line: int, hint: str) -> tuple[str, ...]:
    """Return the columns of the rows, by the style that the file names, else by how many there are."""
    width = len(rows.first())
    named = hint.lstrip("# ").split()
    for names in (SPHERE, HYBRID, BONDED):
        fits = width in {len(names), len(names) + IMAGE_FLAGS}
        if fits and _is_named(names, named):
            return names
    if width == 0:
        raise fault(text.path, "no rows", "a row a sphere", place=line, remedy="is the file complete?")
    style = f"Atoms {hint.strip()}" if hint else "Atoms"
    raise fault(
        text.path,
        f"{style} with {width} columns",
        f"those of atom style sphere ({' '.join(SPHERE)})",
        place=line,
    )


def _is_named(names: tuple[str, ...], named: list[str]) -> bool:
    """Return whether columns are those of the style that a file names, if it names one."""
    styles = {SPHERE: ("sphere", "granular"), HYBRID: ("hybrid",), BONDED: (BONDED_STYLE,)}[names]
    return named[0] in styles if named else names is not BONDED
