"""The space that spheres are put into: its walls, what is in it, and the search for its voids."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from packgen.arrange.space.feature_kernels import CONE, PLANE
from packgen.arrange.space.seams import NO_SEAMS, Seams
from packgen.arrange.space.sides import InsideMap
from packgen.arrange.space.walls import simple_features
from packgen.arrange.void_filling.ball_tree_kernels import LEVELS, BallTree, add_balls
from packgen.arrange.void_filling.cell_kernels import LISTED, Cells
from packgen.arrange.void_filling.climb_kernels import new_bench
from packgen.arrange.void_filling.place_kernels import fill_drawn, list_peaks
from packgen.arrange.void_filling.search_kernels import (
    EXHAUSTED,
    MORE_ROOM,
    PAUSED,
    PEAKS,
    WAITING,
    Search,
    fill_freely,
)
from packgen.arrange.void_filling.wall_kernels import Walls, distances_of_all
from packgen.arrays import Float64Array
from packgen.clumps.tree import triangle_tree
from packgen.geometry import Mesh, Polyhedron, Shape, Slice, Surface
from packgen.portable import cube_root, scalar_power

PLANES_MAX = 64
"""Planes up to which each one is looked at; a convex mesh of more is looked at by its triangles."""

SIDE_CELLS = 1_500_000
"""About how many cells tell inside from outside."""

STEPS = 20_000
"""Steps between two looks at the clock and the keyboard."""

REPEATED = 1000
"""Spheres of one radius that are asked for at once."""

ROUNDING = 4.0e-16
"""Largest error of a coordinate, in extents of the space."""


class Hollow:
    """Walls, spheres and the voids between them."""

    def __init__(
        self, shapes: Sequence[Shape | Slice], bounds: Float64Array, seams: Seams, ball: Float64Array
    ) -> None:
        """Take what is there.

        Args:
            shapes: What bounds the spheres: they are in all of these.
            bounds: The space's bounding box [m], shape (2, 3).
            seams: Where the first of the shapes wraps around.
            ball: Centres and radii of spheres that are there [m], shape (N, 4).
        """
        self._walls = make_walls(shapes, bounds, seams)
        middle, half = bounds.mean(axis=0), 0.5 * float((bounds[1] - bounds[0]).max())
        extent = float(np.abs(bounds).max())
        self.slack = ROUNDING * extent
        reach = float((ball[:, 3]).max(initial=0.0)) + float(np.abs(ball[:, :3] - middle).max(initial=0.0))
        self._tree = _new_tree(np.append(middle, max(half, reach) * (1.0 + 1e-9)), len(ball) + 1024)
        while len(self._tree.first) < 8 * LEVELS + 4 * len(ball):
            self._tree = _more_balls(self._tree)
        add_balls(self._tree, np.ascontiguousarray(ball, np.float64))
        self._before = len(ball)
        self._search = _new_search(4096, 1024)
        self._bench = new_bench()
        self._start(middle, half)

    @property
    def ball(self) -> Float64Array:
        """Centres and radii of the spheres added [m], shape (N, 4)."""
        return self._tree.ball[self._before : self._tree.size[0]]

    def distance(self, point: Float64Array) -> Float64Array:
        """Return how far points (N, 3) are from everything [m], (N,); negative beyond a wall or in a ball."""
        return distances_of_all(self._walls, self._tree, np.ascontiguousarray(point, np.float64))

    def fill(
        self, least: float, count: float, solid: float, tell: Callable[[int], None] = lambda _: None
    ) -> bool:
        """Add the largest sphere that fits, again and again.

        Args:
            least: Least radius [m].
            count: How many at most.
            solid: Solid volume that is enough, over 4 pi / 3 [m3].
            tell: Called now and then with the number of spheres added.

        Returns:
            Whether they were added: False where no void is left that is large enough.
        """
        limits = np.array([count, solid, 0.0])
        while True:
            limits[2] = STEPS
            end = fill_freely(self._walls, self._tree, self._bench, self._search, least, self.slack, limits)
            if end == MORE_ROOM:
                self._grow()
            elif end == PAUSED:
                tell(len(self.ball))
            else:
                return bool(end != EXHAUSTED)

    def place(
        self,
        radii: Float64Array,
        solid: float,
        down: Float64Array,
        least: float | None = None,
        tell: Callable[[int], None] = lambda _: None,
    ) -> np.ndarray:
        """Put spheres of given radii into the smallest voids that take them.

        Args:
            radii: Radii, the largest first [m], shape (N,).
            solid: Solid volume that is enough, over 4 pi / 3 [m3].
            down: Unit vector to where each sinks in its void, shape (3,).
            least: Radius below which no void will be wanted later [m]; None: that of the smallest of these.
            tell: Called now and then with the number of spheres added.

        Returns:
            Which have found a place, shape (N,).
        """
        placed = np.zeros(len(radii), np.bool_)
        limits = np.array([0.0, solid, 0.0])
        while len(radii):
            limits[2] = STEPS
            end = fill_drawn(
                self._walls, self._tree, self._bench, self._search, radii, placed, down,
                float(radii[-1]) if least is None else least, self.slack, limits,
            )  # fmt: skip
            if end == MORE_ROOM:
                self._grow()
            elif end == PAUSED:
                tell(len(self.ball))
            else:
                break
        list_peaks(self._search)
        return placed

    def repeat(
        self, radius: float, most: int, solid: float, down: Float64Array, least: float,
        tell: Callable[[int], None] = lambda _: None,
    ) -> int:  # fmt: skip
        """Put spheres of one radius [m] into the voids until no void takes one; return how many.

        Args:
            radius: The radius [m].
            most: How many at most.
            solid: Solid volume that is enough, over 4 pi / 3 [m3].
            down: See `place`.
            least: See `place`.
            tell: See `place`.
        """
        count = 0
        while count < most and count * scalar_power(radius, 3) < solid:
            some = np.full(min(REPEATED, most - count), radius)
            placed = int(self.place(some, solid - count * scalar_power(radius, 3), down, least, tell).sum())
            count += placed
            if placed < len(some):
                break
        return count

    def _start(self, middle: Float64Array, half: float) -> None:
        search = self._search
        search.cells.cell[0] = [*middle, half]
        search.cells.top[0] = np.inf
        search.cells.total[0] = 1
        search.hint[0] = -1
        search.waiting[0], search.bound[0] = 0, np.inf
        search.size[WAITING] = 1

    def _grow(self) -> None:
        """Make room."""
        tree, search = self._tree, self._search
        if tree.size[0] + 1 >= len(tree.ball) or tree.size[1] + LEVELS + 1 >= len(tree.first):
            self._tree = _more_balls(tree)
        self._search = _more_search(search)


def make_walls(shapes: Sequence[Shape | Slice], bounds: Float64Array, seams: Seams) -> Walls:
    """Return what bounds the spheres that are in all of some shapes, the first of which may wrap around."""
    features: dict[int, list[Float64Array]] = {}
    surfaces: list[Surface] = []
    for index, shape in enumerate(shapes):
        if isinstance(shape, Mesh):
            surfaces.append(shape.surface)
        elif isinstance(shape, Polyhedron) and len(shape.normal) > PLANES_MAX:
            surfaces.append(_closed(shape))
        else:
            for kind, row in simple_features(shape, seams if index == 0 else NO_SEAMS):
                features.setdefault(kind if kind in (PLANE, CONE) else -1, []).append(row)
    plane, cone, hollow = (
        np.array(features.get(kind, [])).reshape(-1, width)
        for kind, width in ((PLANE, 4), (CONE, 9), (-1, 4))
    )
    origin, cells, label = np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3, np.int64), np.zeros(0, np.int8)
    box, corner = np.empty((0, 6)), np.empty((0, 9))
    if surfaces:
        tree = triangle_tree(np.concatenate([each.vertices[each.faces] for each in surfaces]))
        box, corner = np.array(tree.box), np.array(tree.corner)
        size = cube_root(float(np.prod(bounds[1] - bounds[0])) / SIDE_CELLS)
        sides = InsideMap.over(surfaces, bounds, size / 0.55)
        origin, cells, label = np.append(sides.grid.origin, sides.grid.size), sides.grid.cells, sides.label
    return Walls(
        plane, cone, hollow, box, corner, _normals(corner), origin, np.array(cells, np.int64), label,
        np.array(seams.low, np.float64), np.array(seams.period, np.float64),
    )  # fmt: skip


def _normals(corner: Float64Array) -> Float64Array:
    a, b, c = corner[:, :3], corner[:, 3:6], corner[:, 6:]
    normal = np.cross(b - a, c - a)
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300))


def _closed(shape: Polyhedron) -> Surface:
    """Return the hull of a convex mesh, whose open top is a wall."""
    from scipy.spatial import ConvexHull

    vertices = shape.surface.vertices
    hull = ConvexHull(vertices)
    faces = hull.simplices.astype(np.int64)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    outward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) > 0.0
    faces[~outward] = faces[~outward][:, ::-1]
    return Surface(vertices, faces)


def _new_tree(cube: Float64Array, room: int) -> BallTree:
    first = np.full(4 * room, -1, np.int64)
    return BallTree(
        np.empty((room, 4)), np.empty(room, np.int64), np.zeros((4 * room, 8), np.int64), first,
        np.asarray(cube, np.float64), np.array([0, 1], np.int64),
    )  # fmt: skip


def _longer(array: np.ndarray) -> np.ndarray:
    grown = np.zeros((2 * len(array), *array.shape[1:]), array.dtype)
    grown[: len(array)] = array
    return grown


def _more_balls(tree: BallTree) -> BallTree:
    return tree._replace(
        ball=_longer(tree.ball), following=_longer(tree.following), child=_longer(tree.child),
        first=_longer(tree.first),
    )  # fmt: skip


def _new_search(cells: int, peaks: int) -> Search:
    of_cells, of_peaks = (cells,), (peaks,)
    return Search(
        Cells(
            np.empty((cells, 4)), np.zeros(of_cells, np.int32), np.empty(of_cells), np.empty(of_cells),
            np.empty((cells, LISTED), np.int32), np.zeros(of_cells, np.int32), np.zeros(of_cells, np.int8),
            np.zeros(of_cells, np.bool_), np.zeros(1, np.int64),
        ),
        np.empty(of_cells, np.int64), np.empty(of_cells, np.int64), np.empty(of_cells, np.int64),
        np.empty(of_cells),
        np.zeros((peaks, 5)), np.empty(of_peaks, np.int64), np.empty(of_peaks, np.int64), np.empty(of_peaks),
        np.zeros(9, np.int64), np.zeros(5),
    )  # fmt: skip


def _more_search(search: Search) -> Search:
    """Return a search with twice the room for cells or peaks, whichever is short."""
    cells = search.cells
    if cells.total[0] + 8 >= len(cells.cell):
        of_cells = ("cell", "child", "top", "away", "item", "listed", "state", "stale")
        return search._replace(
            cells=cells._replace(**{name: _longer(getattr(cells, name)) for name in of_cells}),
            hint=_longer(search.hint), next_cell=_longer(search.next_cell), waiting=_longer(search.waiting),
            bound=_longer(search.bound),
        )  # fmt: skip
    if search.size[PEAKS] + 1 < len(search.peak):
        return search
    return search._replace(
        peak=_longer(search.peak), first_cell=_longer(search.first_cell), ready=_longer(search.ready),
        radius=_longer(search.radius),
    )  # fmt: skip
