"""Neighbour search in plain torch: which spheres are closer than the sum of their reaches.

A sphere's reach is its radius plus half the skin of the neighbour list. Spheres are grouped by octaves of
reach, and each pair of groups is searched in a grid whose cell is the largest sum of reaches that the two can
have: small spheres do not pay for the cut-off of large ones. A grid is a sorted list of cell numbers, so its
memory grows with the spheres and not with the space between them.

Distances are taken exactly as in the brute force (same differences, same sums), so that both forms give the
same pairs, borderline ones included. Along a periodic axis the nearest image counts.

Example:
    >>> position = torch.tensor([[0.0, 0, 0], [1.5, 0, 0], [9.0, 0, 0]], dtype=torch.float64)
    >>> neighbor_pairs(position, torch.ones(3, dtype=torch.float64)).tolist()
    [[0, 1]]
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import torch
from torch import Tensor

Lengths: TypeAlias = Sequence[float | None]

APERIODIC: Lengths = (None, None, None)
CELLS_MAX = 2**20  # cells along an axis: three of them number less than 2**63 cells
CANDIDATES_MAX = 2**21  # candidate pairs held in memory at a time
PERIODIC_CELLS_MAX = 2**12  # along a period: centres many periods away are coarser numbers
SLACK = 1.0 + 1.0e-8  # cells are this much wider than the cut-off: more than 2**20 cells' worth of rounding


def neighbor_pairs(position: Tensor, reach: Tensor, lengths: Lengths = APERIODIC) -> Tensor:
    """Return all pairs of spheres that are closer than the sum of their reaches.

    Args:
        position: Sphere centres [m], shape (N, 3), float64, anywhere; also outside a periodic box.
        reach: Reach of each sphere [m], shape (N,), float64, positive.
        lengths: Period of each axis [m], None where it is not periodic.

    Returns:
        Indices i < j with ``|x_i - x_j| < reach_i + reach_j``, shape (P, 2), int64, in ascending order.

    Raises:
        ValueError: Shapes do not fit, or a position, reach or length is not a usable number.
    """
    _check(position, reach, lengths)
    groups = _octaves(reach)
    found = [_no_pairs(position)]
    for number, first in enumerate(groups):
        within = _search(position[first], reach[first], position[first], reach[first], lengths)
        found.append(first[within[within[:, 0] < within[:, 1]]])
        for second in groups[number + 1 :]:
            across = _search(position[first], reach[first], position[second], reach[second], lengths)
            pairs = torch.stack((first[across[:, 0]], second[across[:, 1]]), dim=1)
            found.append(pairs.sort(dim=1).values)
    return _in_order(torch.cat(found), len(position))


def neighbor_pairs_between(
    position: Tensor, reach: Tensor, other_position: Tensor, other_reach: Tensor, lengths: Lengths = APERIODIC
) -> Tensor:
    """Return all pairs of a sphere of one set and a sphere of another that are closer than their reaches.

    Args:
        position: Centres of the one set [m], shape (N, 3), float64.
        reach: Their reaches [m], shape (N,), float64, positive.
        other_position: Centres of the other set [m], shape (M, 3), float64.
        other_reach: Their reaches [m], shape (M,), float64, positive.
        lengths: Period of each axis [m], None where it is not periodic.

    Returns:
        Indices into the one and into the other set, shape (P, 2), int64, in ascending order.

    Raises:
        ValueError: Shapes do not fit, or a position, reach or length is not a usable number.
    """
    _check(position, reach, lengths)
    _check(other_position, other_reach, lengths)
    found = [_no_pairs(position)]
    for first, second in itertools.product(_octaves(reach), _octaves(other_reach)):
        pairs = _search(position[first], reach[first], other_position[second], other_reach[second], lengths)
        found.append(torch.stack((first[pairs[:, 0]], second[pairs[:, 1]]), dim=1))
    return _in_order(torch.cat(found), len(other_position))


def neighbor_pairs_brute_force(position: Tensor, reach: Tensor, lengths: Lengths = APERIODIC) -> Tensor:
    """Return what `neighbor_pairs` returns by measuring every pair: time and memory grow as N squared."""
    pairs = neighbor_pairs_between_brute_force(position, reach, position, reach, lengths)
    return pairs[pairs[:, 0] < pairs[:, 1]]


def neighbor_pairs_between_brute_force(
    position: Tensor, reach: Tensor, other_position: Tensor, other_reach: Tensor, lengths: Lengths = APERIODIC
) -> Tensor:
    """Return what `neighbor_pairs_between` returns by measuring every pair: grows as N times M."""
    _check(position, reach, lengths)
    _check(other_position, other_reach, lengths)
    first = torch.arange(len(position), device=position.device).repeat_interleave(len(other_position))
    second = torch.arange(len(other_position), device=position.device).repeat(len(position))
    close = _close(position[first] - other_position[second], reach[first] + other_reach[second], lengths)
    return torch.stack((first[close], second[close]), dim=1)


def _check(position: Tensor, reach: Tensor, lengths: Lengths) -> None:
    if position.ndim != 2 or position.shape[1] != 3 or reach.shape != (len(position),):
        shapes = f"{tuple(position.shape)} and {tuple(reach.shape)}"
        raise ValueError(f"positions and reaches of shapes {shapes}, expected (N, 3) and (N,)")
    if not bool(torch.isfinite(position).all()):
        raise ValueError("positions must be finite")
    if not bool((torch.isfinite(reach) & (reach > 0.0)).all()):
        raise ValueError("reaches must be finite and positive")
    if len(lengths) != 3 or not all(length is None or 0.0 < length < math.inf for length in lengths):
        raise ValueError(f"periods {tuple(lengths)}, expected three positive lengths or None")


def _octaves(reach: Tensor) -> list[Tensor]:
    """Return the indices of the spheres of each octave of reach, each of shape (k,), smallest first."""
    if len(reach) == 0:
        return []
    octave = torch.log2(reach).floor()
    return [torch.nonzero(octave == value).flatten() for value in torch.unique(octave)]


def _search(
    position: Tensor, reach: Tensor, other_position: Tensor, other_reach: Tensor, lengths: Lengths
) -> Tensor:
    """Return the close pairs of two non-empty sets (N, 3) and (M, 3), shape (P, 2), in no given order."""
    if len(position) > len(other_position):
        # the fewer ask, the many are asked: fewer look-ups
        return _search(other_position, other_reach, position, reach, lengths).flip(1)
    cutoff = float(reach.max() + other_reach.max()) * SLACK
    cell, other_cell, counts = _cells(position, other_position, cutoff, lengths)
    strides = torch.tensor([counts[1] * counts[2], counts[2], 1], device=position.device)
    keys, order = ((other_cell * strides).sum(dim=1)).sort()
    begin, end = _cell_ranges(cell, keys, counts, strides, lengths)
    found = [_no_pairs(position)]
    for query, slot in _expand(begin, end):
        other = order[slot]
        close = _close(position[query] - other_position[other], reach[query] + other_reach[other], lengths)
        found.append(torch.stack((query[close], other[close]), dim=1))
    return torch.cat(found)


def _cells(
    position: Tensor, other_position: Tensor, cutoff: float, lengths: Lengths
) -> tuple[Tensor, Tensor, list[int]]:
    """Return the cell (N, 3) and (M, 3) of each centre, int64, and how many cells each axis has.

    Along an open axis an empty cell lies before the first and after the last, so that a neighbouring cell's
    number never means a cell of the next row.
    """
    cells, other_cells, counts = [], [], []
    for axis, length in enumerate(lengths):
        one, other = position[:, axis], other_position[:, axis]
        if length is None:
            low = min(float(one.min()), float(other.min()))
            extent = max(float(one.max()), float(other.max())) - low
            width = max(cutoff, extent / (CELLS_MAX - 4))
            count = int(extent / width) + 3
            one, other = (one - low) / width + 1.0, (other - low) / width + 1.0
        else:
            count = min(max(int(length / cutoff), 1), PERIODIC_CELLS_MAX)
            one, other = one / length, other / length
            one, other = (one - one.floor()) * count, (other - other.floor()) * count
        cells.append(one.long().clamp(max=count - 1))
        other_cells.append(other.long().clamp(max=count - 1))
        counts.append(count)
    return torch.stack(cells, dim=1), torch.stack(other_cells, dim=1), counts


def _cell_ranges(
    cell: Tensor, keys: Tensor, counts: list[int], strides: Tensor, lengths: Lengths
) -> tuple[Tensor, Tensor]:
    """Return where the K neighbours of each of N cells begin and end in the sorted keys, both (N, K)."""
    offsets: list[Sequence[int]] = []
    for length, count in zip(lengths, counts, strict=True):
        # of a period of one or two cells the cells before and after are the same one
        offsets.append((-1, 0, 1) if length is None else range(-1, 2)[: min(count, 3)])
    run = 0
    if lengths[2] is None:
        # cells in a row along the last axis have consecutive numbers: one range takes all three
        offsets[2], run = (-1,), 2
    stencil = torch.tensor(list(itertools.product(*offsets)), device=cell.device)
    neighbor = cell[:, None, :] + stencil
    for axis, length in enumerate(lengths):
        if length is not None:
            neighbor[..., axis] %= counts[axis]
    wanted = (neighbor * strides).sum(dim=2)
    return torch.searchsorted(keys, wanted), torch.searchsorted(keys, wanted + run, right=True)


def _expand(begin: Tensor, end: Tensor) -> Iterator[tuple[Tensor, Tensor]]:
    """Yield (query, slot), each (k,), for all slots of the ranges (N, K), a bounded number at a time."""
    lengths = end - begin
    total = lengths.sum(dim=1).cumsum(dim=0)
    first, done = 0, 0
    while first < len(total):
        last = max(first + 1, int(torch.searchsorted(total, done + CANDIDATES_MAX, right=True)))
        length = lengths[first:last]
        query = torch.arange(first, last, device=begin.device).repeat_interleave(length.sum(dim=1))
        length = length.flatten()
        shift = begin[first:last].flatten() - (length.cumsum(dim=0) - length)
        yield query, torch.arange(len(query), device=begin.device) + shift.repeat_interleave(length)
        first, done = last, int(total[last - 1])


def _close(difference: Tensor, cutoff: Tensor, lengths: Lengths) -> Tensor:
    """Return which of P differences (P, 3) are shorter than their cut-offs (P,), as booleans (P,)."""
    squared = torch.zeros_like(cutoff)
    for axis, length in enumerate(lengths):
        along = difference[:, axis]
        if length is not None:
            along = along - length * torch.round(along / length)
        squared += along * along
    return squared < cutoff * cutoff


def _no_pairs(position: Tensor) -> Tensor:
    return torch.empty((0, 2), dtype=torch.int64, device=position.device)


def _in_order(pairs: Tensor, stride: int) -> Tensor:
    """Return the pairs (P, 2) sorted by the first index, then by the second (below ``stride``)."""
    return pairs[(pairs[:, 0] * max(stride, 1) + pairs[:, 1]).argsort()]
