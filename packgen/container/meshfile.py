"""Reads a mesh file into a clean surface: units applied, duplicates and degenerate facets removed."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from packgen.arrays import Float64Array, Int64Array, unique_rows
from packgen.errors import GeometryError
from packgen.geometry import Surface

TRIMESH_SUFFIXES = {".stl", ".ply", ".obj", ".off"}
BYTES_MAX = 500_000_000  # ten million facets as a binary STL; no bed needs larger walls
Read = TypeVar("Read")


def read_surface(path: Path, scale: float, place: str) -> tuple[Surface, tuple[str, ...]]:
    """Read a triangulated surface.

    Args:
        path: An STL, PLY, OBJ or OFF file, or anything that meshio reads; of a volume mesh its boundary.
        scale: Metres a unit of the file.
        place: Where the scene names the file, for messages.

    Returns:
        (the surface in metres, one sentence for each kind of fault that was mended).

    Raises:
        GeometryError: The file cannot be read, or holds no usable triangle.
    """
    vertices, faces = read_file(path, place, _load)
    check_corners(path, place, vertices, faces)
    try:
        return clean_surface(vertices * scale, faces)
    except GeometryError as error:
        raise GeometryError(f"{place}: {path.name}: {error}") from error


def read_file(path: Path, place: str, load: Callable[[Path], Read]) -> Read:
    """Return what a function reads from a mesh file, its errors as one line.

    Args:
        path: The file.
        place: Where the scene names the file, for messages.
        load: The function.

    Raises:
        GeometryError: There is no such file, it is too large, or cannot be read.
    """
    if not path.exists():
        raise GeometryError(f"{place}: no such file: {path}; expected a mesh file (paths start at the scene)")
    if not path.is_file():
        raise GeometryError(f"{place}: {path} is not a file; expected a mesh file such as furnace.stl")
    size = path.stat().st_size
    if size > BYTES_MAX:
        raise GeometryError(
            f"{place}: {path.name} has {size / 1e6:,.0f} MB, expected at most {BYTES_MAX / 1e6:,.0f} MB; a "
            "coarser mesh will do"
        )
    try:
        # Libraries print what their errors say anyway.
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()), np.errstate(all="ignore"):
            return load(path)
    except GeometryError:
        raise
    except MemoryError:
        raise
    except BaseException as error:  # meshio exits and numpy's readers raise nearly anything on rubbish
        if isinstance(error, KeyboardInterrupt):
            raise
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        if isinstance(error, SystemExit):
            reason = "unknown format"
        raise GeometryError(
            f"{place}: {path.name} cannot be read as a mesh ({reason}); is it complete and of the format its "
            "ending says?"
        ) from error


def check_corners(path: Path, place: str, vertices: Float64Array, faces: Int64Array) -> None:
    """Refuse a mesh that has no triangles, lacks corners of them, or has some that are not finite.

    Raises:
        GeometryError: It is so.
    """
    if len(faces) == 0:
        raise GeometryError(f"{place}: {path.name} holds no triangles; is it complete?")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise GeometryError(
            f"{place}: {path.name} has facets with corners that it lacks, of {len(vertices)} corners; is it "
            "complete?"
        )
    if not np.isfinite(vertices).all():
        bad = int((~np.isfinite(vertices)).any(axis=1).sum())
        raise GeometryError(
            f"{place}: {path.name} has {bad} corners that are not finite numbers; export it anew"
        )


def _load(path: Path) -> tuple[Float64Array, Int64Array]:
    if path.suffix.lower() == ".stl" and (found := _binary_stl(path)) is not None:
        return found
    if path.suffix.lower() in TRIMESH_SUFFIXES:
        import trimesh

        kind = path.suffix.lower()[1:]
        mesh: Any = trimesh.load_mesh(str(path), file_type=kind, process=False, maintain_order=True)
        return np.asarray(mesh.vertices, float).reshape(-1, 3), np.asarray(mesh.faces, np.int64).reshape(
            -1, 3
        )
    return _load_with_meshio(path)


FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
"""A facet of a binary STL file."""


def _binary_stl(path: Path) -> tuple[Float64Array, Int64Array] | None:
    """Return the triangles of a binary STL file, without a library that takes long to load; None of text.

    Raises:
        ValueError: The file, of either kind, is cut short.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(84)
        file.seek(max(size - 512, 0))
        tail = file.read()
    if head.lstrip().lower().startswith(b"solid") and b"\0" not in head:
        if b"endsolid" not in tail.lower():
            raise ValueError("cut short: its text does not end with endsolid")
        return None
    if len(head) < 84:
        return None
    count = int.from_bytes(head[80:84], "little")
    wanted = 84 + FACET.itemsize * count
    if wanted > size:
        raise ValueError(f"cut short: {count} triangles announced need {wanted} bytes, found {size}")
    corners = np.fromfile(path, FACET, count, offset=84)["corners"]
    return corners.reshape(-1, 3).astype(np.float64), np.arange(3 * count, dtype=np.int64).reshape(-1, 3)


