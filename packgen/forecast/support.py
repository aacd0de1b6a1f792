"""Which zones nothing will hold, by the cells of a grid; ``packgen.check`` judges the spheres later."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.check.sides import STACK
from packgen.check.support import FALL, HANGING_SHARE
from packgen.forecast.cells import Cells

__all__ = ["Loose", "hanging", "standing_free"]

SIDE_SHARE = 0.1
"""Share of a zone's side from which it counts as standing free; cells tell less exactly than spheres."""


@dataclass(frozen=True, slots=True)
class Loose:
    """A part of a zone's end or side that nothing holds.

    Attributes:
        share: How much of it.
        fall: Median distance of the fall [m].
    """

    share: float
    fall: float


def hanging(cells: Cells, index: int, diameter: float) -> Loose | None:
    """Return how much of a zone's lower end hangs; None: it is held.

    Args:
        cells: The cells, all zones filled.
        index: The zone.
        diameter: Largest diameter [m].
    """
    own = cells.zone == index
    lowest = own.copy()
    lowest[:, :, 1:] &= ~own[:, :, :-1]
    below = np.zeros(own.shape)
    below[:, :, 1:] = _free_depth(cells)[:, :, :-1]
    return _loose(below[lowest], cells, FALL * diameter, HANGING_SHARE)


def standing_free(cells: Cells, index: int, diameter: float) -> Loose | None:
    """Return how much of a zone's side stands free; None: it is held.

    Args:
        cells: The cells, all zones filled.
        index: The zone.
        diameter: Largest diameter [m].
    """
    own, depth = cells.zone == index, _free_depth(cells)
    side = np.zeros(own.shape, dtype=bool)
    fall = np.zeros(own.shape)
    for axis in (0, 1):
        for step in (1, -1):
            side |= own & ~_neighbours(own, axis, step, outside=False)
            fall = np.maximum(fall, np.where(own, _neighbours(depth, axis, step, outside=0.0), 0.0))
    return _loose(fall[side], cells, STACK * diameter, SIDE_SHARE)


def _free_depth(cells: Cells) -> Float64Array:
    """Return how deep it is free from a cell on downwards [m], shape (nu, nv, nz); 0 where it is not."""
    free = cells.inside & (cells.zone < 0)
    depth = np.zeros(free.shape)
    for layer, height in enumerate(cells.height):
        under = depth[:, :, layer - 1] if layer else 0.0
        depth[:, :, layer] = np.where(free[:, :, layer], under + height, 0.0)
    return depth


def _neighbours(values: np.ndarray, axis: int, step: int, outside: object) -> np.ndarray:
    """Return the values of the neighbours along an axis; beyond the grid a wall stands."""
    moved = np.roll(values, -step, axis=axis)
    end = [slice(None)] * 3
    end[axis] = slice(-1, None) if step > 0 else slice(0, 1)
    moved[tuple(end)] = outside
    return moved


def _loose(depth: Float64Array, cells: Cells, limit: float, least: float) -> Loose | None:
    """Return the share of cells with more room below than a limit; a layer less, as an end may lie in one."""
    if len(depth) == 0:
        return None
    far = depth - cells.height.max() > limit
    share = float(far.mean())
    return Loose(share, float(np.median(depth[far]))) if share > least else None
