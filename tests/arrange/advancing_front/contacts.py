"""Contacts of beds, counted by pairs and closed forms that the algorithm does not know."""

from __future__ import annotations

import numpy as np

from packgen.check.pairs import near_pairs
from packgen.geometry import Ball, Box, Cone

TOUCHING = 1.0e-12  # radii


def wall_gaps(bed):
    """Distances of surfaces from each wall of a box, a cylinder, a cone or a ball [m], (N, walls)."""
    shape, position, radius = bed.container.shape, bed.position, bed.radius[:, None]
    if isinstance(shape, Box):
        gaps = np.concatenate([position - shape.min, shape.max - position], axis=1)
        return gaps[:, ~np.tile(bed.container.periodic, 2)] - radius
    if isinstance(shape, Ball):
        return shape.radius - np.linalg.norm(position - shape.center, axis=1)[:, None] - radius
    assert isinstance(shape, Cone)
    along = (position - shape.base) @ shape.axis
    across = np.linalg.norm(position - shape.base - along[:, None] * shape.axis, axis=1)
    slope = (shape.radius_top - shape.radius_bottom) / shape.height
    lateral = (shape.radius_bottom + slope * along - across) / np.sqrt(1.0 + slope * slope)
    return np.column_stack([along, shape.height - along, lateral]) - radius


def contact_counts(bed):
    """How many spheres and walls each sphere touches, to 1e-12 of its radius, shape (N,)."""
    count = (np.abs(wall_gaps(bed)) < TOUCHING * bed.radius[:, None]).sum(axis=1)
    for pairs in near_pairs(bed.position, bed.radius, gap_fraction=1e-6, period=bed.container.period):
        smaller = np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
        touching = np.abs(pairs.gap) < TOUCHING * smaller
        for end in (pairs.first, pairs.second):
            np.add.at(count, end[touching], 1)
    return count
