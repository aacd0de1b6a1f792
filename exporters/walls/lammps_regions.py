"""The walls of a convex container as a LAMMPS region that spheres touch from inside.

Reference: LAMMPS manual, pages "region" and "fix wall/gran/region". A region of several planes is their
``intersect``; a sphere touches a plane where the foot of its centre on the plane is inside all the others, so
that two planes that are the same but for rounding would push twice: `convex_planes` makes them one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.errors import ExportError
from packgen.geometry import Ball, Box, Cone, Container, Mesh, Polyhedron

SAME_NORMAL = 1.0e-4  # radians; planes closer than that, and at the same distance, are one wall
SAME_OFFSET = 1.0e-5  # of the container's size
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
        return _plane_regions(container, shape)
    assert isinstance(shape, Mesh)
    raise ExportError(
        "lammps: the container is not convex, and LAMMPS has no walls of triangles; export it for liggghts or"
        " yade, or take `shape: convex_hull` if the hull will do"
    )


def check_parts(container: Container, wall_material: str) -> None:
    """Refuse walls whose named parts LAMMPS cannot have: its region is one wall, and convex.

    Args:
        container: The container.
        wall_material: Name of the material of the walls without a name.

    Raises:
        ExportError: A part makes the walls not convex, is to be removed, moves, or has a material of its own.
    """
    lines = []
    for each in container.parts:
        if isinstance(container.shape, Mesh):
            why, remedy = "walls with it are not convex, and LAMMPS has no walls of triangles", ""
        elif each.remove or each.motion is not None:
            key = "remove" if each.remove else "move"
            why, remedy = (
                f"LAMMPS has one wall all round, and cannot {key} a part of it",
                f"leave `{key}` out",
            )
        elif each.material != wall_material:
            why = f"its material is {each.material}, and LAMMPS has one wall all round"
            remedy = f"give it the material {wall_material}"
        else:
            continue
        advice = f", or {remedy}" if remedy else ""
        lines.append(f"lammps: wall {each.name}: {why}; export it for liggghts or yade{advice}")
    if lines:
        raise ExportError("\n".join(lines))


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


def _plane_regions(container: Container, shape: Polyhedron) -> tuple[tuple[str, ...], bool]:
    normal, offset = convex_planes(shape)
    there = _has_facets(container, normal, offset)
    normal, offset = normal[there], offset[there]
    if len(offset) > PLANES_MAX:
        raise ExportError(
            f"lammps: the container has {len(offset)} planes, expected at most {PLANES_MAX}; export it for"
            " liggghts, or take a coarser mesh"
        )
    # The foot of the container's centre on each plane: numbers no larger than they have to be.
    center = container.bounds.mean(axis=0)
    foot = center + (offset - normal @ center)[:, None] * normal
    names = ["wall"] if len(offset) == 1 else [f"wall_{index}" for index in range(len(offset))]
    lines = [
        f"region {name} plane {' '.join(map(repr, point))} {' '.join(map(repr, inward))} side in"
        for name, point, inward in zip(names, foot.tolist(), (-normal).tolist(), strict=True)
    ]
    if len(names) > 1:
        # A line of input goes on after "&".
        parts = [" ".join(names[start : start + 10]) for start in range(0, len(names), 10)]
        lines.append(f"region wall intersect {len(names)} " + " &\n    ".join(parts) + " side in")
    return tuple(lines), not there.all()


def convex_planes(shape: Polyhedron) -> tuple[Float64Array, Float64Array]:
    """Return the planes of a polyhedron, those that are the same but for rounding once.

    Returns:
        Outward unit normals (P, 3), and offsets [m] (P,); the innermost of equal planes.
    """
    size = float(np.ptp(shape.surface.vertices, axis=0).max())
    center = shape.surface.vertices.mean(axis=0)
    distance = shape.offset - shape.normal @ center
    kept: list[int] = []
    for index in np.argsort(distance, kind="stable"):
        same = (np.linalg.norm(shape.normal[kept] - shape.normal[index], axis=1) < SAME_NORMAL) & (
            np.abs(distance[kept] - distance[index]) < SAME_OFFSET * size
        )
        if not same.any():
            kept.append(int(index))
    kept.sort()
    return shape.normal[kept], shape.offset[kept]


def _has_facets(
    container: Container, normal: Float64Array, offset: Float64Array
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return which planes have facets of the surface on them: an open top has none."""
    vertices, faces = container.surface.vertices, container.surface.faces
    slack = 10 * SAME_OFFSET * float(np.ptp(vertices, axis=0).max())
    return np.array(
        [
            bool((np.abs(vertices @ each - distance) <= slack)[faces].all(axis=1).any())
            for each, distance in zip(normal, offset, strict=True)
        ]
    )
