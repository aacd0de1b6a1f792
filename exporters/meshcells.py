"""How much of the spheres lies in each cell of a mesh, exactly.

Most spheres are cut by one face of a cell or none, in a mesh of boxes by two or three at right angles: those
have closed forms (`cuts`). The others, and cells that are not convex, are the library's (``overlap``).

Reference: S. Strobl, A. Formella, T. Poeschel, Exact calculation of the overlap volume of spheres and mesh
elements, J. Comput. Phys. 311 (2016) 158. Cells are hexahedra, wedges and tetrahedra with corners in VTK's
order. The library takes an element inside out for another one, so that those are turned first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from exporters import cuts

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]

SPHERES_PER_CHUNK = 32768
EXACT = 1.0e-12  # of a cell's size: how far corners of a plane face may lie off it
UPRIGHT = 1.0e-12  # cosine of two faces at right angles

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
    import overlap

    element = {"hexahedron": overlap.Hexahedron, "wedge": overlap.Wedge, "tetra": overlap.Tetrahedron}[kind]
    turned, planes = _right_side_out(kind, corners), planes_of(kind, corners)
    body = cache(lambda cell: element(turned[cell]))
    volume, of_cell = np.zeros(len(corners)), planes.volume.copy()
    for index in np.flatnonzero(~planes.plain).tolist():
        of_cell[index] = body(index).volume
    for sphere, cell in _close_pairs(position, radius, corners):
        share = closed_forms(position[sphere], radius[sphere], planes, cell)
        for index in np.flatnonzero(np.isnan(share)).tolist():
            ball = overlap.Sphere(position[sphere[index]], float(radius[sphere[index]]))
            share[index] = overlap.overlap_volume(ball, body(int(cell[index])))
        volume += np.bincount(cell, share, minlength=len(volume))
    return volume, of_cell


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


def closed_forms(
    position: Float64Array, radius: Float64Array, planes: Planes, cell: Int64Array
) -> Float64Array:
    """Return the volume of each sphere in its cell where a closed form has it, NaN elsewhere.

    Args:
        position: Sphere centres [m], shape (P, 3).
        radius: Sphere radii [m], shape (P,).
        planes: The planes of all cells.
        cell: The cell of each pair, shape (P,).

    Returns:
        Volumes [m3], shape (P,), float64.
    """
    normal = planes.normal[cell]
    depth = planes.offset[cell] - np.einsum("pfi,pi->pf", normal, position - planes.middle[cell])
    depth /= radius[:, None]
    cutting = depth < 1.0
    count = np.where(planes.plain[cell], cutting.sum(axis=1), -1)
    share = np.full(len(cell), np.nan)
    share[count == 0] = cuts.BALL
    share[(depth <= -1.0).any(axis=1) & (count >= 0)] = 0.0
    left = np.isnan(share)
    # What lies below a plane at x = a is what lies above its mirror image at -a.
    order = np.argsort(~cutting, axis=1, kind="stable")[:, :3]
    above, across = (
        -np.take_along_axis(depth, order, axis=1),
        np.take_along_axis(normal, order[:, :, None], axis=1),
    )
    one, two, three = (left & (count == number) for number in (1, 2, 3))
    upright = np.abs(np.einsum("pi,pi->p", across[:, 0], across[:, 1])) < UPRIGHT
    share[one] = cuts.cap(above[one, 0])
    two &= upright
    share[two] = cuts.wedge(above[two, 0], above[two, 1])
    for first in (0, 1):
        upright &= np.abs(np.einsum("pi,pi->p", across[:, first], across[:, 2])) < UPRIGHT
    three &= upright
    share[three] = cuts.corner(*(above[three, each] for each in range(3)))
    return share * radius**3


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
