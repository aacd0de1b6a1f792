"""MFiX: ``particle_input.dat``, version 2.0.

Reference: MFiX 21.3 source, ``model/des/read_particle_input.f``: lines that say which columns there are (T),
or the value for all spheres (F), three lines more, and the columns. The phase counts from 1.
"""

from __future__ import annotations

import numpy as np

from packgen.filefaults import fault, shown
from packgen.reading.rows import NUMBER, SIZE, WHOLE, Column, read_columns
from packgen.reading.spheres import SphereFile, from_columns
from packgen.reading.text import Text

KIND = "particle_input.dat of MFiX"
HEAD = 60  # lines in which the options end
LINES_AFTER = 3  # between the options and the rows
WIDTHS = {"Coordinates": 3, "Velocity": 3, "Quaternion": 4}
RULES = {"Phase_ID": WHOLE, "Diameter": SIZE, "Density": SIZE}


def is_mfix(data: bytes) -> bool:
    """Return whether a file begins as MFiX's."""
    return data.lstrip()[:7].lower() == b"version" and b"Particles:" in data[:20_000]


def read_mfix(text: Text) -> SphereFile:
    """Read ``particle_input.dat``.

    Raises:
        ReadError: It is not what that file is, or its spheres are glued together.
    """
    head = text.head(HEAD)
    if head[0].split()[1:2] != ["2.0"]:
        raise fault(
            text.path, shown(head[0]), "Version 2.0", place=1, remedy="write it anew with MFiX 21 or newer"
        )
    count = _count(text, head)
    options, end = _options(text, head)
    if options.get("Quaternion", ["F"])[0] == "T":
        raise fault(
            text.path, "glued spheres (Quaternion: T)", "single ones", remedy="leave the quaternions out"
        )
    columns, width = _columns(text, options)
    start = 0
    for _ in range(end + LINES_AFTER):
        start = text.data.find(b"\n", start) + 1
    found = read_columns(text.rows(start), columns, width=width, count=count)
    for name, key in (("diameter", "Diameter"), ("density", "Density"), ("set", "Phase_ID")):
        if name not in found:
            found[name] = np.full(len(found["x"]), _constant(text, options, key, RULES[key]))
    found["set"] -= 1
    return from_columns(text.path, KIND, found)


def _count(text: Text, head: list[str]) -> int:
    line = next((each for each in head if each.strip().startswith("Particles:")), "")
    value = line.partition(":")[2].strip()
    if not value.isdigit() or int(value) == 0:
        raise fault(text.path, f"the number of particles {shown(value)}", "a whole number above 0")
    return int(value)


def _options(text: Text, head: list[str]) -> tuple[dict[str, list[str]], int]:
    """Return the words after each option's name, and how many lines there are up to the last option."""
    starts = ("Coordinates: T", "Coordinates: F")
    start = next((at for at, line in enumerate(head) if " ".join(line.split()).startswith(starts)), None)
    if start is None:
        raise fault(text.path, "no line Coordinates: T", "one among the options", remedy="is it complete?")
    options: dict[str, list[str]] = {}
    for place, line in enumerate(head[start:], start=start):
        name, colon, value = line.partition(":")
        words = value.split()
        if not colon or words[:1] not in (["T"], ["F"]):
            return options, place
        options[name.strip()] = words
    return options, len(head)


def _columns(text: Text, options: dict[str, list[str]]) -> tuple[list[Column], int]:
    """Return the columns to read, and how many values a row has."""
    if options["Coordinates"][0] != "T":
        raise fault(text.path, "Coordinates: F", "T, positions in the rows")
    names = {"Phase_ID": "set", "Diameter": "diameter", "Density": "density"}
    columns, place = [], 0
    for option, words in options.items():
        if words[0] != "T":
            continue
        if option == "Coordinates":
            columns += [Column(axis, place + index, NUMBER) for index, axis in enumerate("xyz")]
        elif option in names:
            columns.append(Column(names[option], place, RULES[option]))
        place += WIDTHS.get(option, 1)
    return columns, place


def _constant(text: Text, options: dict[str, list[str]], key: str, expected: str) -> float:
    """Return the value that an option has for all spheres."""
    value = " ".join(options.get(key, ["F"])[1:2])
    try:
        number = float(value)
    except ValueError:
        number = np.nan
    if not number > 0:
        raise fault(text.path, f"{key}: F {value}".rstrip(), f"T, or {expected} for all spheres")
    return number
