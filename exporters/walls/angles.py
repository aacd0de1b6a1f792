"""Angles of facets and between them: what is one smooth wall, and which corners spheres can meet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exporters.walls.edges import edges_of, shared_edges
from packgen.arrays import BoolArray, Float64Array
from packgen.geometry import Surface

SMOOTH_ANGLE_DEFAULT = 0.2562  # degrees; LIGGGHTS' own


SMOOTH_ANGLE_MAX = 30.0  # degrees; a sharper edge is a true edge, not part of a curve


def smallest_angles(vertices: Float64Array, faces: NDArray[np.int64]) -> Float64Array:
    """Return the smallest angle of each facet [degrees], 0 of a degenerate one, shape (F,)."""
    return np.asarray(corner_angles(Surface(vertices, faces)).min(axis=1, initial=180.0))


def smooth_angle(surface: Surface, both_sides: BoolArray | None = None) -> float:
    """Return the angle between neighbouring facets up to which they are one smooth wall [degrees].

    It is a little more than the largest angle below 30 degrees of the hollow edges (seen from inside the
    container), yet less than the smallest angle of the edges that protrude into it.

    Args:
        surface: The facets.
        both_sides: Which of them have spheres on either side, shape (F,): all their edges protrude from one.
    """
    angle, protrudes = edge_angles(surface, both_sides)
    hollow = angle[~protrudes & (angle <= SMOOTH_ANGLE_MAX)]
    ridge = angle[protrudes & (angle > SMOOTH_ANGLE_DEFAULT)]
    wanted = 1.02 * float(hollow.max(initial=0.0)) + 0.05
    return max(SMOOTH_ANGLE_DEFAULT, min(wanted, 0.98 * float(ridge.min(initial=np.inf))))


def exposed_corners(surface: Surface, both_sides: BoolArray) -> BoolArray:
    """Return which corners of the facets, shape (F, 3), spheres can meet: those of sheets, and tips.

    A tip is where three edges or more protrude; along a ridge, two meet.

    Args:
        surface: The facets.
        both_sides: Which of them have spheres on either side, shape (F,).
    """
    angle, protrudes = edge_angles(surface, both_sides)
    sides, _ = shared_edges(surface.faces)
    ridge = edges_of(surface.faces).reshape(-1, 2)[sides[protrudes & (angle > SMOOTH_ANGLE_DEFAULT)]]
    tip = np.bincount(ridge.ravel(), minlength=len(surface.vertices)) >= 3
    exposed: BoolArray = tip[surface.faces] | both_sides[:, None]
    return exposed


def corner_angles(surface: Surface) -> Float64Array:
    """Return the angle of each facet at each of its corners [degrees], shape (F, 3)."""
    corners = surface.vertices[surface.faces]
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(ahead, behind), axis=2)
    return np.asarray(np.degrees(np.arctan2(sine, (ahead * behind).sum(axis=2))))


def edge_angles(surface: Surface, both_sides: BoolArray | None = None) -> tuple[Float64Array, BoolArray]:
    """Return the angle between the normals of the two facets at each shared edge.

    Args:
        surface: The facets.
        both_sides: Which of them have spheres on either side, shape (F,).

    Returns:
        The angles [degrees], shape (E,), and whether the edge protrudes into the volume, shape (E,).
    """
    sides, others = shared_edges(surface.faces)
    start = edges_of(surface.faces).reshape(-1, 2)[sides, 0]
    first, second = sides // 3, others // 3
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    sine = np.linalg.norm(np.cross(normal[first], normal[second]), axis=1)
    angle = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", normal[first], normal[second])))
    # An edge protrudes when the far corner of one facet lies outside the plane of the other.
    far = corners[second] - surface.vertices[start][:, None]
    protrudes = np.einsum("ikj,ij->ik", far, normal[first]).sum(axis=1) > 0
    if both_sides is not None:
        protrudes |= both_sides[first] & both_sides[second]
    return angle, protrudes
