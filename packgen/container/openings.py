"""Why a mesh is no vessel: where it is open, welded or crossing itself, in words that say what to do."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array
from packgen.container.topology import boundary_edges, branching_edges
from packgen.errors import GeometryError
from packgen.geometry import Surface

LISTED = 3
"""Most openings that are described one by one."""

CRACK = 1.0e-2
"""Largest distance of corners of open edges that are one unmerged corner, as a fraction of the extent."""

EXPECTED = "expected a closed surface or one open at its top only"

STEEP = 0.7
"""Cosine between a rim's normal and gravity above which the rim is the top of its vessel, cut aslant."""

LEVEL = 1.0e-6
"""Largest difference in height of the corners of a level rim, as a fraction of the extent."""


def why_no_vessel(surface: Surface, up: Float64Array) -> str:
    """Return why a mesh bounds nothing that could be filled, and what to do.

    Args:
        surface: A mesh none of whose parts is closed, or open at its top only.
        up: Unit vector against gravity, shape (3,).

    Returns:
        The end of a sentence that begins with the file's name.
    """
    welded, edges = branching_edges(surface), boundary_edges(surface)
    if len(welded):
        x, y, z = surface.vertices[welded].reshape(-1, 3).mean(axis=0)
        return (
            f"has {len(welded)} edges at which three or more facets meet, around x={x:.4g} y={y:.4g} "
            f"z={z:.4g} m: an inner wall is welded to the shell there; expected a shell and inner "
            "walls apart from it: end that wall short of the shell, by much less than a sphere; or, if it "
            "is cracks that look like a wall, merge corners that nearly coincide"
        )
    if len(edges) == 0:
        return (
            "is closed but encloses no volume: it crosses itself or lies on itself, so that its parts "
            "cancel; expected a surface with an inside: repair it"
        )
    openings = _openings(surface, edges)
    extent = float(np.ptp(surface.vertices, axis=0).max())
    gap = _crack_width(surface, edges)
    if len(openings) > LISTED and gap < CRACK * extent:
        return (
            f"has holes: cracks along {len(edges):,} edges, whose corners are {gap:.2g} m apart where they "
            f"should be one; {EXPECTED}: merge corners by that distance"
        )
    return f"has holes ({_listed(surface, openings)}); {_remedy(surface, openings, up, extent)}"


def refuse_open(surface: Surface, said: Callable[[int], str]) -> None:
    """Refuse a surface that is open anywhere.

    Args:
        surface: The surface.
        said: What the message begins with, from the number of open edges.

    Raises:
        GeometryError: It is open.
    """
    edges = boundary_edges(surface)
    if len(edges):
        x, y, z = surface.vertices[edges].reshape(-1, 3).mean(axis=0)
        raise GeometryError(
            f"{said(len(edges))} around x={x:.4g} y={y:.4g} z={z:.4g} m, expected a closed surface, which "
            "tells inside from outside; close it"
        )


def _openings(surface: Surface, edges: Int64Array) -> list[Int64Array]:
    """Return the open edges of each opening, the longest rim first, shape (E, 2) each."""
    count = len(surface.vertices)
    graph = coo_array((np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    numbers = np.unique(part[edges[:, 0]])
    loops = [edges[part[edges[:, 0]] == number] for number in numbers]
    ends = surface.vertices
    length = [float(np.linalg.norm(ends[loop[:, 0]] - ends[loop[:, 1]], axis=1).sum()) for loop in loops]
    return [loops[index] for index in np.argsort(length)[::-1]]


def _crack_width(surface: Surface, edges: Int64Array) -> float:
    """Return the distance from a corner of open edges to the next such corner [m]: the ninth decile."""
    corners = surface.vertices[np.unique(edges)]
    if len(corners) < 2:
        return np.inf
    distance = np.asarray(cKDTree(corners).query(corners, k=2)[0])
    return float(np.quantile(distance[:, 1], 0.9))


def _listed(surface: Surface, openings: list[Int64Array]) -> str:
    texts = []
    for loop in openings[:LISTED]:
        corners = surface.vertices[np.unique(loop)]
        x, y, z = corners.mean(axis=0)
        width = float(np.ptp(corners, axis=0).max())
        texts.append(f"{len(loop)} boundary edges around x={x:.4g} y={y:.4g} z={z:.4g} m, {width:.4g} m wide")
    if len(openings) > LISTED:
        texts.append(f"{len(openings) - LISTED} more")
    return "; ".join(texts)


def _remedy(surface: Surface, openings: list[Int64Array], up: Float64Array, extent: float) -> str:
    if len(openings) > 1:
        return f"{EXPECTED}: close all but the top one"
    height, rim = surface.vertices @ up, surface.vertices[np.unique(openings[0])]
    across = np.linalg.svd(rim - rim.mean(axis=0))[2][2]  # normal of the rim's plane
    at_top = height.max() - (rim @ up).max() <= LEVEL * extent
    if at_top and abs(float(across @ up)) > STEEP:
        low, high = (rim @ up).min(), (rim @ up).max()
        return (
            f"{EXPECTED}, its rim level: this one goes from {low:.4g} to {high:.4g} m in height; cut it "
            "level, or close it"
        )
    return f"{EXPECTED}: close it, or if that opening is the top, turn the mesh or `gravity_axis`"
