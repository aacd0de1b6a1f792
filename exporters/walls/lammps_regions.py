"""The walls of a convex container as a LAMMPS region that spheres touch from inside.

Reference: LAMMPS manual, pages "region" and "fix wall/gran/region". A region of several planes is their
``intersect``; a sphere touches a plane where the foot of its centre on the plane is inside all the others, so
that two planes that are the same but for rounding would push twice: `convex_planes` makes them one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.errors import ExportError
from packgen.geometry import Ball, Box, Cone, Container, Mesh, Polyhedron, Surface

SAME_NORMAL = 1.0e-4  # radians; planes closer than that, and at the same distance, are one wall
SAME_OFFSET = 1.0e-5  # of the container's size
NOT_CONVEX = (
    "lammps: the container is not convex, and LAMMPS has no walls of triangles; export it for liggghts or"
    " yade, or take `shape: convex_hull` if the hull will do"
)
PLANES_MAX = 3000  # LAMMPS tests each plane for each sphere: with more a deck is too slow to use

Float64Array = NDArray[np.float64]


def wall_regions(container: Container) -> tuple[tuple[str, ...], bool]:
    """Return the commands that make the region ``wall``, and whether it is open at the top.

    Raises:
        ExportError: The container is not convex, or is a shape that LAMMPS has no region for.
    """
    shape = container.shape
    if isinstance(shape, Box):
        sides = [
            "INF INF" if wraps else f"{low!r} {high!r}"
            for wraps, low, high in zip(
                container.periodic, shape.min.tolist(), shape.max.tolist(), strict=True
            )
        ]
        return (f"region wall block {' '.join(sides)} side in",), False
    if isinstance(shape, Ball):
        center = " ".join(repr(each) for each in shape.center.tolist())
        return (f"region wall sphere {center} {float(shape.radius)!r} side in",), False
    if isinstance(shape, Cone):
        return (_cone_region(shape),), False
    if isinstance(shape, Polyhedron):
        planes = planes_with_facets(shape, container.surface)
        center = container.bounds.mean(axis=0)
        return plane_commands("wall", planes.normal, planes.offset, center), planes.is_open
    assert isinstance(shape, Mesh)
    raise ExportError(NOT_CONVEX)


def _cone_region(cone: Cone) -> str:
    along = int(np.abs(cone.axis).argmax())
    if abs(cone.axis[along]) != 1.0:
        raise ExportError(
            "lammps: a cylinder or cone has to stand along x, y or z; turn the scene, or give the container"
            " as a mesh, which becomes planes"
        )
    slope = abs(cone.radius_top - cone.radius_bottom) / cone.height
    if slope >= np.tan(np.radians(60)):
        # LAMMPS takes twice the radius of the cone at the contact for the wall's curvature: in a flatter cone
        # a sphere at the tip gets a negative effective radius.
        raise ExportError(
            f"lammps: the cone opens by {np.degrees(np.arctan(slope)):.0f} degrees from its axis, expected"
            " less than 60; give the container as a mesh, which becomes planes"
        )
    start = float(cone.base[along])
    end = start + float(cone.axis[along]) * cone.height
    radii = (float(cone.radius_bottom), float(cone.radius_top))
    if end < start:
        start, end, radii = end, start, (radii[1], radii[0])
    across = " ".join(repr(float(cone.base[index])) for index in range(3) if index != along)
    if radii[0] == radii[1]:
        return f"region wall cylinder {'xyz'[along]} {across} {radii[0]!r} {start!r} {end!r} side in"
    return f"region wall cone {'xyz'[along]} {across} {radii[0]!r} {radii[1]!r} {start!r} {end!r} side in"


@dataclass(frozen=True, eq=False, slots=True)
class Planes:
    """The planes that hold the spheres of a convex container.

    Attributes:
        normal: Outward unit normals, shape (P, 3).
        offset: Distances from the origin along them [m], shape (P,).
        slack: How far off a plane its facets may be [m].
        is_open: Whether the container is open at its top.
    """

    normal: Float64Array
    offset: Float64Array
    slack: float
    is_open: bool


def planes_with_facets(shape: Polyhedron, surface: Surface) -> Planes:
    """Return the planes of a polyhedron that facets of a surface lie on: an open top has none."""
    normal, offset = convex_planes(shape)
    slack = 10 * SAME_OFFSET * float(np.ptp(surface.vertices, axis=0).max())
    there = on_planes(surface.vertices, surface.faces, Planes(normal, offset, slack, is_open=False))
    return Planes(normal[there], offset[there], slack, is_open=not there.all())


def on_planes(vertices: Float64Array, faces: NDArray[np.int64], planes: Planes) -> NDArray[np.bool_]:
    """Return which planes facets (F, 3) lie on, shape (P,)."""
    return np.array(
        [
            bool((np.abs(vertices @ each - distance) <= planes.slack)[faces].all(axis=1).any())
            for each, distance in zip(planes.normal, planes.offset, strict=True)
        ],
        np.bool_,
    )


def plane_commands(
    name: str, normal: Float64Array, offset: Float64Array, center: Float64Array
) -> tuple[str, ...]:
    """Return the commands that make a region of planes.

    Args:
        name: Its name.
        normal: Outward unit normals, shape (P, 3).
        offset: Distances from the origin along them [m], shape (P,).
        center: The middle of the container [m], shape (3,).

    Raises:
        ExportError: There are too many planes.
    """
    if len(offset) > PLANES_MAX:
        raise ExportError(
            f"lammps: the container has {len(offset)} planes, expected at most {PLANES_MAX}; export it for"
            " liggghts, or take a coarser mesh"
        )
    # The foot of the container's centre on each plane: numbers no larger than they have to be.
    foot = center + (offset - normal @ center)[:, None] * normal
    names = [name] if len(offset) == 1 else [f"{name}_{index}" for index in range(len(offset))]
    lines = [
        f"region {name} plane {' '.join(map(repr, point))} {' '.join(map(repr, inward))} side in"
        for name, point, inward in zip(names, foot.tolist(), (-normal).tolist(), strict=True)
    ]
    if len(names) > 1:
        # A line of input goes on after "&".
        parts = [" ".join(names[start : start + 10]) for start in range(0, len(names), 10)]
        lines.append(f"region {name} intersect {len(names)} " + " &\n    ".join(parts) + " side in")
    return tuple(lines)


def convex_planes(shape: Polyhedron) -> tuple[Float64Array, Float64Array]:
    """Return the planes of a polyhedron, those that are the same but for rounding once.

    Returns:
        Outward unit normals (P, 3), and offsets [m] (P,); the innermost of equal planes.
    """
    return same_planes_once(shape.normal, shape.offset, shape.surface.vertices)


def same_planes_once(
    normal: Float64Array, offset: Float64Array, vertices: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return planes, those that are the same but for rounding once, the innermost of them.

    Args:
        normal: Outward unit normals, shape (P, 3).
        offset: Distances from the origin along them [m], shape (P,).
        vertices: Corners of what they bound [m], shape (V, 3).
    """
    size = float(np.ptp(vertices, axis=0).max())
    center = vertices.mean(axis=0)
    distance = offset - normal @ center
    kept: list[int] = []
    for index in np.argsort(distance, kind="stable"):
        same = (np.linalg.norm(normal[kept] - normal[index], axis=1) < SAME_NORMAL) & (
            np.abs(distance[kept] - distance[index]) < SAME_OFFSET * size
        )
        if not same.any():
            kept.append(int(index))
    kept.sort()
    return normal[kept], offset[kept]
