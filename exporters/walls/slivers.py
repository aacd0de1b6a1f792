"""Facets too narrow for a solver, made wider: their flat part of the wall is triangulated anew.

A cone that ends in a narrow flat tip, triangulated from end to end, has facets as long as the cone and as
wide as a facet of the tip. LIGGGHTS refuses them. Without them the wall has hairlines, and worse, the facets
on either side are no neighbours any more, so that a sphere above the hairline is pushed by both. Here the
edges of the flat part are divided into pieces in proportion to the width of its narrowest facet, and all is
triangulated through these points (Delaunay). The surface stays where it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exporters.walls.edges import edge_uses, edges_of, shared_edges

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]

FLAT = 1.0e-3  # radians from facet to facet: single precision leaves a narrow facet turned by less
ASPECT = 400.0  # length of an edge's pieces, in widths of the narrow facet: angles of 0.14 degrees
ASPECT_OF_CORNERS = 3.0  # the same where corners have to be kept: angles of 18 degrees
PIECES_MAX = 200  # pieces of one edge
AREA_LEAST = 1.0e-9  # smallest area of a facet, over the square of its longest side
AREA_ERROR_MAX = 1.0e-5  # of a part's area; a part that is not convex gains more and stays as it is


def widened(
    vertices: Float64Array, faces: Int64Array, narrow: NDArray[np.bool_], aspect: float = ASPECT
) -> tuple[Float64Array, Int64Array, Int64Array]:
    """Return a surface without the narrow facets of its flat, convex parts.

    Args:
        vertices: Corner positions [m], shape (V, 3), each position once.
        faces: Corner indices, shape (F, 3).
        narrow: Which facets are too narrow, shape (F,).
        aspect: Length that the edges' pieces get at most, in widths of the narrowest facet of a part.

    Returns:
        (corners, those given first; faces; a given facet of the part that each of them lies in); unchanged
        where no facet is narrow.
    """
    if not narrow.any():
        return vertices, faces, np.arange(len(faces))
    part = _flat_parts(vertices, faces)
    pieces = _pieces_of_edges(vertices, faces, part, narrow, aspect)
    vertices, between = _divided(vertices, pieces)
    kept, made, origin = np.ones(len(faces), dtype=bool), [], []
    for number in np.unique(part[_touched(faces, between)]):
        members = np.flatnonzero(part == number)
        outline = [
            point
            for edge in _outline(faces[members])
            for point in (*edge, *between.get(tuple(sorted(edge)), ()))
        ]
        triangles = _triangulated(vertices, faces[members], np.unique(outline))
        if triangles is not None:
            kept[members] = False
            made.append(triangles)
            origin.append(np.full(len(triangles), members[0]))
    return (
        vertices,
        np.concatenate([faces[kept], *made]),
        np.concatenate([np.flatnonzero(kept), *origin]),
    )


def _flat_parts(vertices: Float64Array, faces: Int64Array) -> Int64Array:
    """Return the number of the flat part that each facet belongs to, shape (F,)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0)
    first, second = _neighbors(faces)
    flat = np.linalg.norm(np.cross(normal[first], normal[second]), axis=1) < FLAT
    ends = first[flat], second[flat]
    joined = coo_matrix((np.ones(len(ends[0])), ends), shape=(len(faces), len(faces)))
    part: Int64Array = connected_components(joined, directed=False)[1].astype(np.int64)
    return part


def _neighbors(faces: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Return the facets on either side of each edge that two facets share."""
    sides, others = shared_edges(faces)
    return sides // 3, others // 3


def _outline(faces: Int64Array) -> list[tuple[int, int]]:
    """Return the edges that belong to one of some facets only."""
    outer = edges_of(faces)[edge_uses(faces) == 1]
    return [(a, b) for a, b in outer.tolist()]


def _pieces_of_edges(
    vertices: Float64Array, faces: Int64Array, part: Int64Array, narrow: NDArray[np.bool_], aspect: float
) -> dict[tuple[int, int], int]:
    """Return the number of pieces of each edge around parts with narrow facets."""
    pieces: dict[tuple[int, int], int] = {}
    for number in np.unique(part[narrow]):
        if np.count_nonzero(part == number) < 2:
            continue
        corners = vertices[faces[narrow & (part == number)]]
        side = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        width = float(side.min())
        for edge in _outline(faces[part == number]):
            length = float(np.linalg.norm(vertices[edge[1]] - vertices[edge[0]]))
            count = min(int(np.ceil(length / (aspect * width))), PIECES_MAX)
            if count > 1:
                pieces[edge] = max(count, pieces.get(edge, 1))
    return pieces


def _divided(
    vertices: Float64Array, pieces: dict[tuple[int, int], int]
) -> tuple[Float64Array, dict[tuple[int, ...], tuple[int, ...]]]:
    """Return the corners with the points that divide edges, and the indices of those of each edge."""
    points, between, count = [vertices], {}, len(vertices)
    for edge, number in pieces.items():
        share = np.arange(1, number)[:, None] / number
        points.append(vertices[edge[0]] + share * (vertices[edge[1]] - vertices[edge[0]]))
        between[edge] = tuple(range(count, count + number - 1))
        count += number - 1
    return np.concatenate(points), {tuple(edge): found for edge, found in between.items()}


def _touched(faces: Int64Array, between: dict[tuple[int, ...], tuple[int, ...]]) -> NDArray[np.bool_]:
    """Return which facets have a divided edge, shape (F,)."""
    edges = edges_of(faces).tolist()
    return np.array([any(tuple(edge) in between for edge in each) for each in edges], dtype=bool)


def _triangulated(vertices: Float64Array, faces: Int64Array, points: Int64Array) -> Int64Array | None:
    """Return facets of a flat part through points on its outline; None where it is not convex."""
    from scipy.spatial import Delaunay, QhullError

    corners = vertices[faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = area.sum(axis=0) / np.linalg.norm(area.sum(axis=0))
    across = np.linalg.svd(normal[None, :])[2][1:]
    if np.dot(np.cross(across[0], across[1]), normal) < 0:
        across = across[::-1]
    plane = (vertices[points] - vertices[points[0]]) @ across.T
    try:
        triangles = Delaunay(plane).simplices.astype(np.int64)
    except QhullError:  # a part without area
        return None
    first, second, third = (plane[triangles[:, index]] for index in range(3))
    twice = (second - first)[:, 0] * (third - first)[:, 1] - (second - first)[:, 1] * (third - first)[:, 0]
    triangles[twice < 0] = triangles[twice < 0][:, ::-1]
    # Points along a straight edge are in line but for rounding: facets without area between them are left
    # out.
    side = np.stack([second - first, third - second, first - third], axis=1)
    triangles = triangles[np.abs(twice) > AREA_LEAST * (side**2).sum(axis=2).max(axis=1)]
    wanted = float(np.linalg.norm(area, axis=1).sum())
    if abs(float(np.abs(twice).sum()) - wanted) > AREA_ERROR_MAX * wanted:
        return None
    found: Int64Array = points[triangles]
    return found
