"""How much of the spheres lies in each cell of a mesh, exactly.

Cells that are convex with plane faces have closed forms (`convexcells`); all others are the library's
(``overlap``), pair by pair.

Reference: S. Strobl, A. Formella, T. Poeschel, Exact calculation of the overlap volume of spheres and mesh
elements, J. Comput. Phys. 311 (2016) 158. Cells are hexahedra, wedges and tetrahedra with corners in VTK's
order. The library takes an element inside out for another one, so that those are turned first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]

SPHERES_PER_CHUNK = 32768
EXACT = 1.0e-12  # of a cell's size: how far corners of a plane face may lie off it
CELLS_PER_BLOCK = 16384  # cells whose planes are held at a time
BOXES_A_CELL = 16.0  # in which a cell is listed, on average; in more the grid is too fine

# The corners of an element seen as a mirror image, and the four corners whose triple product tells.
MIRRORED = {
    "hexahedron": ([4, 5, 6, 7, 0, 1, 2, 3], [0, 1, 3, 4]),
    "wedge": ([3, 4, 5, 0, 1, 2], [0, 1, 2, 3]),
    "tetra": ([0, 2, 1, 3], [0, 1, 2, 3]),
}
# The corners of each face, the last one of a triangle twice.
FACES = {
    "hexahedron": [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    "wedge": [[0, 1, 2, 2], [3, 4, 5, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    "tetra": [[0, 1, 2, 2], [0, 1, 3, 3], [1, 2, 3, 3], [2, 0, 3, 3]],
}


@dataclass(frozen=True, eq=False, slots=True)
class Planes:
    """The planes of the faces of each cell, and which cells are what lies below all of theirs.

    Attributes:
        middle: Middle of each cell [m], shape (C, 3).
        normal: Outward unit normals, shape (C, F, 3).
        offset: Distance of each plane from the middle [m], shape (C, F).
        plain: Cells that are convex with plane faces, shape (C,).
        volume: Volume of each plain cell [m3], shape (C,).
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
        ValueError: A cell has a warped face.
    """
    volume, of_cell = np.zeros(len(corners)), np.zeros(len(corners))
    for start in range(0, len(corners), CELLS_PER_BLOCK):
        part = slice(start, start + CELLS_PER_BLOCK)
        planes = planes_of(kind, corners[part])
        of_cell[part] = planes.volume
        if planes.plain.all():
            volume[part] = _convex_volumes(position, radius, kind, corners[part], planes)
            continue
        plain, other = start + np.flatnonzero(planes.plain), start + np.flatnonzero(~planes.plain)
        if len(plain):
            some = planes.of(plain - start)
            volume[plain] = _convex_volumes(position, radius, kind, corners[plain], some)
        volume[other], of_cell[other] = _library_volumes(position, radius, kind, corners[other])
    return volume, of_cell


def _convex_volumes(
    position: Float64Array, radius: Float64Array, kind: str, corners: Float64Array, planes: Planes
) -> Float64Array:
    """Return the volume of spheres in each of some convex cells (C,) [m3]."""
    from exporters.convexcells import add_balls, listed_cells

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
    volume, relative = np.zeros(len(corners)), corners - planes.middle[:, None]
    add_balls(
        position, radius, planes.middle, np.abs(relative).max(axis=1), relative, np.array(FACES[kind]),
        planes.normal, planes.offset, origin, size, count, first, start, item, volume,
    )  # fmt: skip
    return volume


def _library_volumes(
    position: Float64Array, radius: Float64Array, kind: str, corners: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return the volume of spheres in each of some cells, and of the cells, by the library; (C,) [m3]."""
    import overlap

    element = {"hexahedron": overlap.Hexahedron, "wedge": overlap.Wedge, "tetra": overlap.Tetrahedron}[kind]
    bodies = [element(each) for each in _right_side_out(kind, corners)]
    volume = np.zeros(len(corners))
    for spheres, cells in _close_pairs(position, radius, corners):
        for sphere, cell in zip(spheres.tolist(), cells.tolist(), strict=True):
            ball = overlap.Sphere(position[sphere], float(radius[sphere]))
            volume[cell] += overlap.overlap_volume(ball, bodies[cell])
    return volume, np.array([body.volume for body in bodies])


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
    return Planes(middle, normal, offset, plain, volume)


def _right_side_out(kind: str, corners: Float64Array) -> Float64Array:
    """Return the corners of cells, of those that are inside out in the order of their mirror image."""
    order, tetrahedron = MIRRORED[kind]
    edges = corners[:, tetrahedron[1:]] - corners[:, tetrahedron[:1]]
    inside_out = np.linalg.det(edges) < 0
    turned = corners.copy()
    turned[inside_out] = corners[inside_out][:, order]
    return turned


def _close_pairs(
    position: Float64Array, radius: Float64Array, corners: Float64Array
) -> Iterator[tuple[Int64Array, Int64Array]]:
    """Yield, some at a time, spheres (P,) and the cells (P,) whose box they reach."""
    from scipy.spatial import cKDTree

    low, high = corners.min(axis=1), corners.max(axis=1)
    center, reach = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2
    octave = np.floor(np.log2(reach / reach.min())).astype(np.int64)
    # A tree for each octave of cell size: a small cell is not looked for as far away as a large one.
    for value in np.unique(octave):
        members = np.flatnonzero(octave == value)
        tree, farthest = cKDTree(center[members]), reach[members].max()
        for start in range(0, len(radius), SPHERES_PER_CHUNK):
            part = slice(start, start + SPHERES_PER_CHUNK)
            near = tree.query_ball_point(position[part], radius[part] + farthest)
            count = np.fromiter(map(len, near), np.int64, len(near))
            cell = members[np.fromiter(chain.from_iterable(near), np.int64, int(count.sum()))]
            sphere = start + np.repeat(np.arange(len(near)), count)
            away = np.clip(position[sphere], low[cell], high[cell]) - position[sphere]
            reached = np.einsum("pi,pi->p", away, away) < radius[sphere] ** 2
            yield sphere[reached], cell[reached]
