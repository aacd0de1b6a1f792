"""Which parts close the openings of a surface, and the surface that they make with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import BoolArray, Int64Array, unique_rows
from packgen.container.shells import stacked
from packgen.container.stitching import SLACK, stitched_from
from packgen.container.topology import boundary_edges
from packgen.geometry import Surface

OWN = -1
"""The owner of the surface's own triangles."""


def closing_pieces(own: Surface, pieces: Sequence[Surface]) -> set[int]:
    """Return the pieces that share an open edge with a surface, or with another piece that does.

    Args:
        own: The surface.
        pieces: The pieces.
    """
    if len(boundary_edges(own)) == 0:
        return set()
    surface, owner = joined(own, dict(enumerate(pieces)))
    ends = np.sort(surface.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, edge = unique_rows(ends)
    of_edge = np.repeat(owner, 3)
    order = np.argsort(edge, kind="stable")
    twice: BoolArray = np.equal(np.bincount(edge)[edge[order]], 2)
    pairs = of_edge[order][twice].reshape(-1, 2)
    shared = {(int(a), int(b)) for a, b in pairs if a != b}
    found = {OWN}
    while True:
        more = {b for a, b in shared if a in found} | {a for a, b in shared if b in found}
        if more <= found:
            return found - {OWN}
        found |= more


def joined(own: Surface, pieces: Mapping[int, Surface]) -> tuple[Surface, Int64Array]:
    """Return a surface and pieces of it as one, without cracks between them, and the owner of each triangle.

    Args:
        own: The surface.
        pieces: The pieces by number.

    Returns:
        (the surface; the number of the piece of each of its triangles, `OWN` for its own, shape (F,)).
    """
    surfaces, owner = [own], [np.full(len(own.faces), OWN, np.int64)]
    extent = float(np.ptp(own.vertices, axis=0).max())
    for number, piece in pieces.items():
        corners = np.concatenate([each.vertices for each in surfaces])
        away, nearest = map(np.asarray, cKDTree(corners).query(piece.vertices))
        moved = np.where(away[:, None] <= SLACK * extent, corners[nearest], piece.vertices)
        surfaces.append(Surface(moved, piece.faces))
        owner.append(np.full(len(piece.faces), number, np.int64))
    surface, source = stitched_from(stacked(surfaces))
    return surface, np.concatenate(owner)[source]
