"""Beds that fall into many pieces, and a loose one with a fault across a seam."""

from __future__ import annotations

from typing import Any

import numpy as np

from packgen.bed import Bed, Material, ParticleSet
from tests.beds import box_container, make_bed

SETS = (ParticleSet("coarse", 2500.0, "ore"), ParticleSet("fine", 3000.0, "coke"))
MATERIALS = (Material("ore", rolling_friction=0.1), Material("coke", friction=0.3))


def shaken(count: int = 12, *, seed: int = 0, **changes: Any) -> Bed:
    """A lattice of ``count`` cubed spheres of two sets, shaken so that some overlap, and some walls too."""
    rng = np.random.default_rng(seed)
    steps = 2.0 * np.arange(count) + 1.0
    position = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    radius = 1.0 - 0.3 * rng.random(len(position))
    position += (rng.random(position.shape) - 0.5) * 0.5
    order = rng.permutation(len(position))
    fields: dict[str, Any] = {
        "set_index": rng.integers(0, 2, len(position)).astype(np.int32),
        "batch_index": np.arange(len(position), dtype=np.int32),
        "particle_sets": SETS,
        "materials": MATERIALS,
        "provenance": {"packgen": "0.1.0", "scene": "shaken.yaml", "seed": seed},
    }
    container = box_container(np.zeros(3), np.full(3, 2.0 * count))
    return make_bed(position[order], radius, container, **(fields | changes))
