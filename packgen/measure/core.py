"""The core of a bed: a box away from walls, floor and surface, where the solid fraction is the bed's own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrays import Float64Array, read_only
from packgen.bed import Bed
from packgen.check import wall_clearance
from packgen.check.mesh import MeshWalls
from packgen.geometry import Box, Container, Mesh
from packgen.measure.particles import particle_radius
from packgen.measure.volumes import mean_diameter

MARGINS = (2.0, 1.0, 0.5)  # wall distances to try, in mean diameters
LEVELS = 41  # heights at which the room between the walls is measured


@dataclass(frozen=True, eq=False, slots=True)
class Core:
    """A box in the bed.

    Attributes:
        center: Its middle [m], shape (3,), float64.
        axes: Unit vectors along its edges, rows of shape (3, 3), float64.
        half: Half its edge lengths [m], shape (3,), float64.
        rule: How it was chosen, in words.
    """

    center: Float64Array
    axes: Float64Array
    half: Float64Array
    rule: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", read_only(self.center, np.float64, (3,), "core.center"))
        object.__setattr__(self, "axes", read_only(self.axes, np.float64, (3, 3), "core.axes"))
        object.__setattr__(self, "half", read_only(self.half, np.float64, (3,), "core.half"))

    @property
    def volume(self) -> float:
        """Its volume [m3]."""
        return float(8.0 * self.half.prod())

    def contains(self, position: Float64Array) -> NDArray[np.bool_]:
        """Return which points [m], shape (N, 3), are in the box, shape (N,), bool."""
        local: Float64Array = (position - self.center) @ self.axes.T
        beyond: Float64Array = (np.abs(local) - self.half).max(axis=1, initial=-np.inf)
        return beyond <= 0.0


def find_core(bed: Bed, up: Float64Array, top: float) -> Core | None:
    """Return the core of a bed.

    In a box it is the inner box of the paper's section on packing density: the container's, a third smaller
    and at the same centre; where the bed does not reach that far up, the same of the box below the bed's top.
    In any other container it is the largest box on a square base, upright around the container's middle, that
    stays two mean diameters (by volume) away from walls, floor and top; in narrow containers one, then half a
    diameter. In a mesh that is not convex it is the cube in the largest ball between the walls, less that
    distance. A periodic cell of any shape has none: all of it is core.

    Args:
        bed: The bed.
        up: Unit vector against gravity, shape (3,), float64.
        top: Height of the bed's top [m].

    Returns:
        The box; None where the bed has no room for one.
    """
    if bed.count == 0:
        return None
    some = bed.position[:: center_step(bed.count)]
    return core_between_walls(bed.container, up, top, mean_diameter(particle_radius(bed)), np.asarray(some))


def center_step(count: int) -> int:
    """Return which of so many centres, one in how many, tell where there is room between walls."""
    return max(1, count // 2000)  # that room is wide compared with a sphere


def core_between_walls(
    container: Container, up: Float64Array, top: float, diameter: float, centers: Float64Array
) -> Core | None:
    """Return the core of a bed of which these are known; see `find_core`.

    Args:
        container: The vessel.
        up: Unit vector against gravity, shape (3,), float64.
        top: Height of the bed's top [m].
        diameter: Mean diameter of the spheres by volume [m].
        centers: Some centres of spheres [m], shape (n, 3); see `center_step`.
    """
    shape = container.shape
    if container.cell is not None:
        return None
    if isinstance(shape, Box):
        return _box_core(shape, up, top)
    for margin in MARGINS:
        if isinstance(shape, Mesh):
            core = _ball_core(shape, centers, up, top, margin * diameter)
        else:
            core = _upright_core(container, up, top, margin * diameter)
        if core is not None and float(core.half.min()) > 0.5 * diameter:
            return core
    return None


def _box_core(box: Box, up: Float64Array, top: float) -> Core | None:
    """The paper's inner box, of the box or of its filled part."""
    low, high = box.min.copy(), box.max.copy()
    center, half = 0.5 * (low + high), (high - low) / 3.0
    rule = "the inner two thirds of the box"
    if float(center @ up + half @ np.abs(up)) > top:
        axis = int(np.abs(up).argmax())
        # Along an axis the level is a coordinate; askew, the highest corner has to stay below the top.
        drop = float(center @ up + half @ np.abs(up)) - top
        if abs(up[axis]) > 1.0 - 1e-12:
            level = top * np.sign(up[axis])
            if up[axis] > 0:
                high[axis] = level
            else:
                low[axis] = level
            center, half = 0.5 * (low + high), (high - low) / 3.0
        else:
            half = half * (1.0 - drop / float(half @ np.abs(up)))
        rule = "the inner two thirds of the box below the bed's top"
    return Core(center, np.eye(3), half, rule) if (half > 0.0).all() else None


