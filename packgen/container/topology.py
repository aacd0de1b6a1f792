"""Edges of a surface: is it closed, is it open at the top only, does its winding agree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int64Array, unique_rows
from packgen.errors import GeometryError
from packgen.geometry import Surface


@dataclass(frozen=True, slots=True)
class Rim:
    """The opening of a surface: its boundary edges, and the height (against gravity) of their lowest one."""

    edges: Int64Array
    height: float
    level: bool


def boundary_edges(surface: Surface) -> Int64Array:
    """Return the edges that belong to one triangle only, directed as in it, shape (E, 2)."""
    faces = surface.faces
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    _, kind = unique_rows(np.sort(directed, axis=1))
    return np.asarray(directed[np.bincount(kind)[kind] == 1])


def branching_edges(surface: Surface) -> Int64Array:
    """Return the edges at which three or more triangles meet, shape (E, 2)."""
    ends = np.sort(surface.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    first, kind = unique_rows(ends)
    return np.asarray(ends[first[np.bincount(kind) > 2]])


def find_rim(surface: Surface, up: Float64Array) -> Rim | None:
    """Return the surface's opening, or None where it is closed.

    Args:
        surface: The surface.
        up: Unit vector against gravity, shape (3,).

    Returns:
        The opening; ``level`` tells whether all its edges lie at one height at the very top.
    """
    edges = boundary_edges(surface)
    if len(edges) == 0:
        return None
    height = surface.vertices @ up
    rim = height[edges.ravel()]
    slack = 1e-6 * float(np.ptp(surface.vertices, axis=0).max())
    level = float(np.ptp(rim)) <= slack and float(height.max() - rim.min()) <= slack
    return Rim(edges, float(rim.min()), level)


def capped(surface: Surface, rim: Rim) -> Surface:
    """Return a level-topped open surface with its lid: a fan from the middle of the rim."""
    center = surface.vertices[rim.edges.ravel()].mean(axis=0)
    vertices = np.vstack([surface.vertices, center])
    middle = np.full(len(rim.edges), len(surface.vertices), np.int64)
    lid = np.column_stack([rim.edges[:, 1], rim.edges[:, 0], middle])
    return Surface(vertices, np.concatenate([surface.faces, lid]))


def _is_consistent(surface: Surface) -> bool:
    """Return whether each edge of just two triangles is passed once in either direction."""
    edges = surface.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, edge = unique_rows(np.sort(edges, axis=1))
    upwards = np.bincount(edge, edges[:, 0] < edges[:, 1])
    return bool((upwards[np.bincount(edge) == 2] == 1.0).all())


def with_consistent_winding(surface: Surface) -> tuple[Surface, int]:
    """Return the surface with neighbouring triangles wound alike, and how many were turned.

    Raises:
        GeometryError: The surface has no consistent winding (a Moebius strip).
    """
    if _is_consistent(surface):
        return surface, 0
    import trimesh

    mesh = trimesh.Trimesh(surface.vertices, surface.faces.copy(), process=False)
    fix_winding: Any = trimesh.repair.fix_winding
    fix_winding(mesh)
    if not mesh.is_winding_consistent:
        raise GeometryError("the mesh has no inside: its facets cannot be wound consistently; repair it")
    faces = np.asarray(mesh.faces, np.int64)
    turned = int((faces != surface.faces).any(axis=1).sum())
    return Surface(surface.vertices, faces), turned
