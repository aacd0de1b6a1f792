"""Turns shapes into the table of wall features that the loops work on, and a map of which ones are near."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import (
    BALL,
    CENTER_PLANE,
    CONE,
    FEATURE_WIDTH,
    PLANE,
    TRIANGLE,
    Features,
)
from packgen.arrange.space.map_kernels import (
    FeatureMap,
    Grid,
    WallList,
    map_features,
    map_triangles,
    merged_maps,
    wall_candidates,
)
from packgen.arrange.space.seams import NO_SEAMS, Seams
from packgen.arrays import Float64Array, Int32Array, Int64Array, unique_rows
from packgen.compiled import inlined
from packgen.geometry import Ball, Box, Cone, Mesh, Polyhedron, Shape, Slice, Surface
from packgen.portable import cube_root

MAP_CELLS_MAX = 300_000
MESH_MAP_CELLS_MAX = 4_000_000

MAP_REACH = 1.9
"""Reach of the map in largest radii: a sphere, its gap, and half of the widest skin."""


class WallTable(NamedTuple):
    """The features that bound a group of spheres, and where the space between them wraps around.

    Attributes:
        features: The features.
        near: Which of them are near a point.
        reach: Every feature closer than this to a point is listed in the point's cell [m].
        seams: The periods of a periodic box.
    """

    features: Features
    near: FeatureMap
    reach: float
    seams: Seams = NO_SEAMS


def wall_table(
    shapes: Sequence[Shape | Slice],
    bounds: Float64Array,
    radius_max: float,
    seams: Seams = NO_SEAMS,
) -> WallTable:
    """Return the features of an intersection of shapes.

    Args:
        shapes: Container and location; a sphere has to be inside all of them.
        bounds: Lower and upper corner of the space that the spheres stay in [m], shape (2, 3).
        radius_max: Largest radius that will meet these walls [m].
        seams: Where the first of the shapes, a box, wraps around and has no walls.

    Returns:
        The table.
    """
    parts = [_features(shape, seams if index == 0 else NO_SEAMS) for index, shape in enumerate(shapes)]
    kind = np.concatenate([part[0] for part in parts])
    row = np.concatenate([part[1] for part in parts])
    meshed = bool((kind == TRIANGLE).any())
    reach = MAP_REACH * radius_max
    grid = _map_grid(bounds, radius_max, meshed)
    flat, curved = np.flatnonzero(kind == TRIANGLE), np.flatnonzero(kind != TRIANGLE)
    start, item = map_features(Features(kind[curved], row[curved]), grid, reach)
    item = curved[item].astype(np.int32)
    if meshed:
        others = map_triangles(row[flat], grid, reach)
        start, item = merged_maps(start, item, others[0], flat.astype(np.int32)[others[1]])
    return WallTable(
        Features(kind, row), FeatureMap(grid, start, item, curved.astype(np.int32)), reach, seams
    )


@inlined
def walls_in_reach(
    ball: Float64Array, margin: Float64Array, walls: WallTable, before: WallList
) -> tuple[Int64Array, Int32Array, Float64Array]:
    """List the wall features that each moving sphere can reach before the next rebuild.

    Args:
        ball: Centres and radii [m], shape (N, 4), C-contiguous; the first ones move.
        margin: How far each moving sphere moves at most until then [m], shape (moving,).
        walls: The walls.
        before: The list before, whose arrays are written over where they are long enough.

    Returns:
        The arrays of a ``WallList``; of triangles a sphere's nearest one comes first.
    """
    begin = np.empty(len(margin) + 1, np.int64)
    item, room = before.item, before.room
    while wall_candidates(ball, margin, walls.features, walls.near, begin, item, room) < 0:
        length = max(2 * len(item), 2 * len(margin) + 4096)
        item, room = np.empty(length, np.int32), np.empty(length)
    return begin, item, room


def no_walls() -> WallList:
    """Return an empty list of walls."""
    return WallList(np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0))


def _map_grid(bounds: Float64Array, radius_max: float, meshed: bool) -> Grid:
    extent = bounds[1] - bounds[0]
    # Many triangles: finer cells, so that a sphere looks at few that it cannot touch.
    wanted, most = (1.5, MESH_MAP_CELLS_MAX) if meshed else (2.0, MAP_CELLS_MAX)
    size = max(wanted * radius_max, cube_root(float(np.prod(extent)) / most))
    return Grid(np.array(bounds[0]), size, np.floor(extent / size).astype(np.int64) + 1)


def _features(shape: Shape | Slice, seams: Seams) -> tuple[NDArray[np.int8], Float64Array]:
    """Return the features of one shape: kinds (F,) and rows (F, FEATURE_WIDTH)."""
    if isinstance(shape, Mesh):
        rows = _triangle_rows(shape.surface)
        return np.full(len(rows), TRIANGLE, np.int8), rows
    features = simple_features(shape, seams)
    row = np.zeros((len(features), FEATURE_WIDTH))
    for index, (_, numbers) in enumerate(features):
        row[index, : len(numbers)] = numbers
    return np.array([each[0] for each in features], np.int8), row


def simple_features(
    shape: Box | Cone | Ball | Polyhedron | Slice, seams: Seams
) -> list[tuple[int, Float64Array]]:
    """Return kind and numbers of each feature of a shape but a mesh; see ``wall_gap``."""
    if isinstance(shape, Box):
        return [
            (PLANE, np.append(sign * np.eye(3)[axis], sign * corner[axis]))
            for axis in range(3)
            if not seams.period[axis]
            for sign, corner in ((-1.0, shape.min), (1.0, shape.max))
        ]
    if isinstance(shape, Slice):
        kind = CENTER_PLANE if shape.centers_only else PLANE
        planes = ((-1.0, shape.low), (1.0, shape.high))
        return [(kind, np.append(sign * shape.axis, sign * at)) for sign, at in planes if np.isfinite(at)]
    if isinstance(shape, Cone):
        return _cone_features(shape)
    if isinstance(shape, Ball):
        return [(BALL, np.append(shape.center, shape.radius))]
    return [(PLANE, row) for row in np.column_stack([shape.normal, shape.offset])]


def _cone_features(cone: Cone) -> list[tuple[int, Float64Array]]:
    slope = cone.radius_top - cone.radius_bottom
    length = math.sqrt(cone.height * cone.height + slope * slope)
    cosine, sine = cone.height / length, slope / length
    lateral = np.concatenate([cone.base, cone.axis, [cone.radius_bottom, cosine, sine]])
    low = float((cone.axis * cone.base).sum())
    ends = [np.append(-cone.axis, -low), np.append(cone.axis, low + cone.height)]
    return [(CONE, lateral), *((PLANE, end) for end in ends)]


def _triangle_rows(surface: Surface) -> Float64Array:
    """Return corners and inward normal of each triangle, once where a sheet has one on either side."""
    first, _ = unique_rows(np.sort(surface.faces, axis=1))
    corners = surface.vertices[surface.faces[np.sort(first)]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    return np.concatenate([corners.reshape(-1, 9), -normal], axis=1)
