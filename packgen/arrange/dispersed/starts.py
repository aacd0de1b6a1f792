"""Where dispersed spheres start: at random, but evenly, the large ones first, and no small one in a large."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrange.dispersed.crowding import Room, missing_layer, within
from packgen.arrays import Float64Array
from packgen.portable import cube_root, octaves

TRIES = 12
"""Times that points are drawn before there may be fewer than wanted."""

CELLS_A_POINT, CELLS_LEAST = 100, 20_000
"""Cells of a grid at most: for each point wanted, and besides."""

VOID_SAMPLES = 4_000
"""Least number of random points among which the largest voids are sought."""


def even_points(
    room: Room,
    count: int,
    clearance: float,
    around: tuple[Float64Array, Float64Array],
    fraction: float,
    rng: np.random.Generator,
) -> Float64Array:
    """Return random points of a room, over wide distances as even as a fluid of hard spheres.

    Points without any rule leave a zone denser here and thinner there, and over wide distances that takes
    small moves longest to even out. Random points, one in each cell of a grid, are as many here as there. A
    share q of them, chosen at random, varies by 1 - q of what points without a rule do, which for hard
    spheres of solid fraction n is (1 - n)^4 / (1 + 2 n)^2 (Percus and Yevick's compressibility).

    Args:
        room: The room.
        count: How many.
        fraction: Solid fraction of the fluid.
        clearance: How far from the walls at least [m].
        around: Centres (S, 3) and reaches (S,) of spheres that hold none of them [m].
        rng: Source of randomness.

    Returns:
        Points [m], shape (n, 3), n at most ``count``; fewer only where hardly any point has that clearance.
    """
    low, high = room.region.bounds
    extent = high - low
    lacking = 1.0 - fraction
    varied = (lacking * lacking / (1.0 + 2.0 * fraction)) ** 2
    enough = math.ceil(count / max(1.0 - varied, 0.05))
    wanted = float(enough)
    points = np.empty((0, 3))
    for _ in range(TRIES):
        size = cube_root(float(np.prod(extent)) / wanted)
        cells = np.maximum(np.ceil(extent / size), 1.0)
        place = np.stack(np.meshgrid(*(np.arange(each) for each in cells), indexing="ij"), axis=-1)
        points = low + (place.reshape(-1, 3) + rng.random((int(np.prod(cells)), 3))) * (extent / cells)
        points = points[room.open(points, clearance)]
        points = points[~within(points, *around, room.region)]
        if len(points) >= enough:
            break
        # A little more than what is missing.
        share = max(len(points), 0.1 * enough) / enough
        wanted = min(wanted * 1.01 / min(share, 0.999), CELLS_A_POINT * enough + CELLS_LEAST)
    return points[np.sort(rng.permutation(len(points))[:count])]


def start_classes(half: Float64Array) -> list[np.ndarray]:
    """Return the spheres (M,) by octave of size, the largest first, each as indices."""
    octave = octaves(half.max() / half)
    return [np.flatnonzero(octave == number) for number in np.unique(octave)]


def starts_of(
    room: Room,
    chosen: tuple[Float64Array, Float64Array],
    placed: tuple[Float64Array, Float64Array],
    fraction: float,
    rng: np.random.Generator,
) -> Float64Array:
    """Return where spheres of an octave of sizes start [m], shape (n, 3); n is less where there is no room.

    At walls as many start as a fluid of hard spheres has there; see ``missing_layer``.

    Args:
        room: The room.
        chosen: ``half`` and ``wall`` of the spheres, see ``Crowd``, shape (m,) each.
        placed: Centres (S, 3) and ``half`` (S,) of the larger ones, which have their places.
        fraction: Solid fraction away from the walls.
        rng: Source of randomness.
    """
    half, wall = chosen
    mean = float(half.mean())
    center, large = placed
    # A sphere hardly larger than a newcomer is a neighbour like any other.
    much = large > 1.5 * mean
    around = (center[much], large[much])
    for layer in (missing_layer(fraction), 0.5, 0.0):
        clearance = float(wall.mean()) - mean + layer * mean
        points = even_points(room, len(half), clearance, around, fraction, rng)
        if len(points) == len(half):
            break
    return points


def voids(
    room: Room,
    half: Float64Array,
    wall: float,
    placed: tuple[Float64Array, Float64Array],
    rng: np.random.Generator,
) -> Float64Array:
    """Return the points farthest from all spheres, apart from each other [m], shape (n, 3).

    Args:
        room: The room.
        half: ``half`` of the spheres that need a place, the largest first, shape (n,).
        wall: Their least distance from a wall [m].
        placed: Centres (S, 3) and ``half`` (S,) of those that have one.
        rng: Source of randomness.
    """
    region, (center, large) = room.region, placed
    seams = region.walls.seams
    low, high = region.bounds
    points = low + rng.random((max(VOID_SAMPLES, 20 * len(half)), 3)) * (high - low)
    points = points[room.open(points, wall)]
    apart = np.full(len(points), np.inf)
    for members in start_classes(large) if len(large) else []:
        nearest, index = seams.tree(center[members]).query(seams.placed(points))
        apart = np.minimum(apart, nearest - large[members][index])
    picked: list[int] = []
    tree = cKDTree(points) if len(points) else None
    free = np.ones(len(points), bool)
    for place in np.argsort(-apart, kind="stable"):
        if len(picked) == len(half) or tree is None:
            break
        if free[place]:
            free[tree.query_ball_point(points[place], 2.0 * float(half[len(picked)]))] = False
            picked.append(int(place))
    return np.asarray(points[picked])
