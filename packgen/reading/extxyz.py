"""Extended XYZ, as OVITO, ASE and packgen write it: the last frame, or that of a named step.

A frame is the number of spheres, a line of ``key=value`` with ``Properties=name:kind:columns:...``, and a row
a sphere. Sizes are a property ``radius`` or ``diameter``; the kinds are S (text), R, I and L.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from packgen.arrays import Float64Array
from packgen.filefaults import Faults, fault, shown
from packgen.reading.rows import NUMBER, SIZE, WHOLE, Column, Rows, read_columns
from packgen.reading.spheres import Cell, Groups, SphereFile, from_columns
from packgen.reading.steps import place_of_step
from packgen.reading.text import Text, decoded
from packgen.reading.tilted import cell_of

KIND = "extended XYZ"
FIELD = re.compile(r"([A-Za-z_][\w-]*)\s*=\s*(\"[^\"]*\"|'[^']*'|\S+)")
POSITIONS = ("pos", "position")
RULES = MappingProxyType(
    {
        "radius": SIZE, "diameter": SIZE, "density": SIZE, "id": WHOLE, "type": WHOLE, "set": WHOLE,
        "zone": WHOLE, "batch": WHOLE, "body": WHOLE,
    }
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Frame:
    """A frame: number of spheres, the keys of its second line, that line's number, and where its rows are."""

    count: int
    keys: Mapping[str, str]
    line: int
    start: int
    stop: int


def is_extxyz(head: list[str]) -> bool:
    """Return whether the first lines of a file are those of an XYZ file, extended or not."""
    return bool(head) and head[0].strip().isdigit()


def read_extxyz(text: Text, step: int | None) -> SphereFile:
    """Read a frame.

    Raises:
        ReadError: It is not what extended XYZ is, or has no radii.
    """
    frames = list(_frames(text))
    steps = [_step(frame.keys) for frame in frames]
    frame = frames[place_of_step(text.path, steps, step)]
    names, width, species = _properties(text, frame)
    columns = [Column(name, place, RULES.get(name, NUMBER)) for name, place in names.items()]
    rows = text.rows(frame.start, frame.stop)
    found = read_columns(rows, columns, width=width, count=frame.count)
    known = {} if species is None or "set" in found else {"groups": _groups(rows, species, width)}
    return from_columns(text.path, KIND, found, cell=_cell(text, frame), **known)


def _frames(text: Text) -> Iterator[_Frame]:
    ends = np.flatnonzero(np.frombuffer(text.data, np.uint8) == ord("\n"))
    if not text.data.endswith(b"\n"):
        ends = np.append(ends, len(text.data))
    line = 0
    while line < len(ends):
        first = 0 if line == 0 else int(ends[line - 1]) + 1
        value = decoded(text.data[first : ends[line]]).strip()
        if not value and not text.data[first:].strip():
            return
        if not value.isdigit() or int(value) == 0:
            raise fault(
                text.path, shown(value), "the number of spheres, a whole number above 0", place=line + 1
            )
        count, last = int(value), min(line + 1 + int(value), len(ends) - 1)
        if line + 1 >= len(ends):
            raise fault(
                text.path, "nothing after the number of spheres", "a line with Properties=", place=line + 1
            )
        comment = decoded(text.data[int(ends[line]) + 1 : ends[line + 1]])
        keys = {name.lower(): found.strip("\"'") for name, found in FIELD.findall(comment)}
        yield _Frame(count, keys, line + 2, int(ends[line + 1]) + 1, int(ends[last]) + 1)
        line += 2 + count


def _step(keys: Mapping[str, str]) -> int | None:
    value = next((keys[name] for name in ("timestep", "step", "frame") if name in keys), "")
    return int(value) if value.isdigit() else None


def _properties(text: Text, frame: _Frame) -> tuple[dict[str, int], int, int | None]:
    """Return the places of the columns to read, how many there are, and that of the species."""
    words = frame.keys.get("properties", "").split(":")
    if len(words) % 3 or not all(each.isdigit() for each in words[2::3]):
        raise fault(
            text.path, shown(frame.keys["properties"]) if "properties" in frame.keys else "no Properties=",
            "Properties=species:S:1:pos:R:3:radius:R:1 or the like", place=frame.line,
        )  # fmt: skip
    places: dict[str, int] = {}
    species, place = None, 0
    for name, kind, count in zip(words[::3], words[1::3], words[2::3], strict=True):
        plain = name.lower()
        if plain in POSITIONS and count == "3":
            places |= {axis: place + index for index, axis in enumerate("xyz")}
        elif plain in RULES and kind in "RI" and count == "1":
            places[plain] = place
        elif plain == "species":
            species = place
        place += int(count)
    missing = [] if "x" in places else ["pos"]
    missing += [] if {"radius", "diameter"} & set(places) else ["radius or diameter"]
    if missing:
        there = ", ".join(words[::3])
        raise fault(text.path, f"the properties {there}", f"{', '.join(missing)} as well", place=frame.line)
    if "radius" in places:
        places.pop("diameter", None)
    return places, place, species


def _groups(rows: Rows, place: int, width: int) -> Groups:
    """Return the spheres' species as groups, named in the order in which they come.

    Args:
        rows: The rows.
        place: Column of the species, from 0.
        width: Values that a row should have.

    Raises:
        ReadError: A row has no species; one line a fault.
    """
    number: dict[str, int] = {}
    index, faults = [], Faults(rows.path)
    for line, row in enumerate(io.StringIO(rows.text), start=rows.line):
        cells = row.split("#", 1)[0].split(None, place + 1)
        if len(cells) > place:
            index.append(number.setdefault(cells[place], len(number)))
        elif cells:
            faults.add(f"{len(cells)} values", str(width), place=line)
    faults.check()
    return Groups(np.array(index, dtype=np.int64), "name", tuple(number))


def _cell(text: Text, frame: _Frame) -> Cell | None:
    """Return the box that wraps around; None where none does."""
    periodic = [word.upper() in {"T", "TRUE", "1"} for word in frame.keys.get("pbc", "").split()]
    if not any(periodic):
        return None
    lattice = _numbers(frame.keys.get("lattice", ""), 9)
    origin = _numbers(frame.keys.get("origin", "0 0 0"), 3)
    if lattice is None or origin is None or len(periodic) != 3:
        raise fault(text.path, "pbc without a lattice", 'Lattice="ax 0 0 0 by 0 0 0 cz"', place=frame.line)
    vectors = lattice.reshape(3, 3)
    size = np.diag(vectors)
    upright = (vectors == np.tril(vectors)).all() and (size > 0.0).all() and not origin.any()
    if all(periodic) and upright and (vectors != np.diag(size)).any():
        return cell_of(vectors)
    if (lattice.reshape(3, 3) != np.diag(size)).any():
        raise fault(
            text.path,
            "a lattice that is tilted",
            "one along x, y and z, or in LAMMPS' form from the origin",
            place=frame.line,
        )
    for axis, length, wraps in zip("xyz", size.tolist(), periodic, strict=True):
        if wraps and length <= 0.0:
            raise fault(
                text.path, f"a lattice of length {length:g} along {axis}",
                "a length greater than 0 where pbc is T", place=frame.line,
            )  # fmt: skip
    x, y, z = periodic
    return Cell(np.stack([origin, origin + size]), (x, y, z))


def _numbers(text: str, count: int) -> Float64Array | None:
    try:
        found = np.array([float(word) for word in text.split()])
    except ValueError:
        return None
    return found if found.shape == (count,) and np.isfinite(found).all() else None
