"""Rows of numbers as text, quickly and without a copy of the bed: what the plain formats share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict
from pydantic_core import to_json

from packgen.bed import AnyBed, Bed

ROWS_PER_CHUNK = 8192


class NoOptions(BaseModel):
    """Options of a format without any."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def ids(bed: AnyBed, *, start: int = 1) -> NDArray[np.int64]:
    """Return the index of each sphere in the bed, counted from ``start``, shape (N,)."""
    return np.arange(start, start + bed.count, dtype=np.int64)


def constant(bed: Bed, value: float) -> NDArray[np.generic]:
    """Return one number repeated for each sphere, shape (N,), without a full array of it."""
    return np.broadcast_to(np.asarray(value), (bed.count,))


def write_rows(
    path: Path,
    columns: Sequence[NDArray[Any]],
    *,
    head: str = "",
    foot: str = "",
    separator: str = " ",
    append: bool = False,
) -> Path:
    """Write columns of the same length as rows of text between a head and a foot.

    Every number is the shortest text that reads back as the same float64 or integer; words stand as they are.

    Args:
        path: The file.
        columns: One-dimensional arrays of numbers, or of words without blanks, commas, brackets and quotes.
        head: Text before the first row, with its line end.
        foot: Text after the last row, with its line end.
        separator: What stands between numbers.
        append: Write behind what the file holds already.
    """
    with path.open("ab" if append else "wb") as file:
        file.write(head.encode("ascii", "replace"))
        for rows in _chunks(columns):
            # [[1,0.1],[2,0.2]] as JSON is the rows but for its brackets and commas.
            text = to_json(rows)[2:-2].replace(b"],[", b"\n")
            text = text.replace(b'"', b"")
            file.write(text.replace(b",", separator.encode("ascii")) + b"\n")
        file.write(foot.encode("ascii", "replace"))
    return path


def write_parts(
    path: Path,
    parts: Iterable[Sequence[NDArray[Any]]],
    *,
    head: str = "",
    foot: str = "",
    separator: str = " ",
) -> Path:
    """Write columns that come some rows at a time, as `write_rows` does; see there.

    Args:
        path: The file.
        parts: The columns of some rows each.
        head: Text before the first row, with its line end.
        foot: Text after the last row, with its line end.
        separator: What stands between numbers.
    """
    path.write_bytes(head.encode("ascii", "replace"))
    for columns in parts:
        write_rows(path, columns, separator=separator, append=True)
    with path.open("ab") as file:
        file.write(foot.encode("ascii", "replace"))
    return path


def _chunks(columns: Sequence[NDArray[Any]]) -> Iterator[list[tuple[Any, ...]]]:
    for start in range(0, len(columns[0]), ROWS_PER_CHUNK):
        part = [column[start : start + ROWS_PER_CHUNK].tolist() for column in columns]
        yield list(zip(*part, strict=True))
