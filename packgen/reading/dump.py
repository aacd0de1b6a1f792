"""Text dumps of LIGGGHTS and LAMMPS (``dump custom``), of one step or of many.

Reference: LAMMPS manual, page "dump": ``ITEM:`` lines, and a row a sphere whose columns the last of them
names. Positions are ``x y z``, unwrapped (``xu``) or scaled by the box (``xs``, ``xsu``). A tilted box that
wraps around along x, y and z is a periodic cell, whose corner is the origin here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from packgen.arrays import Float64Array
from packgen.filefaults import fault, shown
from packgen.portable import matrix_product
from packgen.reading.plausible import refuse_named_units
from packgen.reading.rows import NUMBER, SIZE, WHOLE, Column, digits_of, read_columns
from packgen.reading.spheres import Cell, SphereFile, from_columns
from packgen.reading.steps import place_of_step
from packgen.reading.text import Text, decoded
from packgen.reading.tilted import cell_of, inside_bounds, tilted_vectors

START = b"ITEM: TIMESTEP"
KIND = "dump of LIGGGHTS or LAMMPS"
EARLIER = "is it complete? --step N reads an earlier one"
STYLE = re.compile(rb"\s*ITEM: UNITS\s+(\w+)")
LENGTH_OF_STYLE = MappingProxyType({b"si": "m", b"cgs": "cm", b"micro": "um"})
POSITIONS = ("{}", "{}u", "{}s", "{}su")
SCALED = POSITIONS[2:]
TILTS = ("xy", "xz", "yz")


@dataclass(frozen=True, slots=True)
class Head:
    """What stands before the rows of a step: its items by name, the columns, and where the rows begin."""

    items: dict[str, list[str]]
    columns: list[str]
    start: int

    @property
    def count(self) -> str:
        """How many rows it announces, as it stands there."""
        name = next((each for each in ("NUMBER OF ATOMS", "NUMBER OF ENTRIES") if each in self.items), "")
        return (self.items.get(name) or [""])[0]


def read_dump(text: Text, step: int | None, units: str | None = None) -> SphereFile:
    """Read a step of a dump; the last one where none is named.

    Args:
        text: The file.
        step: Which step; None: the last one.
        units: Unit of its lengths, which are not converted here; None: metres.

    Raises:
        ReadError: It is not what a dump is, or has no radii, or names another unit.
    """
    starts = _starts(text.data)
    if not starts:
        raise fault(text.path, "no line ITEM: TIMESTEP", "one at the start of each step", remedy=EARLIER)
    style = STYLE.match(text.data)
    if style is not None and style[1] in LENGTH_OF_STYLE:
        said = f"ITEM: UNITS {style[1].decode()}"
        refuse_named_units(text.path, {said: LENGTH_OF_STYLE[style[1]]}, units, line=1)
    steps = [_timestep(text, start) for start in starts]
    place = place_of_step(text.path, steps, step)
    stop = starts[place + 1] if place + 1 < len(starts) else len(text.data)
    head = head_of(text, starts[place], stop)
    columns = _columns(text, head)
    count = _count(text, head, starts[place])
    if not text.data.endswith(b"\n") and stop == len(text.data):
        raise fault(
            text.path, "a last line without an end", "whole lines", place=text.line_at(stop), remedy=EARLIER
        )
    # The items of the next step may stand before its time step, such as ITEM: TIME.
    after = text.data.find(b"\nITEM:", head.start, stop)
    rows = text.rows(head.start, stop if after < 0 else after + 1)
    found = read_columns(rows, columns, width=len(head.columns), count=count)
    low, cell, vectors = _box(text, head, starts[place])
    form = next(each for each in POSITIONS if each.format("x") in found)
    position = np.stack([found.pop(form.format(axis)) for axis in "xyz"], axis=1)
    if form in SCALED:
        position = low + matrix_product(position, vectors)
    if cell is not None and cell.vectors is not None:
        position = position - low
    found |= dict(zip("xyz", position.T, strict=True))
    return from_columns(text.path, KIND, found, cell=cell, digits=digits_of(rows, columns[:3]))


def _starts(data: bytes) -> list[int]:
    starts, place = [], data.find(START)
    while place >= 0:
        starts.append(place)
        place = data.find(START, place + len(START))
    return starts


def _timestep(text: Text, start: int) -> int | None:
    line = decoded(text.data[start : start + 200]).split("\n")[1:2]
    try:
        return int(line[0])
    except (IndexError, ValueError):
        return None


def head_of(text: Text, start: int, stop: int, *, pairs: bool = False) -> Head:
    """Return the items of a step, up to the one whose rows are its spheres.

    Args:
        text: The file.
        start: Byte at which the step begins.
        stop: Byte before which it ends.
        pairs: Whether the rows may be pairs or walls (``dump local``) instead.

    Raises:
        ReadError: There is no such item.
    """
    items: dict[str, list[str]] = {}
    name, place = "", start
    while place < stop:
        end = text.data.find(b"\n", place, stop)
        end = stop if end < 0 else end
        line = decoded(text.data[place:end]).strip()
        place = end + 1
        if line.startswith("ITEM: ENTRIES") and not pairs:
            raise fault(
                text.path,
                "a dump of pairs or walls",
                "one of spheres, ITEM: ATOMS",
                place=text.line_at(end - 1),
            )
        if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
            return Head(items, line.split()[2:], place)
        if line.startswith("ITEM:"):
            name = line.removeprefix("ITEM:").strip()
            items[name] = []
        elif name:
            items[name].append(line)
    raise fault(
        text.path,
        "no line ITEM: ATOMS",
        "one that names the columns",
        place=text.line_at(start),
        remedy=EARLIER,
    )


def _columns(text: Text, head: Head) -> list[Column]:
    """Return the columns to read: positions in one of their forms, a size, and what else is known."""
    names, line = head.columns, text.line_at(head.start) - 1
    there = ", ".join(names) or "nothing"
    form = next((each for each in POSITIONS if all(each.format(axis) in names for axis in "xyz")), None)
    if form is None:
        raise fault(text.path, f"the columns {there}", "x y z, xu yu zu or xs ys zs as well", place=line)
    size = next((each for each in ("radius", "diameter") if each in names), None)
    if size is None:
        raise fault(
            text.path, f"the columns {there}", "radius or diameter as well", place=line,
            remedy="add radius to the columns of the dump command",
        )  # fmt: skip
    wanted = {form.format(axis): NUMBER for axis in "xyz"} | {size: SIZE}
    wanted |= {"id": WHOLE, "type": WHOLE, "density": SIZE}
    return [Column(name, names.index(name), rule) for name, rule in wanted.items() if name in names]


def _count(text: Text, head: Head, start: int) -> int:
    value = head.count
    if not value.isdigit() or int(value) == 0:
        raise fault(
            text.path,
            f"the number of atoms {shown(value)}",
            "a whole number above 0",
            place=text.line_at(start),
        )
    return int(value)


def _box(text: Text, head: Head, start: int) -> tuple[Float64Array, Cell | None, Float64Array]:
    """Return the corner of the box [m], shape (3,), the cell that wraps around, and its edges, (3, 3)."""
    name = next((each for each in head.items if each.startswith("BOX BOUNDS")), "")
    words, line = name.split()[2:], text.line_at(start)
    if "abc" in words:  # LAMMPS's general triclinic box: three edges of any direction, and the origin
        raise fault(
            text.path, "a box of any three edges", "one whose first lies along x, its second in the plane of "
            "x and y", place=line, remedy="leave triclinic/general out of dump_modify",
        )  # fmt: skip
    try:
        bounds = np.array([[float(word) for word in row.split()] for row in head.items.get(name, [])])
        if bounds.shape not in {(3, 2), (3, 3)} or not np.isfinite(bounds).all():
            raise ValueError
        tilt = bounds[:, 2] if bounds.shape == (3, 3) else np.zeros(3)
        low, high = inside_bounds(bounds[:, :2].T, tilt)
        if not (low < high).all():
            raise ValueError
    except ValueError:
        raise fault(
            text.path,
            "box bounds that are none",
            "three lines of two numbers, the lower one first",
            place=line,
            remedy=EARLIER,
        ) from None
    flags = [word for word in words if len(word) == 2 and word not in TILTS]
    x, y, z = (flag == "pp" for flag in (flags if len(flags) == 3 else ["ff"] * 3))
    vectors = tilted_vectors(high - low, tilt)
    if not tilt.any():
        return low, Cell(np.stack([low, high]), (x, y, z)) if x or y or z else None, vectors
    if not (x and y and z):
        raise fault(
            text.path, "a tilted box with walls", "one that wraps around along x, y and z", place=line
        )
    return low, cell_of(vectors), vectors
