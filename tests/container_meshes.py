"""Surfaces of vessels for the tests: revolved, swept and extruded, with and without internals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]


def joined(*parts: trimesh.Trimesh) -> trimesh.Trimesh:
    return trimesh.util.concatenate(parts)


def revolved(profile: Sequence[tuple[float, float]], facets: int = 48) -> trimesh.Trimesh:
    """Radius and height pairs round z: closed where the first and last radius are 0."""
    return trimesh.creation.revolve(np.array(profile, float), sections=facets)


def torus(tube: float = 0.4) -> trimesh.Trimesh:
    return trimesh.creation.torus(1.0, tube, major_sections=48, minor_sections=24)


def torus_volume(tube: float = 0.4) -> float:
    return 2.0 * math.pi**2 * tube**2


def standing(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    turned = mesh.copy()
    turned.apply_transform(trimesh.transformations.rotation_matrix(0.5 * math.pi, [1.0, 0.0, 0.0]))
    return turned


def u_bend(*, open_top: bool, radius: float = 0.35, facets: int = 24) -> trimesh.Trimesh:
    """Two upright arms of length 2 at x = -1 and 1, joined below by half a torus."""
    turn = np.linspace(0.0, math.pi, 25)[1:-1]
    path = [((-1.0, 0.0, z), (0.0, 0.0, -1.0)) for z in np.linspace(2.0, 0.0, 9)]
    path += [((-math.cos(t), 0.0, -math.sin(t)), (math.sin(t), 0.0, -math.cos(t))) for t in turn]
    path += [((1.0, 0.0, z), (0.0, 0.0, 1.0)) for z in np.linspace(0.0, 2.0, 9)]
    angle = 2.0 * math.pi * np.arange(facets) / facets
    rings = []
    for place, along in path:
        across = np.cross(along, [0.0, 1.0, 0.0])
        spokes = np.cos(angle)[:, None] * np.array([0.0, 1.0, 0.0]) + np.sin(angle)[:, None] * across
        rings.append(np.array(place) + radius * spokes)
    vertices = np.concatenate([*rings, [path[0][0]], [path[-1][0]]])
    here, there = np.arange(facets), (np.arange(facets) + 1) % facets
    faces = []
    for ring in range(len(rings) - 1):
        a, b = ring * facets + here, ring * facets + there
        faces += [np.column_stack([a, b, a + facets]), np.column_stack([b, b + facets, a + facets])]
    if not open_top:
        last, middle = (len(rings) - 1) * facets, len(rings) * facets
        faces.append(np.column_stack([np.full(facets, middle), there, here]))
        faces.append(np.column_stack([np.full(facets, middle + 1), last + here, last + there]))
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)


def u_bend_volume(radius: float = 0.35) -> float:
    return math.pi * radius**2 * (2.0 * 2.0 + math.pi)


def tank(*, open_top: bool, baffles: int = 4) -> trimesh.Trimesh:
    """A cylinder of radius 1 and height 2 with baffles of no thickness, 0.2 wide, that touch the wall."""
    profile = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)] + ([] if open_top else [(0.0, 2.0)])
    plates = []
    for angle in 2.0 * math.pi * np.arange(baffles) / max(baffles, 1):
        outward = np.array([math.cos(angle), math.sin(angle), 0.0])
        corners = [outward * r + [0.0, 0.0, z] for r, z in ((1.0, 0.1), (0.8, 0.1), (0.8, 1.9), (1.0, 1.9))]
        plates.append(trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False))
    return joined(revolved(profile), *plates)


def hopper(*, open_top: bool) -> trimesh.Trimesh:
    """A hopper with a non-convex insert hanging in it."""
    shell = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.3), (1.0, 1.3), (1.0, 2.3)] + ([] if open_top else [(0.0, 2.3)])
    insert = [(0.0, 0.9), (0.2, 1.2), (0.35, 1.2), (0.0, 1.7)]
    return joined(revolved(shell, 64), revolved(insert, 32))


def extruded(outline: Sequence[tuple[float, float]], faces: Sequence[tuple[int, int, int]], height: float,
             *, open_top: bool) -> trimesh.Trimesh:  # fmt: skip
    """An outline, counter-clockwise and triangulated, drawn up along z."""
    flat, count = np.array(outline, float), len(outline)
    vertices = np.vstack([np.column_stack([flat, np.full(count, z)]) for z in (0.0, height)])
    here, there = np.arange(count), (np.arange(count) + 1) % count
    bottom = np.array(faces)[:, ::-1]
    sides = [
        np.column_stack([here, there, there + count]),
        np.column_stack([here, there + count, here + count]),
    ]
    top = [] if open_top else [np.array(faces) + count]
    return trimesh.Trimesh(vertices, np.concatenate([bottom, *sides, *top]), process=False)


def l_box(*, open_top: bool) -> trimesh.Trimesh:
    """Two by two by 1.5 less a corner of one by one."""
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    return extruded(outline, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)], 1.5, open_top=open_top)


def saved(mesh: trimesh.Trimesh, folder: Path, name: str = "vessel.stl") -> str:
    """Write a mesh; return its name, which a scene in the same folder calls it by."""
    mesh.export(folder / name)
    return name
