"""What both forms of a layer do with their spheres before they list neighbours anew."""

from __future__ import annotations

import math

from packgen.arrange.space.seams import Seams, wrapped_coordinate
from packgen.arrays import Float64Array, Int64Array
from packgen.compiled import loop


@loop
def closed_ranks(
    ball: Float64Array, previous: Float64Array, identity: Int64Array, seams: Seams
) -> tuple[Float64Array, Float64Array, Int64Array]:
    """Forget the spheres that were taken out, and wrap the others into the periodic box.

    Args:
        ball: Centres and radii [m], shape (N, 4), float64; the first ones move, and NaN was taken out.
            Changes.
        previous: Centres of the moving ones one sweep ago [m], shape (moving, 3), float64. Changes.
        identity: Place of each moving sphere in the order given, shape (moving,). Changes.
        seams: Where space wraps around.

    Returns:
        The three, of the spheres that are left.
    """
    moving, left = len(previous), 0
    for i in range(moving):
        if not math.isnan(ball[i, 0]):
            for axis in range(3):
                inside = wrapped_coordinate(ball[i, axis], seams.low[axis], seams.period[axis])
                previous[left, axis] = previous[i, axis] + (inside - ball[i, axis])
                ball[left, axis] = inside
            ball[left, 3], identity[left] = ball[i, 3], identity[i]
            left += 1
    total = left
    for i in range(moving, len(ball)):
        for axis in range(4):
            ball[total, axis] = ball[i, axis]
        total += 1
    return ball[:total], previous[:left], identity[:left]
