"""Bodies: spheres that belong together, by a column of numbers; without the column each sphere is a body.

A body is placed, moved and taken out as a whole. Spheres of one body have one number in ``body_index``; its
members may overlap each other. None stands for no column at all and costs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from packgen.arrays import BoolArray, Int32Array, Int64Array, distinct

__all__ = ["are_in_rows", "body_starts", "joined_bodies", "touched_bodies", "whole_bodies"]


def body_starts(body_index: Int32Array) -> Int64Array:
    """Return the first row of each body whose spheres have consecutive rows.

    Args:
        body_index: Body of each sphere, shape (N,).

    Returns:
        Rows, rising, shape (bodies,), int64.
    """
    begins = np.ones(len(body_index), bool)
    np.not_equal(body_index[1:], body_index[:-1], out=begins[1:])
    return np.flatnonzero(begins)


def are_in_rows(body_index: Int32Array) -> bool:
    """Return whether the spheres of each body have consecutive rows: no number comes again later."""
    return len(body_starts(body_index)) == len(distinct(body_index.astype(np.int64)))


def whole_bodies(chosen: BoolArray, body_index: Int32Array | None) -> BoolArray:
    """Return which spheres belong to bodies chosen as a whole.

    Args:
        chosen: Which spheres are chosen, shape (N,), bool.
        body_index: Body of each sphere in any order, shape (N,); None: each sphere is a body.

    Returns:
        Those of the chosen ones whose whole body is chosen, shape (N,), bool; ``chosen`` itself for None.
    """
    return chosen if body_index is None else ~touched_bodies(~chosen, body_index)


def touched_bodies(chosen: BoolArray, body_index: Int32Array | None) -> BoolArray:
    """Return which spheres belong to bodies with any chosen sphere.

    Args:
        chosen: Which spheres are chosen, shape (N,), bool.
        body_index: Body of each sphere in any order, shape (N,); None: each sphere is a body.

    Returns:
        The chosen spheres and all others of their bodies, shape (N,), bool; ``chosen`` itself for None.
    """
    return chosen if body_index is None else np.isin(body_index, body_index[chosen])


def joined_bodies(parts: Sequence[Int32Array | None], counts: Sequence[int]) -> Int32Array | None:
    """Return the bodies of several sets of spheres as one column, those of different parts different.

    A part keeps its numbers unless they meet those of an earlier part: then its bodies are numbered anew,
    beyond all others. Spheres of parts without numbers get numbers of their own, beyond all others too.

    Args:
        parts: Body of each sphere of each part, (n,) each; None: each sphere is a body.
        counts: Number of spheres of each part.

    Returns:
        Body of each sphere, shape (sum of the counts,), int32; None where no part has numbers.
    """
    if all(part is None for part in parts):
        return None
    columns: list[Int64Array] = [np.empty(0, np.int64) for _ in parts]
    highest = max((int(part.max(initial=-1)) for part in parts if part is not None), default=-1)
    # Numbered parts first: they keep their numbers where they can.
    for place in sorted(range(len(parts)), key=lambda each: parts[each] is None):
        part = parts[place]
        if part is None:
            column = highest + 1 + np.arange(counts[place])
        elif np.isin(part, np.concatenate(columns)).any():
            column = highest + 1 + np.unique(part, return_inverse=True)[1]
        else:
            column = part.astype(np.int64)
        columns[place] = column
        highest = max(highest, int(column.max(initial=-1)))
    whole = np.concatenate(columns)
    if highest > np.iinfo(np.int32).max:
        whole = np.unique(whole, return_inverse=True)[1]
    return whole.astype(np.int32)
