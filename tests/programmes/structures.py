"""Structures made by hand whose least friction has a closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from packgen.programmes.forces import FIXED, Structure

ROOT = np.sqrt(3.0)


def make_structure(count: int, contacts: list[tuple[int, int, Any]], down: Any = (0, 0, -1.0)) -> Structure:
    """Unit spheres of unit weight: contacts are (first, second, direction from the first to the second)."""
    normal = np.array([each[2] for each in contacts], dtype=float).reshape(-1, 3)
    return Structure(
        radius=np.ones(count),
        weight=np.tile(np.asarray(down, float), (count, 1)),
        mass=np.ones(count),
        first=np.array([each[0] for each in contacts], dtype=np.int64),
        second=np.array([each[1] for each in contacts], dtype=np.int64),
        normal=normal / np.linalg.norm(normal, axis=1)[:, None],
        friction=np.full(len(contacts), 0.5),
    )


def pile(base: np.ndarray, top: np.ndarray) -> Structure:
    """Base spheres on a floor, the last sphere on all of them."""
    contacts: list[tuple[int, int, Any]] = [(i, FIXED, (0, 0, -1)) for i in range(len(base))]
    contacts += [(len(base), i, each - top) for i, each in enumerate(base)]
    return make_structure(len(base) + 1, contacts)


def pyramid(legs: int) -> tuple[Structure, float]:
    """A sphere on two or three that touch, and the least friction: the tangent of half the legs' angle."""
    away = 1.0 if legs == 2 else 2.0 / ROOT  # from the middle to a base sphere
    angle = 2.0 * np.pi * np.arange(legs) / legs
    base = np.stack([away * np.cos(angle), away * np.sin(angle), np.zeros(legs)], axis=1)
    top = np.array([0.0, 0.0, np.sqrt(4.0 - away**2)])
    return pile(base, top), float(np.tan(0.5 * np.arcsin(0.5 * away)))


def wedge(half_angle: float) -> Structure:
    """A sphere between two walls that lean over it: it is held from a friction of tan(half_angle) on."""
    lean = np.cos(half_angle), np.sin(half_angle)
    return make_structure(1, [(0, FIXED, (lean[0], 0, lean[1])), (0, FIXED, (-lean[0], 0, lean[1]))])


def turned(structure: Structure, rotation: np.ndarray) -> Structure:
    """The same, turned in space."""
    return Structure(
        structure.radius, structure.weight @ rotation.T, structure.mass, structure.first, structure.second,
        np.ascontiguousarray(structure.normal @ rotation.T), structure.friction,
    )  # fmt: skip
