"""Reads a mesh file into a clean surface: units applied, duplicates and degenerate facets removed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int64Array, unique_rows
from packgen.errors import GeometryError
from packgen.geometry import Surface

TRIMESH_SUFFIXES = {".stl", ".ply", ".obj", ".off"}
FACETS_MAX = 5_000_000


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
    if not path.exists():
        raise GeometryError(f"{place}: no such file: {path}; expected a mesh file (paths start at the scene)")
    if not path.is_file():
        raise GeometryError(f"{place}: {path} is not a file; expected a mesh file such as furnace.stl")
    try:
        vertices, faces = _load(path)
    except GeometryError:
        raise
    except MemoryError:
        raise
    except BaseException as error:  # meshio exits and numpy's readers raise nearly anything on rubbish
        if isinstance(error, KeyboardInterrupt):
            raise
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise GeometryError(
            f"{place}: {path.name} cannot be read as a mesh ({reason}); is it complete and of the format its "
            "ending says?"
        ) from error
    if len(faces) == 0:
        raise GeometryError(f"{place}: {path.name} holds no triangles; is it complete?")
    if not np.isfinite(vertices).all():
        bad = int((~np.isfinite(vertices)).any(axis=1).sum())
        raise GeometryError(
            f"{place}: {path.name} has {bad} corners that are not finite numbers; export it anew"
        )
    return clean_surface(vertices * scale, faces)


def _load(path: Path) -> tuple[Float64Array, Int64Array]:
    if path.suffix.lower() == ".stl":
        _check_binary_stl_length(path)
    if path.suffix.lower() in TRIMESH_SUFFIXES:
        import trimesh

        mesh: Any = trimesh.load_mesh(str(path), process=False, maintain_order=True)
        return np.asarray(mesh.vertices, float).reshape(-1, 3), np.asarray(mesh.faces, np.int64).reshape(
            -1, 3
        )
    return _load_with_meshio(path)


def _check_binary_stl_length(path: Path) -> None:
    with path.open("rb") as file:
        head = file.read(84)
    size = path.stat().st_size
    if len(head) == 84 and not head.lstrip().lower().startswith(b"solid"):
        count = int.from_bytes(head[80:84], "little")
        wanted = 84 + 50 * count
        if wanted > size:
            raise ValueError(f"cut short: {count} triangles announced need {wanted} bytes, found {size}")


def _load_with_meshio(path: Path) -> tuple[Float64Array, Int64Array]:
    import meshio

    mesh = meshio.read(path)
    points = np.asarray(mesh.points, float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    volume = [block for block in mesh.cells if block.type in {"tetra", "hexahedron", "wedge", "pyramid"}]
    if volume:
        return points, _boundary(volume)
    flat = []
    for block in mesh.cells:
        data = np.asarray(block.data, np.int64)
        if block.type == "triangle":
            flat.append(data)
        elif block.type == "quad":
            flat.extend([data[:, [0, 1, 2]], data[:, [0, 2, 3]]])
    if not flat:
        kinds = ", ".join(sorted({str(block.type) for block in mesh.cells})) or "nothing"
        raise ValueError(f"it holds {kinds}, expected triangles, quads or volume cells")
    return points, np.concatenate(flat)


CELL_FACES = {
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
}
"""Outward faces of VTK's linear cells (VTK file formats, figure of linear cell types)."""


def _boundary(blocks: list[Any]) -> Int64Array:
    """Return the triangulated faces that belong to one cell only."""
    seen: dict[tuple[int, ...], tuple[int, ...] | None] = {}
    for block in blocks:
        for cell in np.asarray(block.data, np.int64).tolist():
            for face in CELL_FACES[block.type]:
                corners = tuple(cell[k] for k in face)
                key = tuple(sorted(corners))
                seen[key] = None if key in seen else corners
    triangles = []
    for outer in seen.values():
        if outer is not None:
            triangles.append(outer[:3])
            if len(outer) == 4:
                triangles.append((outer[0], outer[2], outer[3]))
    return np.array(triangles, np.int64).reshape(-1, 3)


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
        raise GeometryError("the mesh has no facet with an area; is it complete?")
    used, compact = np.unique(faces, return_inverse=True)
    return Surface(vertices[used], compact.reshape(-1, 3)), tuple(mended)
