"""Pairs of spheres that are near enough to be bonded: scipy's k-d trees, an octave of radius at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field
from scipy.spatial import cKDTree

from packgen.bed import Bed
from packgen.errors import ExportError
from packgen.geometry import Container

GAP = 0.01

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]


class BondOptions(BaseModel):
    """Options of bonds.

    Attributes:
        gap: Largest gap of two spheres that are bonded, as a fraction of the smaller radius.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    gap: float = Field(default=GAP, ge=0)


@dataclass(frozen=True, eq=False, slots=True)
class Bonds:
    """Bonds, by rising first and then second sphere.

    Attributes:
        first: Index of the sphere with the smaller index, shape (B,), int64.
        second: Index of the other one, shape (B,), int64.
        distance: Distance of the centres [m], across a seam where that is nearer, shape (B,), float64.
        gap: Distance of the surfaces [m], negative where they overlap, shape (B,), float64.
    """

    first: Int64Array
    second: Int64Array
    distance: Float64Array
    gap: Float64Array


def refuse_narrow_box(container: Container, radius_max: float, gap: float, solver: str) -> None:
    """Refuse a box that wraps around after less than two of the longest bonds: they would meet themselves.

    Args:
        container: The container.
        radius_max: Radius of the largest sphere [m].
        gap: Largest gap, as a fraction of the smaller radius.
        solver: What messages call the format.

    Raises:
        ExportError: It does.
    """
    longest = (2.0 + gap) * radius_max
    for axis, length in zip("xyz", container.period, strict=True):
        if length is not None and length <= 2.0 * longest:
            raise ExportError(
                f"{solver}: the bed wraps around along {axis} after {length:.4g} m, expected over "
                f"{2 * longest:.4g} m, two of the longest bonds; repeat the bed first, by packgen repeat"
            )


def find_bonds(bed: Bed, gap: float, solver: str) -> Bonds:
    """Return the pairs of spheres whose gap is at most a fraction of the smaller radius.

    Spheres of one body are no pair. A pair that meets on both sides of a box that wraps around would be one.

    Args:
        bed: The bed.
        gap: The fraction.
        solver: What messages call the format.

    Raises:
        ExportError: The bed wraps around after less than two of the longest bonds.
    """
    refuse_narrow_box(bed.container, float(bed.radius.max()), gap, solver)
    reach = 1.0 + 0.5 * gap  # gap <= fraction * min(r) implies distance <= reach * (r_i + r_j)
    period = np.array([length or 0.0 for length in bed.container.period])
    position = bed.position - np.where(period > 0.0, bed.container.bounds[0], 0.0)
    position = np.where(period > 0.0, np.mod(position, np.where(period > 0.0, period, 1.0)), position)
    octave = np.floor(np.log2(bed.radius / bed.radius.min()) + 1e-9).astype(np.int64)
    levels = [np.flatnonzero(octave == value) for value in np.unique(octave)]
    box = period if (period > 0.0).any() else None
    trees = [cKDTree(_within(position[level], period), boxsize=box) for level in levels]
    found = [np.empty((0, 2), np.int64)]
    for large in range(len(levels)):
        for small in range(large + 1):
            both = float(bed.radius[levels[large]].max() + bed.radius[levels[small]].max())
            pairs = _near(trees[large], trees[small], reach * both * (1.0 + 1e-9), same=large == small)
            found.append(np.stack([levels[large][pairs[:, 0]], levels[small][pairs[:, 1]]], axis=1))
    return _bonds(bed, np.sort(np.concatenate(found), axis=1), period, gap)


def _within(position: Float64Array, period: Float64Array) -> Float64Array:
    """Return positions inside the box of a tree: rounding may put one on its upper side."""
    return np.where((period > 0.0) & (position >= period), 0.0, position)


def _near(first: cKDTree, second: cKDTree, cutoff: float, *, same: bool) -> Int64Array:
    if same:
        return first.query_pairs(cutoff, output_type="ndarray").astype(np.int64)
    found = first.sparse_distance_matrix(second, cutoff, output_type="ndarray")
    return np.stack([found["i"], found["j"]], axis=1).astype(np.int64)


def _bonds(bed: Bed, pairs: Int64Array, period: Float64Array, gap: float) -> Bonds:
    first, second = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].T
    apart = bed.position[first] - bed.position[second]
    length = np.where(period > 0.0, period, 1.0)
    apart -= np.where(period > 0.0, np.rint(apart / length) * length, 0.0)
    distance = np.linalg.norm(apart, axis=1)
    between = distance - bed.radius[first] - bed.radius[second]
    near = between <= gap * np.minimum(bed.radius[first], bed.radius[second])
    if bed.body_index is not None:
        near &= bed.body_index[first] != bed.body_index[second]
    return Bonds(first[near], second[near], distance[near], between[near])
