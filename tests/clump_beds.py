"""Beds of clumps made by hand, and what is true of them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from packgen.bed import Bed, Material
from packgen.bodies import SINGLE, Bodies, Template, members_of
from packgen.clumps import template_of_spheres
from tests.beds import box_container, make_bed

RADIUS = 0.005
MATERIALS = (Material("ore", youngs_modulus=1.0e7),)


@cache
def pair() -> Template:
    return template_of_spheres("pair", np.array([[-0.004, 0, 0, 0.005], [0.004, 0, 0, 0.005]]))


@cache
def bent() -> Template:
    spheres = [
        [0, 0, 0, 0.005],
        [0.007, 0.001, 0, 0.004],
        [0.001, 0.006, 0.002, 0.0045],
        [0, 0, 0.005, 0.003],
    ]
    return template_of_spheres("bent", np.array(spheres))


def random_turns(count: int, seed: int = 5) -> np.ndarray:
    turn = np.random.default_rng(seed).normal(size=(count, 4))
    return turn / np.linalg.norm(turn, axis=1, keepdims=True)


def bodies_at(
    place: Any, index: Any, templates: tuple[Template, ...] | None = None, scale: Any = None, seed: int = 5
) -> Bodies:
    """Bodies at places, turned at random; single spheres have the radius `RADIUS`."""
    index = np.asarray(index, np.int32)
    sizes = np.where(index == SINGLE, RADIUS, 1.0) if scale is None else np.asarray(scale, float)
    return Bodies(
        templates or (pair(), bent()), index, sizes, np.asarray(place, float), random_turns(len(index), seed)
    )


def bed_of(bodies: Bodies, container: Any, **changes: Any) -> Bed:
    """The bed of bodies, their spheres in the order of their bodies."""
    position, radius, owner = members_of(bodies)
    known = {"bodies": bodies, "body_index": owner, "materials": MATERIALS}
    place = changes.pop("position", position)
    return make_bed(place, radius, container, **known | changes)


def lattice_of_clumps(
    counts: tuple[int, int, int] = (3, 3, 3),
    *,
    singles: bool = False,
    periodic: tuple[bool, bool, bool] = (False, False, False),
    spacing: float = 0.026,
    **changes: Any,
) -> Bed:
    """Pairs and bent clumps (and single spheres) on a lattice, no two of them touching, in a box.

    Where the box wraps around, the bodies stand on its seam, and their spheres are wrapped into it.
    """
    grid = np.stack(np.meshgrid(*(np.arange(each) for each in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    high = spacing * np.array(counts)
    place = spacing * (grid + np.where(periodic, 0.0, 0.5))
    kinds = [0, 1, SINGLE] if singles else [0, 1]
    bodies = bodies_at(place, np.resize(kinds, len(place)))
    container = box_container(np.zeros(3), high, periodic)
    bed = bed_of(bodies, container, **changes)
    position = bed.position.copy()
    for axis in np.flatnonzero(periodic):
        position[:, axis] %= high[axis]
    return bed_of(bodies, container, position=position, **changes) if any(periodic) else bed
