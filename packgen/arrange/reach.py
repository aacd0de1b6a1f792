"""How far a neighbour list looks beyond a sphere, so that it holds for a while."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array


def list_reach(radius: Float64Array, moving: int, skin: float, reference: float) -> Float64Array:
    """Return the reach of each sphere: its radius and how far it may move while the list holds [m].

    The margin is half the skin of the geometric mean of both radii. In one layer all move by about as much,
    the small spheres by more of their own radii than the large ones: of margins in proportion to the radii
    the small spheres' would be outrun at once while the large ones' fill the list with pairs that never meet.

    Args:
        radius: Radii [m], shape (N,), float64.
        moving: The first so many spheres move; what is fixed reaches as far as its surface.
        skin: Twice the margin of a sphere of the reference radius, in units of it.
        reference: Mean radius of what moves [m].

    Returns:
        Reaches [m], shape (N,), float64.
    """
    reach = radius.copy()
    reach[:moving] += 0.5 * skin * np.sqrt(reference * radius[:moving])
    return reach
