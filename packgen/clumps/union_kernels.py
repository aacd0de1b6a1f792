"""Surface integrals over the outside of a union of spheres: circles of latitude, cut by the spheres' caps.

By Gauss's theorem a volume integral is one over the surface, of a field along z. On a circle of latitude of a
sphere the field's flux has a closed form over each free arc. Between latitudes at which a cap or a corner of
the surface begins or ends the flux is a smooth function, which Gauss's rule integrates to rounding.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inner_loop, loop

TERMS = 11
"""Integrals a union has: area, volume, first moments x y z, second moments xx yy zz xy xz yz."""

CLOSE = 1.0e-9
"""Radii of the unit sphere: corners this little inside a cap count as free. A cut too many does no harm."""


@inner_loop
def is_covered(cap: NDArray[np.float64], count: int, x: float, y: float, z: float) -> bool:
    """Tell whether a point of the unit sphere is well inside one of the caps."""
    for k in range(count):
        if cap[k, 0] * x + cap[k, 1] * y + cap[k, 2] * z > cap[k, 3] + CLOSE:
            return True
    return False


@inner_loop
def caps_of(ball: NDArray[np.float64], i: int, cap: NDArray[np.float64]) -> int:
    """Find the caps that other spheres cut off a sphere.

    Args:
        ball: Spheres, none inside another one [m], shape (N, 4).
        i: The sphere.
        cap: Out: unit vector to the middle of each cap, and the height of its plane, shape (N, 4).

    Returns:
        Number of caps.
    """
    count = 0
    for j in range(len(ball)):
        if j == i:
            continue
        dx, dy, dz = ball[j, 0] - ball[i, 0], ball[j, 1] - ball[i, 1], ball[j, 2] - ball[i, 2]
        square = dx * dx + dy * dy + dz * dz
        if square >= (ball[i, 3] + ball[j, 3]) ** 2:
            continue
        away = math.sqrt(square)
        height = (square + (ball[i, 3] - ball[j, 3]) * (ball[i, 3] + ball[j, 3])) / (2.0 * away * ball[i, 3])
        if height < 1.0:
            cap[count, 0], cap[count, 1], cap[count, 2] = dx / away, dy / away, dz / away
            cap[count, 3] = max(height, -1.0)
            count += 1
    return count


@inner_loop
def cuts_of(cap: NDArray[np.float64], count: int, cut: NDArray[np.float64]) -> int:
    """Find the latitudes between which the free arcs change smoothly, in rising order.

    Args:
        cap: Caps, as from `caps_of`.
        count: How many.
        cut: Out: heights on the unit sphere, from -1 to 1, long enough for all of them.

    Returns:
        Number of latitudes.
    """
    cut[0], cut[1] = -1.0, 1.0
    found = 2
    for a in range(count):
        ax, ay, az, h = cap[a, 0], cap[a, 1], cap[a, 2], cap[a, 3]
        flat, wide = math.sqrt(max(1.0 - az * az, 0.0)), math.sqrt(max(1.0 - h * h, 0.0))
        for side in (-1.0, 1.0):
            # The highest and the lowest point of the cap's rim.
            ux, uy, uz = 1.0, 0.0, 0.0
            if flat > 0.0:
                ux, uy, uz = -ax * az / flat, -ay * az / flat, flat
            z = h * az + side * wide * uz
            if not is_covered(cap, count, h * ax + side * wide * ux, h * ay + side * wide * uy, z):
                cut[found] = z
                found += 1
        for b in range(a):
            cosine = ax * cap[b, 0] + ay * cap[b, 1] + az * cap[b, 2]
            rest = 1.0 - cosine * cosine
            if rest <= 1e-24:
                continue
            p, q = (h - cosine * cap[b, 3]) / rest, (cap[b, 3] - cosine * h) / rest
            square = 1.0 - (p * h + q * cap[b, 3])
            if square < 0.0:
                continue
            nx, ny = ay * cap[b, 2] - az * cap[b, 1], az * cap[b, 0] - ax * cap[b, 2]
            nz = ax * cap[b, 1] - ay * cap[b, 0]
            along = math.sqrt(square / rest)
            for side in (-1.0, 1.0):
                x = p * ax + q * cap[b, 0] + side * along * nx
                y = p * ay + q * cap[b, 1] + side * along * ny
                z = p * az + q * cap[b, 2] + side * along * nz
                if not is_covered(cap, count, x, y, z):
                    cut[found] = min(max(z, -1.0), 1.0)
                    found += 1
    cut[:found].sort()
    return found


@inner_loop
def free_arcs(
    cap: NDArray[np.float64], count: int, z: float, begin: NDArray[np.float64], end: NDArray[np.float64]
) -> int:
    """Find the arcs of a circle of latitude that no cap covers.

    Args:
        cap: Caps, as from `caps_of`.
        count: How many.
        z: Height of the circle on the unit sphere.
        begin: Out: longitude at which each arc begins, room for ``2 * count + 2``.
        end: Out: longitude at which it ends.

    Returns:
        Number of arcs.
    """
    circle = math.sqrt(max(1.0 - z * z, 0.0))
    covered = 0
    for k in range(count):
        wide = circle * math.sqrt(cap[k, 0] ** 2 + cap[k, 1] ** 2)
        above = cap[k, 3] - cap[k, 2] * z
        if above >= wide:
            continue
        if above <= -wide:
            return 0
        half = math.acos(above / wide)
        middle = math.atan2(cap[k, 1], cap[k, 0])
        low, high = middle - half, middle + half
        if low < -math.pi:
            begin[covered], end[covered] = low + 2.0 * math.pi, math.pi
            covered += 1
            low = -math.pi
        elif high > math.pi:
            begin[covered], end[covered] = -math.pi, high - 2.0 * math.pi
            covered += 1
            high = math.pi
        begin[covered], end[covered] = low, high
        covered += 1
    order = np.argsort(begin[:covered])
    lows, highs = begin[:covered][order], end[:covered][order]
    free, at = 0, -math.pi
    for k in range(covered):
        if lows[k] > at:
            begin[free], end[free] = at, lows[k]
            free += 1
        at = max(at, highs[k])
    if at < math.pi:
        begin[free], end[free] = at, math.pi
        free += 1
    return free


@inner_loop
def add_arc(
    total: NDArray[np.float64], ball: NDArray[np.float64], u: float, begin: float, end: float, weight: float
) -> None:
    """Add what an arc of latitude gives to the integrals of its union.

    Args:
        total: Integrals, shape (TERMS,); changes.
        ball: Centre and radius of the sphere [m], shape (4,).
        u: Height of the circle on the unit sphere.
        begin: Longitude at which the arc begins.
        end: Longitude at which it ends.
        weight: Weight of the latitude.
    """
    circle = ball[3] * math.sqrt(max(1.0 - u * u, 0.0))
    x, y, z = ball[0], ball[1], ball[2] + ball[3] * u
    long = end - begin
    sine, cosine = math.sin(end) - math.sin(begin), math.cos(begin) - math.cos(end)
    double = 0.25 * (math.sin(2.0 * end) - math.sin(2.0 * begin))
    mixed = 0.25 * (math.cos(2.0 * begin) - math.cos(2.0 * end))
    area = weight * ball[3] * ball[3]
    flux = area * u
    of_x, of_y = x * long + circle * sine, y * long + circle * cosine
    of_xx = x * x * long + 2.0 * x * circle * sine + circle * circle * (0.5 * long + double)
    of_yy = y * y * long + 2.0 * y * circle * cosine + circle * circle * (0.5 * long - double)
    of_xy = x * y * long + circle * (x * cosine + y * sine) + circle * circle * mixed
    total[0] += area * long
    total[1] += flux * z * long
    total[2] += flux * z * of_x
    total[3] += flux * z * of_y
    total[4] += flux * 0.5 * z * z * long
    total[5] += flux * z * of_xx
    total[6] += flux * z * of_yy
    total[7] += flux * z * z * z / 3.0 * long
    total[8] += flux * z * of_xy
    total[9] += flux * 0.5 * z * z * of_x
    total[10] += flux * 0.5 * z * z * of_y


@loop
def union_integrals(
    ball: NDArray[np.float64], node: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the integrals of a union of spheres.

    Args:
        ball: Spheres, none inside another one [m], shape (N, 4).
        node: Nodes of a rule on [-1, 1], shape (K,).
        weight: Its weights, shape (K,).

    Returns:
        Area, volume, first and second moments about the origin, shape (TERMS,), float64.
    """
    total = np.zeros(TERMS)
    number = len(ball)
    cap = np.empty((number, 4))
    begin, end = np.empty(2 * number + 2), np.empty(2 * number + 2)
    for i in range(number):
        count = caps_of(ball, i, cap)
        cut = np.empty(2 + 2 * count + count * count)
        cuts = cuts_of(cap, count, cut)
        for part in range(cuts - 1):
            half, middle = 0.5 * (cut[part + 1] - cut[part]), 0.5 * (cut[part + 1] + cut[part])
            if half <= 0.0:
                continue
            for k in range(len(node)):
                # Arcs begin and end like square roots: a sine takes them away.
                u = middle + half * math.sin(0.5 * math.pi * node[k])
                share = weight[k] * half * 0.5 * math.pi * math.cos(0.5 * math.pi * node[k])
                for arc in range(free_arcs(cap, count, u, begin, end)):
                    add_arc(total, ball[i], u, begin[arc], end[arc], share)
    return total
