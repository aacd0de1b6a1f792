"""How densely spheres of several sizes pack at random: random close packing of any mixture of sizes.

Farr and Groot (J. Chem. Phys. 131 (2009) 244104) pack rods on a line. The rods are the chords that a straight
line cuts out of the spheres: a sphere of diameter D is hit in proportion to D^2, and its chord is shorter
than L with probability (L / D)^2. The rods come from the longest to the shortest. Each is put into the
largest gap there is, and keeps at least `GAP` times its own length free at both ends. What the rods fill of
the line, the spheres fill of space. The one constant was fitted by the authors to simulated packings.
"""

from __future__ import annotations

from heapq import heappush, heapreplace

import numpy as np

from packgen.arrays import Float64Array
from packgen.portable import cube

__all__ = ["EQUAL_SPHERES", "close_packing_fraction", "wall_loss"]

GAP = 0.7654
"""Least gap beside a rod over its length (Farr and Groot's f)."""

EQUAL_SPHERES = 0.6434854620200455
"""Random close packing of equal spheres: what the rods give, 0.6435 as published."""

RODS = 20_000
"""Number of rods. Five times as many give the same to 0.0001, to 0.0005 for sizes 1:1000."""

RATIO_MAX = 1000.0
"""Ratio of sizes beyond which spheres count as dust, all of one size: the voids that they fill are then wider
than they are by so much that a finer dust fills them as densely to 0.002."""

RARE = 0.01
"""Share of the volume in the largest spheres that does not set what counts as dust."""

WALL_LOSS, WALL_LOSS_MAX = 0.15, 0.2
"""Share of the solid that a wall costs the space within a diameter of it, and the largest loss of a vessel:
narrow ones put their spheres in order."""


def close_packing_fraction(radius: Float64Array, weight: Float64Array | None = None) -> float:
    """Return the solid fraction of a random close packing of spheres.

    Args:
        radius: Radii in any unit, each greater than 0, shape (N,), float64, in any order, at least one.
        weight: How many spheres have each radius, in proportion, at least 0, shape (N,), float64; None: as
            many of each.

    Returns:
        The fraction. It depends neither on the unit nor on the order, and has the same digits on every
        machine.

    Raises:
        ValueError: There is no sphere.
    """
    radius = np.asarray(radius, np.float64)
    if weight is None:
        radius = np.sort(radius)
        weight = np.ones(len(radius))
    else:
        order = np.argsort(radius, kind="stable")
        order = order[weight[order] > 0.0]
        radius, weight = radius[order], weight[order]
    if len(radius) == 0:
        raise ValueError("close_packing_fraction: found no sphere, expected at least one")
    if radius[0] == radius[-1]:
        return EQUAL_SPHERES
    return _filled_share(_rods(*_without_dust(radius / radius[-1], weight)))


def wall_loss(area: float, volume: float, diameter: float) -> float:
    """Return the share of the solid fraction that walls cost a vessel.

    Spheres at a wall leave more room than others, and that only within a few diameters of it, so that the
    loss is proportional to area times diameter over volume (Scott, Nature 188 (1960) 908, found the solid
    fractions of steel balls to fall so with the vessel's size; Desmond and Weeks, Phys. Rev. E 80 (2009)
    051305, explain it by a boundary layer). The factor is that of beds of packgen at friction 0.5 and 0.2. It
    meets the solid fractions of tubes 5, 10 and 20 diameters wide and of boxes 10 and 16 wide to 0.009.

    Args:
        area: Area of the walls at the bed [m2].
        volume: Volume of the bed [m3], greater than 0.
        diameter: Mean diameter of the spheres by volume [m].

    Returns:
        The loss of the whole bed against its core.
    """
    return min(WALL_LOSS * area * diameter / volume, WALL_LOSS_MAX)


def _without_dust(size: Float64Array, weight: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return rising sizes and their weights, dust as much volume of the coarsest dust."""
    volume = weight * cube(size)
    below = np.cumsum(volume)
    main = size[np.searchsorted(below, (1.0 - RARE) * below[-1])]
    dust = int(np.searchsorted(size, main / RATIO_MAX))
    if dust == 0:
        return size, weight
    coarsest = main / RATIO_MAX
    share = below[dust - 1] / (coarsest * coarsest * coarsest)
    return np.append(coarsest, size[dust:]), np.append(share, weight[dust:])


def _rods(size: Float64Array, weight: Float64Array) -> list[float]:
    """Return the lengths of `RODS` rods, falling: the middles of chord classes of spheres, sizes rising."""
    hit = weight * size * size
    smaller = np.concatenate([[0.0], np.cumsum(hit)])
    larger = np.concatenate([np.cumsum(weight[::-1])[::-1], [0.0]])
    # Rods up to a length L: those of all smaller spheres, and L^2 of each larger one.
    up_to = smaller[1:] + size * size * larger[1:]
    wanted = (np.arange(RODS) + 0.5) / RODS * smaller[-1]
    place = np.minimum(np.searchsorted(up_to, wanted), len(size) - 1)
    length = np.sqrt(np.maximum(wanted - smaller[place], 0.0) / larger[place])
    falling: list[float] = length[::-1].tolist()
    return falling


def _filled_share(rods: list[float]) -> float:
    """Return what rods, from the longest to the shortest, fill of a line without ends."""
    gaps = [-GAP * rods[0]]  # negative: a heap has its least entry first
    filled = rods[0]
    for rod in rods[1:]:
        free = GAP * rod
        rest = max(free, -gaps[0] - rod - free)
        heapreplace(gaps, -free)
        heappush(gaps, -rest)
        filled += rod
    return filled / (filled - sum(gaps))