def _load_with_meshio(path: Path) -> tuple[Float64Array, Int64Array]:
    mesh = read_with_meshio(path)
    if mesh.is_volume:  # implies its boundary: the surfaces that some programs add repeat it
        return mesh.points, fans(boundary_polygons(mesh.cells))[:, 1:]
    return mesh.points, _triangulated(mesh.cells)


@dataclass(frozen=True, eq=False, slots=True)
class Cells:
    """What meshio reads of a mesh.

    Attributes:
        points: Corners, in the file's unit, shape (N, 3).
        cells: Its blocks of cells of the highest dimension.
        raw: All that meshio read.
    """

    points: Float64Array
    cells: list[Any]
    raw: Any

    @property
    def is_volume(self) -> bool:
        """Whether its cells are volumes."""
        return bool(self.cells[0].dim == 3)


def read_with_meshio(path: Path) -> Cells:
    """Read a mesh of volumes or of polygons, whose edges are straight.

    Raises:
        ValueError: It has other cells, or none; meshio raises nearly anything on rubbish.
    """
    import meshio

    mesh = meshio.read(path)
    points = np.asarray(mesh.points, float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    most = max((block.dim for block in mesh.cells), default=0)
    blocks = [block for block in mesh.cells if block.dim == most]
    # Cells with points between their corners, such as triangle6, have names of their own.
    known = {*POLYGONS, *CELL_FACES}
    strange = sorted({block.type for block in blocks if block.type not in known})
    if strange or not blocks:
        found = ", ".join(strange) or "nothing"
        raise ValueError(
            f"it holds {found}, expected triangles, quads or other polygons, or the volume cells "
            f"{', '.join(CELL_FACES)}, all with straight edges; export it so"
        )
    return Cells(points, blocks, mesh)


def _triangulated(blocks: list[Any]) -> Int64Array:
    """Return the triangles of polygons, indices, shape (F, 3)."""
    flat = []
    for block in blocks:
        data = np.asarray(block.data, np.int64)
        flat += [data[:, [0, k, k + 1]] for k in range(1, data.shape[1] - 1)]
    return np.concatenate(flat)


POLYGONS = ("triangle", "quad", "polygon")
CELL_FACES = {
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
"""Outward faces of VTK's linear cells (VTK file formats, figure of linear cell types)."""


def boundary_polygons(blocks: list[Any]) -> list[tuple[int, ...]]:
    """Return the faces of volume cells that belong to one cell only, as indices of their corners."""
    seen: dict[tuple[int, ...], tuple[int, ...] | None] = {}
    for block in blocks:
        for cell in np.asarray(block.data, np.int64).tolist():
            for face in CELL_FACES[block.type]:
                corners = tuple(cell[k] for k in face)
                key = tuple(sorted(corners))
                seen[key] = None if key in seen else corners
    return [outer for outer in seen.values() if outer is not None]


def fans(polygons: Sequence[tuple[int, ...]]) -> Int64Array:
    """Return polygons as triangles: index of the polygon, then corners, shape (F, 4)."""
    rows = [
        (index, polygon[0], polygon[k], polygon[k + 1])
        for index, polygon in enumerate(polygons)
        for k in range(1, len(polygon) - 1)
    ]
    return np.array(rows, np.int64).reshape(-1, 4)


def clean_surface(vertices: Float64Array, faces: Int64Array) -> tuple[Surface, tuple[str, ...]]:
    """Merge equal corners and drop degenerate and repeated facets.

    Args:
        vertices: Corner positions [m], shape (V, 3).
        faces: Corner indices, shape (F, 3).

    Returns:
        (the surface, what was mended).

    Raises:
        GeometryError: Nothing is left.
    """
    mended = []
    extent = float(np.ptp(vertices[faces.ravel()], axis=0).max())
    # Corners of an STL are float32: those that agree to its rounding are one corner.
    grid = max(extent, 1e-300) * 1e-9
    keep, back = unique_rows(np.round(vertices / grid))
    vertices, faces = vertices[keep], back[faces]
    corners = vertices[faces]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    flat = area <= 1e-10 * longest**2
    if flat.any():
        mended.append(f"{int(flat.sum())} degenerate facets (no area) removed")
        faces = faces[~flat]
    first, _ = unique_rows(np.sort(faces, axis=1))
    if len(first) < len(faces):
        mended.append(f"{len(faces) - len(first)} repeated facets removed")
        faces = faces[np.sort(first)]
    if len(faces) == 0:
        raise GeometryError("found no facet with an area, expected a surface; is the mesh complete?")
    used, compact = np.unique(faces, return_inverse=True)
    return Surface(vertices[used], compact.reshape(-1, 3)), tuple(mended)
