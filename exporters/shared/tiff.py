"""Images of several pages as TIFF 6.0, little-endian, uncompressed, a strip a page."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

SHORT, LONG, ASCII = 3, 4, 2
UNSIGNED, FLOAT = 1, 3  # sample formats
TIFF_BYTES_MAX = 2**32 - 2**24  # offsets have 32 bits


def write_tiff(path: Path, pages: NDArray[Any], text: str) -> Path:
    """Write pages of uint8 or float32 as one file.

    Args:
        path: The file.
        pages: Pages, rows and columns, shape (P, R, C); together less than 4 GB.
        text: Description of the first page; ASCII.

    Returns:
        The path.
    """
    kind = "<u1" if pages.dtype == np.uint8 else "<f4"
    rows, columns = pages.shape[1:]
    size = rows * columns * np.dtype(kind).itemsize
    note = text.encode("ascii", "replace") + b"\0"
    note += b"\0" * (len(note) % 2)
    data = 8 + len(note)  # where the first page begins
    step = size + size % 2
    directories = data + step * len(pages)
    with path.open("wb") as file:
        file.write(struct.pack("<2sHI", b"II", 42, directories) + note)
        for page in pages:
            file.write(np.ascontiguousarray(page, kind).tobytes() + b"\0" * (size % 2))
        at = directories
        for index in range(len(pages)):
            tags = [
                (256, LONG, 1, columns),
                (257, LONG, 1, rows),
                (258, SHORT, 1, 8 * np.dtype(kind).itemsize),
                (259, SHORT, 1, 1),  # not compressed
                (262, SHORT, 1, 1),  # 0 is black
                (273, LONG, 1, data + step * index),
                (277, SHORT, 1, 1),
                (278, LONG, 1, rows),
                (279, LONG, 1, size),
                (339, SHORT, 1, UNSIGNED if kind == "<u1" else FLOAT),
            ]
            if index == 0:
                tags.insert(5, (270, ASCII, len(note), 8))
            at += 2 + 12 * len(tags) + 4
            entries = b"".join(struct.pack("<HHII", *tag) for tag in tags)
            file.write(struct.pack("<H", len(tags)) + entries)
            file.write(struct.pack("<I", at if index + 1 < len(pages) else 0))
    return path