def _upright_core(container: Container, up: Float64Array, top: float, margin: float) -> Core | None:
    """The largest upright square box around a convex container's middle, ``margin`` [m] from all walls."""
    axes = _frame(up)
    corners = container.surface.vertices @ axes.T
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    bottom = float(corners[:, 2].min())
    heights = np.linspace(bottom + margin, top - margin, LEVELS)
    if heights[-1] <= heights[0]:
        return None
    width = np.array(
        [_half_width(container, axes, np.append(middle[:2], height), margin) for height in heights]
    )
    # Between two levels a convex container is at least as wide as at the narrower one.
    low, high = np.triu_indices(LEVELS, 1)
    half = np.minimum(width[low], width[high])
    best = int((half**2 * (heights[high] - heights[low])).argmax())
    if half[best] <= 0.0:
        return None
    span = heights[high[best]] - heights[low[best]]
    center = np.append(middle[:2], heights[low[best]] + 0.5 * span) @ axes
    rule = f"the largest upright box {margin:.4g} m away from walls, floor and top"
    return Core(center, axes, np.array([half[best], half[best], 0.5 * span]), rule)


def _half_width(container: Container, axes: Float64Array, center: Float64Array, margin: float) -> float:
    """Half the side [m] of the largest square at a level whose corners keep the margin: by bisection."""
    signs = np.array([[1.0, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]])
    low, high = 0.0, float(np.ptp(container.bounds, axis=0).max())
    if wall_clearance(container, (center @ axes)[None], np.full(1, margin))[0] < margin:
        return 0.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        corners = (center + middle * signs) @ axes
        fits = bool((wall_clearance(container, corners, np.full(4, margin)) >= margin).all())
        low, high = (middle, high) if fits else (low, middle)
    return low


def _ball_core(mesh: Mesh, centers: Float64Array, up: Float64Array, top: float, margin: float) -> Core | None:
    """The cube in about the largest ball around a sphere's centre that no wall and not the top enters."""
    walls = MeshWalls(mesh.surface)
    room = np.minimum(walls.distance_least(centers, 0.25 * margin), top - centers @ up)
    best = int(room.argmax())
    if not walls.contains(centers[best : best + 1])[0]:  # so far out that all have to be asked
        room[~walls.contains(centers)] = -np.inf
        best = int(room.argmax())
    if room[best] <= margin:
        return None
    reach = np.array([room[best] + margin])
    to_wall = float(walls.distance(centers[best : best + 1], reach)[0])
    half = (min(to_wall, top - float(centers[best] @ up)) - margin) / np.sqrt(3.0)
    rule = f"a cube at least {margin:.4g} m away from walls and top"
    return Core(centers[best], _frame(up), np.full(3, half), rule)


def _frame(up: Float64Array) -> Float64Array:
    """Return an orthonormal frame whose last row is ``up``; the coordinate axes if gravity is along one."""
    axis = int(np.abs(up).argmax())
    first = np.zeros(3)
    first[(axis + 1) % 3] = 1.0
    first -= (first @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up])
