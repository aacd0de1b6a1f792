"""What filling voids will come to: how many spheres of free sizes, and how much of the space they fill.

Spheres put one after the other into the largest void are as those of Apollonian packings: their number above
a size falls with its power 2.47 (Borkovec, de Paris and Peikert, Fractals 2 (1994) 521), and so the voids
left with a power 0.215 of their number. The factors are those of packgen's beds, to about a fifth.
"""

from __future__ import annotations

from packgen.distributions import UNIT_VOLUME, Free

__all__ = ["expected_voids"]

DIMENSION = 2.47
PER_SIZE = 0.05
"""Spheres larger than a share s of the space's size, the edge of a cube of its volume: about 0.05 s^-2.47."""

LEFT, LEFT_POWER = 0.8, (3.0 - DIMENSION) / DIMENSION
"""Share of the space that n spheres leave: about 0.8 n^-0.215."""


def expected_voids(free: Free, asked: int | None, coverage: float | None, room: float) -> tuple[float, float]:
    """Return about how many spheres fill an empty space, and what share of it.

    Args:
        free: Bounds of their sizes.
        asked: How many are asked for; None: as many as there are voids.
        coverage: Share that is enough; None: none is.
        room: The space's volume [m3].
    """
    size = float(room ** (1.0 / 3.0))
    count = max(PER_SIZE * (size / free.radius_min) ** DIMENSION, 1.0)
    if asked is not None:
        count = min(count, float(asked))
    if coverage is not None:
        count = min(count, max((LEFT / (1.0 - coverage)) ** (1.0 / LEFT_POWER), 1.0))
    share = max(1.0 - LEFT * count**-LEFT_POWER, 0.5)
    if free.radius_max is not None:
        share = min(share, count * UNIT_VOLUME * free.radius_max**3 / room)
    return count, share
