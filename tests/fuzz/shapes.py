"""Random bodies about one unit wide, and their mesh files in every format that is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from tests import container_meshes as meshes
from tests.fuzz.solids import Array, Ball, Box, Cone, Hull, Solid, Solidmesh

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
ODD = 0.07
FORMATS = ("stl", "stl_text", "off", "obj", "ply")


def random_direction(rng: np.random.Generator) -> Array:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def random_axis(rng: np.random.Generator) -> Array:
    """Return a unit vector, along an axis in three of four draws."""
    if rng.random() < 0.25:
        return random_direction(rng)
    return np.asarray(np.eye(3)[int(rng.integers(3))] * (1.0 if rng.random() < 0.5 else -1.0))


def odd(rng: np.random.Generator) -> bool:
    """Tell whether something is to be as it seldom is: extreme, exact to the last digit, or dirty."""
    return bool(rng.random() < ODD)


def random_primitive(rng: np.random.Generator, up: Array | None = None) -> Box | Cone | Ball:
    """Return a primitive about the origin; cones and cylinders stand along ``up`` where it is given."""
    kind = rng.choice(["box", "cylinder", "cone", "sphere"])
    if kind == "box":
        half = 0.5 * np.exp((4.0 if odd(rng) else 1.0) * rng.uniform(-0.7, 0.7, 3))
        return Box(-half, half)
    if kind == "sphere":
        return Ball(np.zeros(3), 0.6)
    axis = random_axis(rng) if up is None or rng.random() < 0.3 else up * rng.choice([-1.0, 1.0])
    height, bottom, top = np.exp((3.0 if odd(rng) else 1.0) * rng.uniform(-0.7, 0.7, 3)) * [1.0, 0.5, 0.5]
    if kind == "cylinder":
        top = bottom
    elif rng.random() < 0.3:
        top = 0.0
    return Cone(-0.5 * height * axis, axis, float(height), float(bottom), float(top))


def random_mesh(rng: np.random.Generator, up: Array, *, open_top: bool) -> Solidmesh:
    """Return a closed surface about the origin; its lid is marked where it is to be open at the top."""
    makers = OPEN_TOPPED if open_top else [*OPEN_TOPPED, *CLOSED]
    mesh = makers[int(rng.integers(len(makers)))](rng)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    if mesh.volume < 0.0:
        mesh.invert()
    vertices = np.asarray(mesh.vertices, float)
    faces = np.asarray(mesh.faces, np.int64)
    vertices = (vertices - vertices.mean(axis=0)) / float(np.cbrt(mesh.volume))
    height = vertices[:, 2]
    lid = (height[faces] > height.max() - 1e-9).all(axis=1) if open_top else np.zeros(len(faces), bool)
    turn = _turn(rng, up if open_top or rng.random() < 0.6 else random_direction(rng))
    return Solidmesh(vertices @ turn.T, faces, lid)


def _turn(rng: np.random.Generator, up: Array) -> Array:
    """Return a rotation (3, 3) that takes z to ``up``, with a random spin or none about it."""
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    across = np.cross(up, first)
    across /= np.linalg.norm(across)
    spin = rng.uniform(0.0, 2.0 * np.pi) if rng.random() < 0.5 else 0.0
    u = np.cos(spin) * across + np.sin(spin) * np.cross(up, across)
    return np.stack([u, np.cross(up, u), up], axis=1)


def _frustum(rng: np.random.Generator) -> trimesh.Trimesh:
    bottom, top = rng.uniform(0.3, 1.0, 2)
    return meshes.revolved([(0.0, 0.0), (bottom, 0.0), (top, 1.5), (0.0, 1.5)], int(rng.integers(3, 40)))


def _hopper(rng: np.random.Generator) -> trimesh.Trimesh:
    profile = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (1.0, 1.0), (1.0, 1.8), (0.0, 1.8)]
    return meshes.revolved(profile, int(rng.integers(4, 32)))


def _bottle(rng: np.random.Generator) -> trimesh.Trimesh:
    profile = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.4), (0.5, 1.8), (0.0, 1.8)]
    return meshes.revolved(profile, int(rng.integers(4, 32)))


def _star(rng: np.random.Generator) -> trimesh.Trimesh:
    count = int(rng.integers(3, 9))
    angle = np.pi * np.arange(2 * count) / count
    radius = np.where(np.arange(2 * count) % 2, rng.uniform(0.5, 0.8), 1.0)
    outline = [(0.0, 0.0), *zip(radius * np.cos(angle), radius * np.sin(angle), strict=True)]
    ends = [(0, k + 1, (k + 1) % (2 * count) + 1) for k in range(2 * count)]
    rim = np.arange(1, 2 * count + 1)
    following, floor = np.roll(rim, -1), len(outline)
    sides = np.concatenate([
        np.column_stack([rim, following, following + floor]),
        np.column_stack([rim, following + floor, rim + floor]),
    ])  # fmt: skip
    flat = np.array(outline)
    vertices = np.vstack([np.column_stack([flat, np.full(floor, z)]) for z in (0.0, 1.2)])
    faces = np.concatenate([np.array(ends)[:, ::-1], sides, np.array(ends) + floor])
    return trimesh.Trimesh(vertices, faces, process=False)


def _hull(rng: np.random.Generator) -> trimesh.Trimesh:
    return trimesh.convex.convex_hull(rng.normal(size=(int(rng.integers(6, 30)), 3)))


def _splinter(rng: np.random.Generator) -> trimesh.Trimesh:
    """A tetrahedron, mostly with acute edges."""
    while True:
        mesh = trimesh.convex.convex_hull(rng.normal(size=(4, 3)))
        if mesh.volume > 0.01 * mesh.extents.max() ** 3:  # thinner ones take minutes to find a place in
            return mesh


OPEN_TOPPED: list[Callable[[np.random.Generator], trimesh.Trimesh]] = [
    lambda rng: trimesh.creation.box(extents=np.exp(rng.uniform(-0.5, 0.5, 3))),
    lambda _rng: meshes.l_box(open_top=False), _frustum, _hopper, _bottle, _star,
]  # fmt: skip
CLOSED: list[Callable[[np.random.Generator], trimesh.Trimesh]] = [
    lambda rng: trimesh.creation.icosphere(subdivisions=int(rng.integers(1, 3))),
    lambda _rng: trimesh.creation.capsule(1.0, 0.5, count=[10, 10]),
    lambda rng: trimesh.creation.torus(1.0, rng.uniform(0.3, 0.6), major_sections=20, minor_sections=10),
    lambda _rng: meshes.u_bend(open_top=False, radius=0.45, facets=8),
    lambda _rng: trimesh.creation.annulus(0.5, 1.0, 1.2, sections=16),
    _hull, _splinter,
]  # fmt: skip


def save_mesh(
    rng: np.random.Generator, mesh: Solidmesh, folder: Path, name: str
) -> tuple[dict[str, Any], Solid]:
    """Write a mesh file; return the keys that name it, and the body as the file's rounded numbers have it."""
    kind, unit = str(rng.choice(FORMATS)), str(rng.choice(list(UNITS))) if rng.random() < 0.3 else "m"
    corner = (mesh.vertices / UNITS[unit]).astype(np.float32)
    faces = mesh.faces[~mesh.lid]
    path = folder / f"{name}.{kind.removesuffix('_text')}"
    _write(path, kind, corner, _dirty(rng, faces) if odd(rng) else faces)
    spec: dict[str, Any] = {"path": path.name} | ({"units": unit} if unit != "m" else {})
    body = Solidmesh(corner.astype(float) * UNITS[unit], mesh.faces, mesh.lid)
    if not mesh.lid.any() and rng.random() < 0.15:
        return spec | {"shape": "convex_hull"}, Hull(body.vertices)
    return spec, body


