"""VTK's XML files, written piece by piece: arrays appended raw, or in place as base64.

Files for meshio have their arrays in place. Its reader of appended raw arrays (5.3.5) confuses two arrays
where the offsets of both encodings happen to agree, as in every third bed.

Format: "VTK XML file formats" (docs.vtk.org), byte order and widths said in the head.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

VTK_TYPES = {"f8": "Float64", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}
# VTK's number of each kind of cell, by meshio's name.
CELL_TYPES = {"vertex": 1, "tetra": 10, "hexahedron": 12, "wedge": 13}

BYTES_PER_PIECE = 3 * 2**18

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Section:
    """An element of a piece, such as ``PointData``: its name, its arrays and its attributes.

    Attributes:
        name: Name of the element.
        arrays: Arrays of shape (N,), or (N, components), by name.
        attributes: Attributes of the element.
    """

    name: str
    arrays: Arrays
    attributes: Mapping[str, object] = field(default_factory=dict)


def write(
    path: Path,
    dataset: str,
    sections: Iterable[Section],
    *,
    piece: Mapping[str, object],
    grid: Mapping[str, object] | None = None,
    in_place: bool = False,
) -> Path:
    """Write a file of one piece.

    Args:
        path: The file.
        dataset: ``PolyData``, ``UnstructuredGrid`` or ``ImageData``.
        sections: What is in the piece, in order.
        piece: Attributes of the piece, such as ``NumberOfPoints``.
        grid: Attributes of the dataset.
        in_place: Write the arrays in base64 where they are named, not raw at the end.

    Returns:
        The path.
    """
    blocks: list[NDArray[Any]] = []
    with path.open("wb") as file:
        _put(
            file,
            '<?xml version="1.0"?>\n'
            f'<VTKFile type="{dataset}" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
            f"<{dataset}{_attributes(grid or {})}>\n<Piece{_attributes(piece)}>\n",
        )
        for section in sections:
            _put(file, f"<{section.name}{_attributes(section.attributes)}>\n")
            for name, values in section.arrays.items():
                _put_array(file, name, values, None if in_place else blocks)
            _put(file, f"</{section.name}>\n")
        _put(file, f"</Piece>\n</{dataset}>\n")
        if blocks:
            _put(file, '<AppendedData encoding="raw">\n_')
            for block in blocks:
                file.write(np.uint64(block.nbytes).tobytes())
                file.write(np.ascontiguousarray(block).data)
            _put(file, "\n</AppendedData>\n")
        _put(file, "</VTKFile>\n")
    return path


def write_polydata(
    path: Path, points: NDArray[np.float64], kind: str, cells: NDArray[np.int64], point_data: Arrays
) -> Path:
    """Write a PolyData file.

    Args:
        path: The file.
        points: Positions [m], shape (N, 3).
        kind: What the cells are: ``Verts`` or ``Polys``.
        cells: Indices of the points of each cell, shape (C, k).
        point_data: Arrays of shape (N,) by name.
    """
    offsets = np.arange(1, len(cells) + 1, dtype=np.int64) * cells.shape[1]
    counts = {"Verts": 0, "Lines": 0, "Strips": 0, "Polys": 0, kind: len(cells)}
    sections = (
        *_points(points, point_data),
        Section(kind, {"connectivity": cells.reshape(-1), "offsets": offsets}),
    )
    sizes = {"NumberOfPoints": len(points), **{f"NumberOf{name}": count for name, count in counts.items()}}
    return write(path, "PolyData", sections, piece=sizes)


def type_of(values: NDArray[Any]) -> str:
    """Return VTK's name of the type of an array's numbers."""
    return VTK_TYPES[values.dtype.str[1:]]


def write_parallel_polydata(path: Path, files: Iterable[str], point_data: Mapping[str, str]) -> Path:
    """Write the file that names the PolyData files of one dataset.

    Args:
        path: The file.
        files: Their names, relative to it.
        point_data: Type of each array of the points by name; positions are Float64.
    """
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="PPolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        '<PPolyData GhostLevel="0">',
        "<PPoints>",
        '<PDataArray type="Float64" Name="Points" NumberOfComponents="3"/>',
        "</PPoints>",
        f"<PPointData{_attributes(_active(point_data))}>",
        *(f"<PDataArray{_attributes({'type': kind, 'Name': name})}/>" for name, kind in point_data.items()),
        "</PPointData>",
        *(f"<Piece{_attributes({'Source': each})}/>" for each in files),
        "</PPolyData>",
        "</VTKFile>",
    ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
    return path


def write_unstructured(
    path: Path,
    points: NDArray[np.float64],
    blocks: Iterable[tuple[str, NDArray[np.int64]]],
    *,
    point_data: Arrays | None = None,
    cell_data: Arrays | None = None,
) -> Path:
    """Write an UnstructuredGrid file.

    Args:
        path: The file.
        points: Positions [m], shape (N, 3).
        blocks: Kind (see `CELL_TYPES`) and indices of the points of each cell (C, k), block by block.
        point_data: Arrays of shape (N,) by name.
        cell_data: Arrays of shape (C of all blocks,) by name.
    """
    parts = [(CELL_TYPES[kind], np.asarray(cells, dtype=np.int64)) for kind, cells in blocks]
    connectivity = [cells.reshape(-1) for _, cells in parts]
    corners = np.concatenate([np.full(len(cells), cells.shape[1]) for _, cells in parts])
    cells = {
        "connectivity": connectivity[0] if len(parts) == 1 else np.concatenate(connectivity),
        "offsets": np.cumsum(corners, dtype=np.int64),
        "types": np.concatenate([np.full(len(cells), number, np.uint8) for number, cells in parts]),
    }
    sections = (
        *_points(points, point_data or {}),
        Section("Cells", cells),
        Section("CellData", cell_data or {}),
    )
    sizes = {"NumberOfPoints": len(points), "NumberOfCells": len(corners)}
    return write(path, "UnstructuredGrid", sections, piece=sizes, in_place=True)


def _points(points: NDArray[np.float64], data: Arrays) -> tuple[Section, Section]:
    return Section("PointData", data, _active(data)), Section("Points", {"Points": points})


def _active(data: Mapping[str, object]) -> dict[str, str]:
    return {"Scalars": "diameter"} if "diameter" in data else {}


def _put(file: BinaryIO, text: str) -> None:
    file.write(text.encode("ascii"))


def _put_array(file: BinaryIO, name: str, values: NDArray[Any], blocks: list[NDArray[Any]] | None) -> None:
    """Write an array's element, with its values in it, or add it to the blocks that follow."""
    form = {"type": type_of(values), "Name": name}
    if values.ndim == 2:
        form["NumberOfComponents"] = str(values.shape[1])
    values = values.astype(values.dtype.newbyteorder("<"), copy=False)
    if blocks is not None:
        start = sum(8 + block.nbytes for block in blocks)
        _put(file, f'<DataArray{_attributes(form)} format="appended" offset="{start}"/>\n')
        blocks.append(values)
        return
    _put(file, f'<DataArray{_attributes(form)} format="binary">')
    data = np.ascontiguousarray(values).reshape(-1).view(np.uint8)
    head = np.uint64(len(data)).tobytes() + data[:1].tobytes()  # nine bytes: no padding inside
    file.write(base64.b64encode(head))
    for start in range(1, len(data), BYTES_PER_PIECE):
        file.write(base64.b64encode(data[start : start + BYTES_PER_PIECE].data))
    _put(file, "</DataArray>\n")


def _attributes(values: Mapping[str, object]) -> str:
    return "".join(f' {name}="{value}"' for name, value in values.items())
