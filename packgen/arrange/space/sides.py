"""Which side of triangulated walls a point is on: a grid of cells, cut by a wall or wholly on one side.

Cells that no wall enters form connected regions, each on one side as a whole: one winding number decides it.
Winding numbers hold for any shape, and neither a T-junction nor a crack moves them by much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label as connected

from packgen.arrange.space.map_kernels import Grid
from packgen.arrange.space.side_kernels import CUT, INSIDE, first_members, mark_cut, points_inside
from packgen.arrange.space.walls import WallTable
from packgen.arrays import Float64Array
from packgen.geometry import Surface
from packgen.geometry.winding import winding_numbers
from packgen.portable import cube_root

CELL_SIZE = 0.55
"""In smallest radii: no wall enters the cell of a sphere's centre that is its radius away from every wall,
for the cell's diagonal, 0.95, is shorter."""

CELLS_MAX = 20_000_000
ANGLES_MAX = 400_000_000
"""Solid angles computed at most; the smallest regions beyond that, nooks of a few cells, count as outside."""


@dataclass(frozen=True, eq=False, slots=True)
class InsideMap:
    """The labelled grid over a region that meshes bound.

    Attributes:
        grid: The grid, of C cells.
        label: OUTSIDE, INSIDE or CUT (see ``side_kernels``) of each cell, shape (C,), int8.
    """

    grid: Grid
    label: NDArray[np.int8]

    @classmethod
    def over(cls, surfaces: Sequence[Surface], bounds: Float64Array, radius: float) -> InsideMap:
        """Return the map of the space inside all of some surfaces.

        Args:
            surfaces: Closed surfaces, counter-clockwise from outside.
            bounds: Lower and upper corner of the space of interest [m], shape (2, 3).
            radius: Smallest radius that will be placed [m].
        """
        extent = bounds[1] - bounds[0]
        size = max(CELL_SIZE * radius, cube_root(float(np.prod(extent)) / CELLS_MAX))
        cells = np.ceil(extent / size).astype(np.int64) + 2
        # Odd, so that flat walls on round numbers do not run along the faces of cells.
        grid = Grid(bounds[0] - 0.973 * size, size, cells)
        label = np.zeros(int(np.prod(cells)), np.int8)
        corners = [surface.vertices[surface.faces].reshape(-1, 9) for surface in surfaces]
        for corner in corners:
            mark_cut(corner, grid, label)
        _label_regions(label, corners, grid)
        return cls(grid, label)

    def inside(self, position: Float64Array, walls: WallTable) -> NDArray[np.bool_]:
        """Tell which points [m], shape (N, 3), are inside, shape (N,); ``walls`` hold the same triangles."""
        result: NDArray[np.bool_] = points_inside(
            np.ascontiguousarray(position), self.grid, self.label, walls.reach, walls.features, walls.near
        )
        return result


def _label_regions(label: NDArray[np.int8], corners: Sequence[Float64Array], grid: Grid) -> None:
    """Label each region of cells that no wall enters by the winding numbers of one of its cells."""
    origin, size, cells = grid
    region, count = connected((label != CUT).reshape(tuple(cells[::-1])))
    flat = region.ravel().astype(np.int32, copy=False)
    first, members = first_members(flat, count)
    affordable = max(ANGLES_MAX // max(sum(len(each) for each in corners), 1), 32)
    chosen = np.argsort(-members[1:], kind="stable")[:affordable]
    z, rest = np.divmod(first[1 + chosen], int(cells[1] * cells[0]))
    y, x = np.divmod(rest, int(cells[0]))
    middle = origin + (np.column_stack([x, y, z]) + 0.5) * size
    within = np.zeros(count + 1, bool)
    within[1 + chosen] = np.all([winding_numbers(corner, middle) > 0.5 for corner in corners], axis=0)
    label[within[flat]] = INSIDE
