"""What both forms of a layer do with their spheres before they list neighbours anew."""

from __future__ import annotations

import numpy as np

from packgen.arrange.space.seams import Seams
from packgen.arrays import Float64Array, Int64Array


def closed_ranks(
    ball: Float64Array, previous: Float64Array, identity: Int64Array, seams: Seams
) -> tuple[Float64Array, Float64Array, Int64Array]:
    """Forget the spheres that were taken out, and wrap the others into the periodic box.

    Args:
        ball: Centres and radii [m], shape (N, 4), float64; the first ones move, and NaN was taken out. May
            change.
        previous: Centres of the moving ones one sweep ago [m], shape (moving, 3), float64. May change.
        identity: Place of each moving sphere in the order given, shape (moving,).
        seams: Where space wraps around.

    Returns:
        The three, of the spheres that are left.
    """
    keep = ~np.isnan(ball[: len(previous), 0])
    if not keep.all():
        ball = np.concatenate([ball[: len(previous)][keep], ball[len(previous) :]])
        previous, identity = previous[keep], identity[keep]
    if seams.wraps:
        position = ball[: len(previous), :3]
        inside = seams.wrapped(position)
        previous += inside - position
        position[:] = inside
    return ball, previous, identity
