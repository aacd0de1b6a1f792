"""Where a container is round: the longest upright cylinder of its walls, whatever they are given as."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, read_only
from packgen.geometry import Cone, Container

LEVELS = 129  # heights at which the walls are cut
OUT_OF_ROUND_MAX = 0.02  # of the radius: a prism of 16 facets is round
SLOPE_MAX = 1.0e-3  # of the radius: a cylinder's radius is constant


@dataclass(frozen=True, eq=False, slots=True)
class RoundPart:
    """An upright circular cylinder of a container's walls.

    Attributes:
        center: A point of its axis [m], shape (3,), float64.
        axis: Unit vector along the axis, against gravity, shape (3,), float64.
        radius: Its radius [m]; of a mesh, that of the circle of equal area.
        low: Height ``axis @ x`` of its lower end [m].
        high: Height of its upper end [m].
    """

    center: Float64Array
    axis: Float64Array
    radius: float
    low: float
    high: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", read_only(self.center, np.float64, (3,), "center"))
        object.__setattr__(self, "axis", read_only(self.axis, np.float64, (3,), "axis"))


def round_part(container: Container, up: Float64Array) -> RoundPart | None:
    """Return the longest part of a container in which it is an upright circular cylinder.

    A cylinder is taken as it is. The walls of anything else are cut at `LEVELS` heights: a level is round
    where all of its outline is within `OUT_OF_ROUND_MAX` of one radius around the container's middle, and
    levels belong together while their radii are within `SLOPE_MAX`.

    Args:
        container: The vessel.
        up: Unit vector against gravity, shape (3,), float64.

    Returns:
        The part; None where the container is nowhere round.
    """
    shape = container.shape
    if isinstance(shape, Cone):
        along = float(shape.axis @ up)
        if shape.radius_bottom != shape.radius_top or abs(along) < 1.0 - 1e-12:
            return None
        ends = sorted([float(shape.base @ up), float(shape.base @ up) + along * shape.height])
        return RoundPart(shape.base, up, shape.radius_top, ends[0], ends[1])
    vertices = container.surface.vertices
    frame = np.linalg.svd(up[None])[2][1:]
    flat = vertices @ frame.T
    middle = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    height = vertices @ up
    corners = np.concatenate([flat - middle, height[:, None]], axis=1)[container.surface.faces]
    level = np.linspace(float(height.min()), float(height.max()), LEVELS + 2)[1:-1]
    low, high = corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    radius = np.array(
        [_round_radius(corners[(low <= each) & (high > each)], each) for each in level.tolist()]
    )
    run = _longest_run(radius)
    if run is None:
        return None
    first, last = run
    return RoundPart(
        middle @ frame, up, float(radius[first:last].mean()), float(level[first]), float(level[last - 1])
    )


def _round_radius(cut: Float64Array, level: float) -> float:
    """Radius [m] of the outline of triangles (K, 3, 3) that a level cuts, by its area; nan if not round."""
    if len(cut) < 3:
        return np.nan
    above = cut[:, :, 2] > level
    # Turn each triangle so that its corner that is alone on a side comes first.
    odd = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    cut = np.take_along_axis(cut, ((odd[:, None] + np.arange(3)) % 3)[:, :, None], axis=1)
    ends = []
    for other in (1, 2):
        share = (level - cut[:, 0, 2]) / (cut[:, other, 2] - cut[:, 0, 2])
        ends.append(cut[:, 0, :2] + share[:, None] * (cut[:, other, :2] - cut[:, 0, :2]))
    first, second = ends
    side = second - first
    share = -np.einsum("ij,ij->i", first, side) / np.maximum(np.einsum("ij,ij->i", side, side), 1e-300)
    nearest = np.linalg.norm(first + np.clip(share, 0.0, 1.0)[:, None] * side, axis=1).min()
    farthest = np.linalg.norm(np.concatenate(ends), axis=1).max()
    cross = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    turned = np.arctan2(cross, np.einsum("ij,ij->i", first, second)).sum()
    if nearest < (1.0 - OUT_OF_ROUND_MAX) * farthest or abs(turned - 2.0 * np.pi) > 1e-6:
        return np.nan
    return float(np.sqrt(0.5 * cross.sum() / np.pi))


def _longest_run(radius: Float64Array) -> tuple[int, int] | None:
    """First level of the longest run of equal radii, and the one after its last; None without any."""
    best = (0, 0)
    for first in range(len(radius)):
        if np.isnan(radius[first]):
            continue
        apart = ~(np.abs(radius[first:] - radius[first]) <= SLOPE_MAX * radius[first])
        last = first + (int(apart.argmax()) if apart.any() else len(apart))
        if last - first > best[1] - best[0]:
            best = (first, last)
    return best if best[1] - best[0] > 1 else None