def _dirty(rng: np.random.Generator, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return facets in another order, some turned over, one there twice, one without an area."""
    faces = rng.permutation(faces)
    turned = rng.random(len(faces)) < rng.choice([0.0, 0.1, 0.5, 1.0])
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    return np.concatenate([faces, faces[:1], faces[:1, [0, 0, 1]]])


def _write(path: Path, kind: str, corner: NDArray[np.float32], faces: NDArray[np.int64]) -> None:
    triangles = corner[faces]
    if kind == "stl":
        record = np.zeros(len(faces), [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("rest", "<u2")])
        record["corner"] = triangles
        path.write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + record.tobytes())
        return
    points = [" ".join(repr(float(each)) for each in row) for row in corner]
    if kind == "stl_text":
        lines = ["solid vessel"]
        for face in faces:
            lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {points[each]}" for each in face)]
            lines += ["endloop", "endfacet"]
        lines.append("endsolid vessel")
    elif kind == "off":
        lines = ["OFF", f"{len(corner)} {len(faces)} 0", *points]
        lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    elif kind == "obj":
        lines = [f"v {point}" for point in points] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    else:
        lines = ["ply", "format ascii 1.0", f"element vertex {len(corner)}"]
        lines += [f"property double {axis}" for axis in "xyz"]
        lines += [
            f"element face {len(faces)}",
            "property list uchar int vertex_indices",
            "end_header",
            *points,
        ]
        lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
