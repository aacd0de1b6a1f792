"""Rows of numbers in text: read by numpy at once, and line by line only to say what is wrong."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import MappingProxyType

import numpy as np

from packgen.arrays import BoolArray, Float64Array
from packgen.filefaults import Faults, fault, shown

SAMPLE = 1000  # rows whose digits are counted
WHOLE_MAX = 2.0**53  # whole numbers beyond it are no float64

NUMBER, SIZE, WHOLE = "a finite number", "a number greater than 0", "a whole number"


def _is_size(values: Float64Array) -> BoolArray:
    return np.asarray(np.isfinite(values) & (values > 0.0))


def _is_whole(values: Float64Array) -> BoolArray:
    with np.errstate(invalid="ignore"):
        whole = (np.abs(values) < WHOLE_MAX) & (np.floor(values) == values)
    return np.asarray(np.isfinite(values) & whole)


RULES: Mapping[str, Callable[[Float64Array], BoolArray]] = MappingProxyType(
    {NUMBER: np.isfinite, SIZE: _is_size, WHOLE: _is_whole}
)
"""What a column may hold, and whether values (N,) are that."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column to read: what it is called, its place from 0, and what it may hold."""

    name: str
    place: int
    rule: str = NUMBER


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of a file, not yet read.

    Attributes:
        path: The file.
        text: The rows; empty lines, and what follows #, are passed over.
        line: Number of the first one in the file.
        separator: What stands between values; None: blanks.
    """

    path: Path
    text: str
    line: int = 1
    separator: str | None = None

    def cells(self, line: str) -> list[str]:
        """Return the values of a line as text."""
        kept = line.split("#", 1)[0].strip() if self.separator is None else line.split("#", 1)[0]
        if not kept.strip():
            return []
        return [each.strip() for each in kept.split(self.separator)]

    def first(self) -> list[str]:
        """Return the values of the first row; none where there is no row."""
        return next(filter(None, map(self.cells, io.StringIO(self.text))), [])


def read_columns(
    rows: Rows, columns: Sequence[Column], *, width: int, count: int | None = None
) -> dict[str, Float64Array]:
    """Read columns of numbers.

    Args:
        rows: The rows.
        columns: Which ones.
        width: Values that a row should have, at least.
        count: Rows that the file announces; None: it announces none.

    Returns:
        The columns by name, each of shape (N,), float64.

    Raises:
        ReadError: A row is cut short, a value is not what its column holds, or there are not as many rows as
            announced; one line a fault.
    """
    places = [each.place for each in columns]
    last = rows.first()[width - 1 : width]
    if last and width - 1 not in places and _holds(last[0], NUMBER):
        places.append(width - 1)  # a row that lacks a value is seen by its last one
    table: Float64Array | None = None
    if rows.text.strip():
        try:
            table = np.loadtxt(
                io.StringIO(rows.text), dtype=np.float64, comments="#", delimiter=rows.separator,
                usecols=places, ndmin=2,
            )  # fmt: skip
        except (ValueError, IndexError, OverflowError) as error:
            raise _faults(rows, columns, width, str(error)) from error
    if table is None or not table.size:
        raise fault(
            rows.path, "no row of numbers", "a row a sphere", place=rows.line, remedy="is the file complete?"
        )
    found = {each.name: np.ascontiguousarray(table[:, place]) for place, each in enumerate(columns)}
    cut = len(_last(rows)) < width
    if (
        cut
        or _has_longer_rows(rows, len(table))
        or not all(RULES[each.rule](found[each.name]).all() for each in columns)
    ):
        raise _faults(rows, columns, width, "")
    if count is not None and len(table) != count:
        raise fault(
            rows.path, f"{_many(len(table), 'row')} from line {rows.line} on",
            f"the {count:,} that the file announces", remedy="is the file complete?",
        )  # fmt: skip
    return found


def _has_longer_rows(rows: Rows, count: int) -> bool:
    """Return whether some of so many rows have more values than the first: numpy passes over these.

    Values are counted without making them. Comments would count as values: files with them are not looked at.
    """
    if "#" in rows.text:
        return False
    width = len(rows.first())
    if rows.separator is not None:
        return rows.text.count(rows.separator) > count * (width - 1)
    blank = np.frombuffer(b" " + rows.text.encode("ascii", "replace"), np.uint8) <= ord(" ")
    return int(np.count_nonzero(blank[:-1] & ~blank[1:])) > count * width


def digits_of(rows: Rows, columns: Sequence[Column]) -> int:
    """Return how many digits the numbers of columns have, at most: of the first thousand rows."""
    most = 0
    for line in islice(io.StringIO(rows.text), SAMPLE):
        cells = rows.cells(line)
        for each in columns if cells else ():
            mantissa = cells[each.place].lower().partition("e")[0]
            most = max(most, len(mantissa.lstrip("+-").replace(".", "").lstrip("0")))
    return most


def _last(rows: Rows) -> list[str]:
    """Return the values of the last row: it is the one that a file cut short lacks some of."""
    end = len(rows.text)
    while end > 0:
        start = rows.text.rfind("\n", 0, end) + 1
        cells = rows.cells(rows.text[start:end])
        if cells:
            return cells
        end = start - 1
    return []


def _faults(rows: Rows, columns: Sequence[Column], width: int, reason: str) -> Exception:
    """Return the faults of rows that cannot be read, found line by line."""
    faults = Faults(rows.path)
    longest = max(width, len(rows.first()))
    for number, line in enumerate(io.StringIO(rows.text), start=rows.line):
        cells = rows.cells(line)
        if not cells:
            continue
        if len(cells) < width:
            wanted = f"{width}: {', '.join(each.name for each in sorted(columns, key=lambda c: c.place))}"
            faults.add(
                _many(len(cells), "value"), wanted if len(columns) == width else str(width), place=number
            )
            continue
        if len(cells) > longest and "#" not in rows.text:
            faults.add(_many(len(cells), "value"), f"{longest}, as in the first row", place=number)
            continue
        for each in columns:
            if not _holds(cells[each.place], each.rule):
                faults.add(f"{each.name} {shown(cells[each.place])}", each.rule, place=number)
                break
    if not faults.any:
        faults.add(f"rows that cannot be read ({reason})", "numbers in columns", place=rows.line)
    return faults.error()


def _many(count: int, what: str) -> str:
    return f"{count:,} {what}" if count == 1 else f"{count:,} {what}s"


def _holds(text: str, rule: str) -> bool:
    """Return whether a value is what its column may hold; Python takes underscores, numpy does not."""
    try:
        value = math.nan if "_" in text else float(text)
    except ValueError:
        return False
    if not math.isfinite(value):
        return False
    if rule == WHOLE:
        return value.is_integer() and abs(value) < WHOLE_MAX
    return rule == NUMBER or value > 0.0
