"""How many facets a sphere can have near it: LIGGGHTS makes room for 2,000, and stops at more."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import Float64Array

if TYPE_CHECKING:
    from exporters.walls.facets import Facets

NEIGHBORS_USUAL = 2000
"""Neighbours of one sphere that LIGGGHTS makes room for (LIGGGHTS manual, page "neigh_modify", ``one``)."""

PAGE_USUAL = 100_000
"""Room for the neighbours of many; at least ten times that of one (the same page, ``page``)."""


def neighbor_room(facets: Facets | None, radius_max: float, skin: float) -> tuple[int, int]:
    """Return what ``neigh_modify`` is to be given as ``one`` and ``page``.

    All facets near one sphere are near each other, so that the most crowded place of the wall bounds them.

    Args:
        facets: The wall; None: there is none.
        radius_max: Largest radius [m].
        skin: Distance from a sphere within which facets are listed [m].
    """
    if facets is None or len(facets.triangles) <= NEIGHBORS_USUAL:
        return NEIGHBORS_USUAL, PAGE_USUAL
    most = _facets_together(facets.triangles, 2.0 * (radius_max + skin))
    one = max(NEIGHBORS_USUAL, most)
    return one, max(PAGE_USUAL, 10 * one)


def _facets_together(triangles: Float64Array, across: float) -> int:
    """Return the largest number of facets, (F, 3, 3), of which parts may lie within a ball of a diameter."""
    from scipy.spatial import cKDTree

    middle = 0.5 * (triangles.min(axis=1) + triangles.max(axis=1))
    extent = 0.5 * np.linalg.norm(np.ptp(triangles, axis=1), axis=1)
    usual = float(np.quantile(extent, 0.9))
    # The few facets that are much larger than most count wherever they are.
    large = extent > 2.0 * usual
    places = middle[~large]
    reach = across + 4.0 * usual
    # One facet a cell stands for all of its cell.
    cell = 0.25 * reach
    _, first = np.unique(np.floor(places / cell), axis=0, return_index=True)
    found = cKDTree(places).query_ball_point(places[first], reach + np.sqrt(3.0) * cell, return_length=True)
    return int(large.sum()) + int(found.max())
