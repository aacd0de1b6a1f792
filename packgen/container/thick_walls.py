"""Whether a mesh is the material of a vessel, walls with a thickness, where its inner surface was meant.

CAD programs export a vessel as a solid: one closed surface around its steel. Such a body holds water: from
its hollow no way leads out sideways or down.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from packgen.arrays import Float64Array
from packgen.geometry import Surface

CELLS = 48  # along each side of the box that is examined
SOLID_SHARE = 0.5  # of its convex hull; a body that fills more has no thin walls


def steel_remark(closed: Surface, volume: float, hull_volume: float, up: Float64Array) -> str | None:
    """Return a sentence where a mesh is likely the walls of a vessel, None where it is not.

    Args:
        closed: The mesh, closed, counter-clockwise from outside.
        volume: What it encloses [m3].
        hull_volume: Volume of its convex hull [m3].
        up: Unit vector against gravity, shape (3,).
    """
    if volume > SOLID_SHARE * hull_volume:
        return None
    held = held_volume(closed, up)
    if held <= volume:
        return None
    return (
        f"encloses {volume:.3g} m3 around a hollow of about {held:.2g} m3: are these the walls of a vessel, "
        "with their thickness? The spheres go into the walls; if the hollow is meant, export its inner "
        "surface alone"
    )


def held_volume(closed: Surface, up: Float64Array) -> float:
    """Return the volume [m3] outside of a mesh from which no way leads out sideways or down, roughly."""
    from packgen.check.inside import inside

    frame = np.concatenate([np.linalg.svd(up[None])[2][1:], up[None]])
    frame[0] *= np.sign(np.linalg.det(frame))  # a mirror image would be inside out
    turned = closed.vertices @ frame.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    size = (high - low) / CELLS
    middles = [low[axis] + (np.arange(CELLS) + 0.5) * size[axis] for axis in range(3)]
    points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 3)
    solid = inside(turned[closed.faces], points).reshape(CELLS, CELLS, CELLS)
    return float(np.count_nonzero(_held(~solid)) * size.prod())


def _held(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which free cells (x, y, height) cannot be left: level by level, from the lowest."""
    border = np.ones(free.shape[:2], dtype=bool)
    border[1:-1, 1:-1] = False
    held = np.zeros_like(free)
    below = np.ones(free.shape[:2], dtype=bool)  # below the lowest level all is open
    for level in range(free.shape[2]):
        part, _ = label(free[:, :, level])
        leaving = np.unique(part[free[:, :, level] & (border | below)])
        below = free[:, :, level] & np.isin(part, leaving)
        held[:, :, level] = free[:, :, level] & ~below
    return held
