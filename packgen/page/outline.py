"""Lines that show a surface in a page's view: its edges, and cuts through what is round."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry import Surface
from packgen.page.spheres import upright_frame

__all__ = ["CONTAINER", "line_data", "outline", "section"]

CONTAINER = "#5b6470"
"""Colour of a container's outline."""

EDGE = 0.9
"""Cosine of the angle between two facets from which their common side is an edge: 26 degrees."""

ROUND = 40
"""Number of facets from which a surface may be round, so that edges alone do not show it."""

LINES_MAX = 6_000
"""Most lines of a surface; of more, the longest are shown."""


def outline(surface: Surface, up: Float64Array) -> Float64Array:
    """Return lines that show a surface.

    Args:
        surface: Triangles.
        up: Unit vector against gravity, shape (3,).

    Returns:
        Ends of the lines [m], shape (L, 2, 3), float64.
    """
    lines = [_edges(surface)]
    if len(surface.faces) >= ROUND:
        vertices = surface.vertices
        middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        lines += [section(surface, normal, float(normal @ middle)) for normal in upright_frame(up)]
    found = np.concatenate(lines)
    if len(found) > LINES_MAX:
        length = np.linalg.norm(found[:, 1] - found[:, 0], axis=1)
        found = found[np.sort(np.argsort(-length, kind="stable")[:LINES_MAX])]
    return found


def section(surface: Surface, normal: Float64Array, level: float) -> Float64Array:
    """Return the lines in which a plane cuts a surface.

    Args:
        surface: Triangles.
        normal: Unit normal of the plane, shape (3,).
        level: Where it is along that [m].

    Returns:
        Ends of the lines [m], shape (L, 2, 3), float64.
    """
    corners = surface.vertices[surface.faces]
    above = corners @ normal - level
    crossed = (above > 0.0).any(axis=1) & (above <= 0.0).any(axis=1)
    corners, above = corners[crossed], above[crossed]
    # Each triangle that is cut has one corner alone on its side.
    high = above > 0.0
    alone = np.where(high.sum(axis=1) == 1, high.argmax(axis=1), (~high).argmax(axis=1))
    row = np.arange(len(corners))
    tip, depth = corners[row, alone], above[row, alone]
    ends = []
    for step in (1, 2):
        other = (alone + step) % 3
        share = depth / (depth - above[row, other])
        ends.append(tip + share[:, None] * (corners[row, other] - tip))
    return np.stack(ends, axis=1)


def line_data(
    name: str, colour: str, lines: Float64Array, up: Float64Array, middle: Float64Array
) -> dict[str, Any]:
    """Return lines as a page's view reads them.

    Args:
        name: What the legend calls them.
        colour: Their colour, such as ``#5b6470``.
        lines: Ends [m], shape (L, 2, 3).
        up: Unit vector against gravity, shape (3,).
        middle: Middle of the view in its own frame [m], shape (3,).

    Returns:
        ``name``, ``colour``, and ``ends`` as base64 of float32, shape (L, 2, 3), in the view's frame.
    """
    ends = lines @ upright_frame(up).T - middle
    text = base64.b64encode(np.ascontiguousarray(ends, "<f4").tobytes()).decode("ascii")
    return {"name": name, "colour": colour, "ends": text}


def _edges(surface: Surface) -> Float64Array:
    """Return sides of triangles where facets meet at an angle, or where one ends, shape (L, 2, 3)."""
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    side = np.sort(
        np.concatenate([surface.faces[:, [0, 1]], surface.faces[:, [1, 2]], surface.faces[:, [2, 0]]])
    )
    face = np.tile(np.arange(len(surface.faces)), 3)
    order = np.lexsort((side[:, 1], side[:, 0]))
    side, face = side[order], face[order]
    first = np.flatnonzero(np.append(True, (side[1:] != side[:-1]).any(axis=1)))
    count = np.diff(np.append(first, len(side)))
    flat = np.zeros(len(first), dtype=bool)
    pair = count == 2
    one, two = face[first[pair]], face[first[pair] + 1]
    flat[pair] = np.einsum("ij,ij->i", normal[one], normal[two]) > EDGE
    return np.asarray(surface.vertices[side[first[~flat]]])
