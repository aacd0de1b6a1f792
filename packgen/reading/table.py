"""Tables in text: csv with named columns, rows ``x y z r``, and what YADE and Chrono write.

The names of the columns stand in the first row, or in a comment above it (YADE's ``#format x_y_z_r_matId``).
Without names the columns are x, y, z, radius and, where there is a fifth, the number of the set.
"""

from __future__ import annotations

import io
import re
from types import MappingProxyType

from packgen.filefaults import fault, shown
from packgen.reading.plausible import refuse_named_units
from packgen.reading.rows import NUMBER, SIZE, WHOLE, Column, Rows, digits_of, read_columns
from packgen.reading.spheres import SphereFile, from_columns
from packgen.reading.text import Text, decoded
from packgen.units import LENGTHS

KIND = "table of text"
SEPARATORS = (";", ",", "\t")
PLAIN = ("x", "y", "z", "radius", "set")
ALIASES = MappingProxyType(
    {
        "x": ("x", "p_x", "pos_x", "position_x", "points:0"),
        "y": ("y", "p_y", "pos_y", "position_y", "points:1"),
        "z": ("z", "p_z", "pos_z", "position_z", "points:2"),
        "radius": ("radius", "r", "rad", "radii"),
        "diameter": ("diameter", "diameters", "d"),
        "id": ("id",),
        "set": ("set", "matid", "material", "family", "phase", "phase_id", "tag"),
        "type": ("type",),
        "density": ("density", "rho"),
        "zone": ("zone",),
        "batch": ("batch",),
        "body": ("body", "body_index", "clumpid", "molecule"),
    }
)
RULES = {"radius": SIZE, "diameter": SIZE, "density": SIZE} | dict.fromkeys(
    ("id", "set", "type", "zone", "batch", "body"), WHOLE
)
UNITS = re.compile(r"\s*[\[(](.*)[\])]$")
DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
LENGTH_COLUMNS = ("x", "y", "z", "radius", "diameter")


def read_table(text: Text, units: str | None = None) -> SphereFile:
    """Read a table of numbers.

    Args:
        text: The file.
        units: Unit of its lengths, which are not converted here; None: metres.

    Raises:
        ReadError: It has no columns x, y, z and radius or diameter, a row that is none, or names of
            columns with another unit.
    """
    start, comment, first = _first_row(text)
    separator = next((each for each in SEPARATORS if each in first), None)
    rows = text.rows(start, separator=separator)
    _refuse_decimal_commas(rows)
    cells = rows.cells(first)
    names = _names_in_comment(comment, len(cells))
    if not names and not all(map(_is_number, cells)):
        names = cells
        end = text.data.find(b"\n", start)
        rows = text.rows(len(text.data) if end < 0 else end + 1, separator=separator)
        _refuse_decimal_commas(rows)
        cells = rows.first()
    line = text.line_at(start)
    if not names:
        if len(cells) not in (4, 5):
            raise fault(
                text.path, f"{len(cells)} columns without names",
                "x y z radius, or the names in the first line", place=line,
            )  # fmt: skip
        names = list(PLAIN[: len(cells)])
    refuse_named_units(text.path, _named_units(names), units, line)
    names = [_regular(each) for each in names]
    columns = _columns(text, names, line)
    if len(cells) > len(names) and any(cells[len(names) :]):  # as where rows have names and their column none
        raise fault(text.path, f"{len(cells)} values", f"{len(names)}: {', '.join(names)}", place=rows.line)
    found = read_columns(rows, columns, width=len(names))
    return from_columns(text.path, KIND, found, digits=digits_of(rows, columns[:3]))


def _first_row(text: Text) -> tuple[int, str, str]:
    """Return where the first row starts, the last comment before it, and the row."""
    place, comment = 0, ""
    while place < len(text.data):
        end = text.data.find(b"\n", place)
        end = len(text.data) if end < 0 else end
        line = decoded(text.data[place:end]).strip()
        if line and not line.startswith("#"):
            return place, comment, line
        comment = line or comment
        place = end + 1
    raise fault(text.path, "nothing but comments", "a row a sphere")


def _refuse_decimal_commas(rows: Rows) -> None:
    """Refuse rows whose first one has numbers such as 0,5 between blanks or semicolons."""
    numbered = enumerate(io.StringIO(rows.text), start=rows.line)
    line, row = next(((line, row) for line, row in numbered if rows.cells(row)), (rows.line, ""))
    words = [word for word in re.split(r"[;\s]+", row.partition("#")[0]) if word]
    odd = [word for word in words if "," in word]
    if len(words) > 1 and odd and all(map(DECIMAL_COMMA.fullmatch, odd)):
        raise fault(
            rows.path, f"decimal commas ({shown(odd[0])})", "decimal points", place=line,
            remedy="replace them, or save the table with points",
        )  # fmt: skip


def _names_in_comment(comment: str, width: int) -> list[str]:
    """Return the names of so many columns in a comment; none where it is of something else."""
    words = comment.lstrip("#").strip().removeprefix("format").strip()
    for between in (r"[\s,;]+", r"[\s,;_]+"):  # YADE's stand between underscores
        names = re.split(between, words)
        if len(names) == width and {"x", "y", "z"} <= set(map(_regular, names)):
            return names
    return []


def _regular(name: str) -> str:
    """Return the name that we have for a column, else its own in lower case."""
    plain = UNITS.sub("", name.strip().strip("\"'").lower())
    return next((regular for regular, others in ALIASES.items() if plain in others), plain)


def _named_units(names: list[str]) -> dict[str, str]:
    """Return the unit of each length that has one in its name, such as ``x [mm]``."""
    found = {}
    for name in names:
        plain = name.strip().strip("\"'")
        unit = UNITS.search(plain)
        if unit and _regular(name) in LENGTH_COLUMNS and unit[1].strip().lower() in LENGTHS:
            found[plain] = unit[1].strip().lower()
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _columns(text: Text, names: list[str], line: int) -> list[Column]:
    there = ", ".join(shown(each)[1:-1] for each in names[:20])
    missing = [each for each in "xyz" if each not in names]
    if not {"radius", "diameter"} & set(names):
        missing.append("radius or diameter")
    if missing:
        remedy = (
            ""
            if {"x", "y", "z"} & set(names)
            else "is it a file of spheres? --container takes a mesh, --scene a scene"
        )
        raise fault(
            text.path, f"the columns {there}", f"{', '.join(missing)} as well", place=line, remedy=remedy
        )
    twice = next((each for each in ALIASES if names.count(each) > 1), None)
    if twice:
        raise fault(text.path, f"two columns for {twice}", "one", place=line, remedy="rename or remove one")
    left_out = "diameter" if "radius" in names else ""
    return [
        Column(name, names.index(name), RULES.get(name, NUMBER))
        for name in ALIASES
        if name in names and name != left_out
    ]
