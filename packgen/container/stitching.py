"""Seams of a mesh whose sides have different corners are stitched together."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Int64Array
from packgen.container.topology import boundary_edges
from packgen.geometry import Surface

STITCHES_MAX = 20
SLACK = 1.0e-6
"""Distance of corners that are one, and of a corner on an edge from it, as a fraction of the extent."""


def stitched(surface: Surface) -> Surface:
    """Return the surface without T-junctions: facets are divided where another's corner lies on their edge.

    Nothing moves: the surface as a set of points stays what it is, only cracks without width close.
    """
    return stitched_from(surface)[0]


def stitched_from(surface: Surface) -> tuple[Surface, Int64Array]:
    """Return what `stitched` does, and the given facet that each facet is a part of, shape (F,)."""
    extent = float(np.ptp(surface.vertices, axis=0).max())
    source = np.arange(len(surface.faces))
    for _ in range(STITCHES_MAX):
        edges = boundary_edges(surface)
        if len(edges) == 0:
            break
        divided = _divided(surface, edges, SLACK * extent)
        if divided is None:
            break
        surface, pieces = divided
        source = np.repeat(source, pieces)
    return surface, source


def _divided(surface: Surface, edges: Int64Array, slack: float) -> tuple[Surface, Int64Array] | None:
    """Return the surface with each open edge divided at one corner that lies on it; None where none does.

    Beside it the number of facets that each facet has become, in their order, shape (F,).
    """
    vertices = surface.vertices
    rim = np.unique(edges)
    tree = cKDTree(vertices[rim])
    ends = vertices[edges]
    middle, reach = ends.mean(axis=1), 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    split: dict[tuple[int, int], int] = {}
    for (a, b), near in zip(edges.tolist(), tree.query_ball_point(middle, reach), strict=True):
        candidates = rim[np.array(near, np.int64)]
        candidates = candidates[(candidates != a) & (candidates != b)]
        along = vertices[b] - vertices[a]
        length = float(np.linalg.norm(along))
        away = vertices[candidates] - vertices[a]
        place = away @ along / length
        off = np.linalg.norm(away - place[:, None] * (along / length), axis=1)
        on = np.flatnonzero((off <= slack) & (place > slack) & (place < length - slack))
        if len(on):
            split[a, b] = int(candidates[on[np.argmin(np.abs(place[on] - 0.5 * length))]])
    if not split:
        return None
    faces: list[list[int]] = []
    pieces = np.ones(len(surface.faces), np.int64)
    for index, face in enumerate(surface.faces.tolist()):
        for k in range(3):
            a, b, c = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            if (a, b) in split:
                faces += [[a, split[a, b], c], [split[a, b], b, c]]
                pieces[index] = 2
                break
        else:
            faces.append(face)
    return Surface(vertices, np.array(faces, np.int64)), pieces
