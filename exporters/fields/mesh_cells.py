"""The volume of spheres in each cell of a mesh, exactly.

Cells are hexahedra, wedges and tetrahedra with corners in VTK's order, right side out or inside out. A convex
cell with plane faces is what lies below their planes. Of any other, warped, hollow or with corners that
coincide, each face is a fan of triangles around its middle: the cells on both sides of a warped face agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from exporters.fields.ball_kernels import Polyhedra

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]

EXACT = 1.0e-12  # largest distance of a corner off its plane face, of the cell's size
CELLS_PER_BLOCK = 16384  # cells whose planes are held at a time
OTHERS_PER_BLOCK = 4096  # cells with fans for faces that are held at a time
EMPTY = 1.0e-13  # volume of a cell over its extent cubed that is none
CROSSED = 1.0e-6  # spheres' volume below 0 that rounding does not explain, over the cell's
BOXES_A_CELL = 16.0  # mean number of boxes that list a cell; with more the grid is too fine

# The corners of each face, counter-clockwise from outside, the last one of a triangle twice.
FACES = {
    "hexahedron": [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    "wedge": [[0, 2, 1, 1], [3, 4, 5, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    "tetra": [[0, 2, 1, 1], [0, 1, 3, 3], [1, 2, 3, 3], [2, 0, 3, 3]],
}


@dataclass(frozen=True, eq=False, slots=True)
class Planes:
    """The planes of the faces of each cell, or of their fans, and which cells lie below all of theirs.

    Attributes:
        middle: Middle of each cell [m], shape (C, 3).
        normal: Outward unit normals, shape (C, F, 3).
        offset: Distance of each plane from the middle [m], shape (C, F); infinite where it has no area.
        plain: Cells that are convex with plane faces, shape (C,); none of fans.
        volume: Volume of each plain cell [m3], shape (C,); of fans of any, negative if inside out.
    """

    middle: Float64Array
    normal: Float64Array
    offset: Float64Array
    plain: NDArray[np.bool_]
    volume: Float64Array

    def of(self, cells: Int64Array) -> Planes:
        """Return the planes of some cells (C,)."""
        return Planes(
            self.middle[cells], self.normal[cells], self.offset[cells], self.plain[cells], self.volume[cells]
        )

    def polyhedra(self, corners: Float64Array, faces: Int64Array) -> Polyhedra:
        """Return the cells as the loops take them: of all their corners [m], (C, K, 3), and faces (F, 4)."""
        from exporters.fields.ball_kernels import Polyhedra

        relative, convex = corners - self.middle[:, None], bool(self.plain.all())
        return Polyhedra(convex, self.middle, relative, faces, self.normal, self.offset)


def mesh_volumes(
    position: Float64Array, radius: Float64Array, kind: str, corners: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return the volume of spheres in each cell of one kind, and the volumes of the cells.

    Args:
        position: Sphere centres [m], shape (N, 3).
        radius: Sphere radii [m], shape (N,).
        kind: ``hexahedron``, ``wedge`` or ``tetra``.
        corners: Corners of each cell [m], shape (C, 8, 6 or 4, 3).

    Returns:
        Volume of spheres, and of the cell [m3], each of shape (C,).

    Raises:
        ValueError: A cell has no volume, or crosses itself; the message has its number among its kind.
    """
    volume, of_cell = np.zeros(len(corners)), np.zeros(len(corners))
    for start in range(0, len(corners), CELLS_PER_BLOCK):
        part = slice(start, start + CELLS_PER_BLOCK)
        planes = planes_of(kind, corners[part])
        of_cell[part] = planes.volume
        if planes.plain.all():
            volume[part] = _in_cells(position, radius, corners[part], np.array(FACES[kind]), planes)
            continue
        plain, other = np.flatnonzero(planes.plain), np.flatnonzero(~planes.plain)
        if len(plain):
            here = corners[start + plain]
            volume[start + plain] = _in_cells(position, radius, here, np.array(FACES[kind]), planes.of(plain))
        for some in np.array_split(other, -(-len(other) // OTHERS_PER_BLOCK)):
            split, faces = fans(kind, corners[start + some])
            planes = fan_planes(split, faces)
            of_cell[start + some] = np.abs(planes.volume)
            found = _in_cells(position, radius, split, faces, planes)
            volume[start + some] = np.where(planes.volume < 0.0, -found, found)
    _check(kind, corners, volume, of_cell)
    return volume, of_cell


def _check(kind: str, corners: Float64Array, volume: Float64Array, of_cell: Float64Array) -> None:
    extent = np.ptp(corners, axis=1).max(axis=1) if len(corners) else np.zeros(0)
    wrong = ~(of_cell > EMPTY * extent**3)
    if wrong.any():
        raise ValueError(f"{kind} {int(wrong.argmax())} has no volume, {_others(wrong)}")
    wrong = volume < -CROSSED * of_cell
    if wrong.any():
        raise ValueError(f"{kind} {int(wrong.argmax())} crosses itself, {_others(wrong)}")


def _others(wrong: NDArray[np.bool_]) -> str:
    count = int(np.count_nonzero(wrong)) - 1
    return f"and {count:,} more" if count else "the only one"


def _in_cells(
    position: Float64Array, radius: Float64Array, corners: Float64Array, faces: Int64Array, planes: Planes
) -> Float64Array:
    """Return the volume of spheres in each of some cells [m3], (C,); those that are not plain are fans."""
    from exporters.fields.ball_kernels import Boxes, add_balls, listed_cells

    low, high = corners.min(axis=1), corners.max(axis=1)
    origin, extent = low.min(axis=0), np.ptp(np.concatenate([low, high]), axis=0)
    size = float(np.cbrt(np.maximum(extent, 1e-6 * extent.max()).prod() / len(corners)))
    while True:
        first, last = (np.floor((each - origin) / size).astype(np.int32) for each in (low, high))
        if (last - first + 1).prod(axis=1, dtype=np.float64).mean() <= BOXES_A_CELL:
            break
        size *= 1.5
    count = last.max(axis=0).astype(np.int64) + 1
    start, item = listed_cells(first, last, count)
    volume = np.zeros(len(corners))
    boxes = Boxes(origin, size, count, first, start, item)
    add_balls(position, radius, planes.polyhedra(corners, faces), boxes, volume)
    return volume


def fans(kind: str, corners: Float64Array) -> tuple[Float64Array, Int64Array]:
    """Return cells with their faces as fans of triangles around the faces' middles.

    Args:
        kind: ``hexahedron``, ``wedge`` or ``tetra``.
        corners: Corners of each cell [m], shape (C, K, 3).

    Returns:
        (corners, then the middles of the faces, shape (C, K + F, 3); triangles, as `FACES` has faces).
    """
    faces, triangles = FACES[kind], []
    middles = np.stack([corners[:, sorted(set(face))].mean(axis=1) for face in faces], axis=1)
    for number, face in enumerate(faces):
        around = list(dict.fromkeys(face))
        middle = corners.shape[1] + number
        triangles += [[a, b, middle, middle] for a, b in zip(around, [*around[1:], around[0]], strict=True)]
    return np.concatenate([corners, middles], axis=1), np.array(triangles)


def fan_planes(corners: Float64Array, faces: Int64Array) -> Planes:
    """Return the planes of triangles of cells, (C, K, 3) [m]; volumes are negative of cells inside out."""
    middle = corners.mean(axis=1)
    relative = corners - middle[:, None]
    a, b, c = (relative[:, faces[:, place]] for place in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=2)
    volume = np.einsum("cfi,cfi->c", a, normal) / 6.0
    size = np.abs(relative).max(axis=(1, 2))
    flat = length <= EXACT * size[:, None] ** 2
    normal /= np.where(flat, 1.0, length)[:, :, None]
    offset = np.where(flat, np.inf, np.einsum("cfi,cfi->cf", normal, a))
    return Planes(middle, normal, offset, np.zeros(len(corners), dtype=bool), volume)


def planes_of(kind: str, corners: Float64Array) -> Planes:
    """Return the planes of cells with ``corners`` (C, 8, 6 or 4, 3) [m]."""
    middle = corners.mean(axis=1)
    relative = corners - middle[:, None]
    face = relative[:, FACES[kind]]
    normal = np.cross(face[:, :, 2] - face[:, :, 0], face[:, :, 3] - face[:, :, 1])
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    normal /= np.where(length > 0.0, length, 1.0)
    offset = np.einsum("cfi,cfi->cf", normal, face.mean(axis=2))
    volume = np.abs(offset * length[:, :, 0]).sum(axis=1) / 6.0  # pyramids on the faces
    outward = np.where(offset < 0.0, -1.0, 1.0)
    normal, offset = normal * outward[:, :, None], offset * outward
    below = offset[:, :, None] - np.einsum("cfi,cki->cfk", normal, relative)
    own = np.take_along_axis(below, np.broadcast_to(FACES[kind], (*offset.shape, 4)), axis=2)
    slack = EXACT * np.abs(relative).max(axis=(1, 2))
    plain = (np.abs(own) <= slack[:, None, None]).all(axis=(1, 2))
    plain &= (below >= -slack[:, None, None]).all(axis=(1, 2)) & (length > 0.0).all(axis=(1, 2))
    edge = np.linalg.norm(face - np.roll(face, 1, axis=2), axis=3)
    is_edge = np.array(FACES[kind]) != np.roll(FACES[kind], 1, axis=1)
    plain &= (edge > slack[:, None, None])[:, is_edge].all(axis=1)
    return Planes(middle, normal, offset, plain, volume)
