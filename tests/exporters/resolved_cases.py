"""Beds for particle-resolved CFD, and readers of its files written from their formats."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from packgen.geometry import Cone
from tests.beds import box_container, cubic_lattice, make_bed, make_container, revolved_surface

RADIUS = 0.1
NUMBER = r"[-+0-9.e]+"


def box_bed(count: int = 2, periodic=(False, False, False), **changes):
    """Touching spheres on a cubic lattice in a box that they fill."""
    box = box_container((0, 0, 0), (2 * count * RADIUS,) * 3, periodic)
    return make_bed(cubic_lattice(count, RADIUS), RADIUS, box, **changes)


def tube_container(radius: float, height: float, axis=(0.0, 0.0, 1.0)):
    """A cylinder that stands on the origin."""
    shape = Cone(np.zeros(3), np.asarray(axis, float), height, radius, radius)
    surface = revolved_surface([(0, radius), (height, radius)], 48)
    return make_container(shape, surface, float(np.pi * radius**2 * height))


def pair_bed(gap: float = 0.0, radius=(0.1, 0.06), tube: float = 1.0):
    """Two spheres one above the other on the axis of a tube, far from its wall."""
    first, second = radius
    position = [[0, 0, first], [0, 0, 2 * first + gap + second]]
    return make_bed(position, radius, tube_container(tube, 1.0))


def ring_bed(tube: float = 0.31, count: int = 6):
    """Spheres that touch the wall of a tube, apart from each other."""
    angle = 2 * np.pi * np.arange(count) / count
    away = tube - RADIUS
    position = np.stack([away * np.cos(angle), away * np.sin(angle), np.full(count, RADIUS)], axis=1)
    return make_bed(position, RADIUS, tube_container(tube, 1.0))


def read_stl(path: Path) -> dict[str, np.ndarray]:
    """The solids of an ASCII STL file: corners of their facets, shapes (F, 3, 3)."""
    found: dict[str, np.ndarray] = {}
    for name, text in re.findall(r"^solid (\S+)\n(.*?)^endsolid \1$", path.read_text(), re.S | re.M):
        rows = re.findall(rf"vertex ({NUMBER}) ({NUMBER}) ({NUMBER})", text)
        assert text.count("endfacet") * 3 == len(rows)
        found[name] = np.array(rows, float).reshape(-1, 3, 3)
    return found


def shells(triangles: np.ndarray) -> list[np.ndarray]:
    """The closed shells of a solid, by facets that share corners."""
    import trimesh

    mesh = trimesh.Trimesh(*_indexed(triangles), process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    return [np.asarray(each.triangles) for each in mesh.split(only_watertight=True)]


def _indexed(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    corner, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return corner, index.reshape(-1, 3)


def enclosed(triangles: np.ndarray) -> float:
    """The volume that closed shells enclose, by Gauss' theorem."""
    return float(np.einsum("fi,fi->f", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum() / 6)


def read_dictionary(path: Path) -> dict:
    """An OpenFOAM dictionary as nested mappings; lists are lists of words."""
    text = re.sub(r"//[^\n]*|#\w+ [^\n]*", "", path.read_text())
    words = re.findall(r'"[^"]*"|[{}();]|[^\s{}();"]+', text)
    found, rest = _entries(words, 0)
    assert rest == len(words)
    return found


def _entries(words: list[str], place: int) -> tuple[dict, int]:
    found: dict = {}
    while place < len(words) and words[place] != "}":
        key, place = words[place].strip('"'), place + 1
        if words[place] == "{":
            found[key], place = _entries(words, place + 1)
            assert words[place] == "}"
            place += 1
            continue
        value: list = []
        while words[place] != ";":
            if words[place] == "(":
                inner, place = _items(words, place + 1)
                value.append(inner)
            else:
                value.append(words[place])
                place += 1
        found[key], place = value[0] if len(value) == 1 else value, place + 1
    return found, place


def _items(words: list[str], place: int) -> tuple[list, int]:
    found: list = []
    while words[place] != ")":
        if words[place] == "(":
            inner, place = _items(words, place + 1)
            found.append(inner)
        elif words[place] == "{":
            inner, place = _entries(words, place + 1)
            found.append(inner)
            place += 1
        else:
            found.append(words[place])
            place += 1
    return found, place + 1
