"""Rows of numbers as text, quickly and without a copy of the bed: what the plain formats share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from pydantic_core import to_json

ROWS_PER_CHUNK = 8192


def write_rows(
    path: Path, columns: Sequence[NDArray[Any]], *, head: str = "", foot: str = "", separator: str = " "
) -> Path:
    """Write columns of the same length as rows of text between a head and a foot.

    Every number is the shortest text that reads back as the same float64 or integer.

    Args:
        path: The file.
        columns: One-dimensional arrays of numbers.
        head: Text before the first row, with its line end.
        foot: Text after the last row, with its line end.
        separator: What stands between numbers.
    """
    with path.open("wb") as file:
        file.write(head.encode("ascii", "replace"))
        for rows in _chunks(columns):
            # [[1,0.1],[2,0.2]] as JSON is the rows but for its brackets and commas.
            text = to_json(rows)[2:-2].replace(b"],[", b"\n")
            file.write(text.replace(b",", separator.encode("ascii")) + b"\n")
        file.write(foot.encode("ascii", "replace"))
    return path


def _chunks(columns: Sequence[NDArray[Any]]) -> Iterator[list[tuple[float, ...]]]:
    for start in range(0, len(columns[0]), ROWS_PER_CHUNK):
        part = [column[start : start + ROWS_PER_CHUNK].tolist() for column in columns]
        yield list(zip(*part, strict=True))
