"""Makes a clump: chooses inscribed spheres of a body one by one and improves them together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.clumps.body import Body
from packgen.clumps.cover_kernels import choose, covered_alone, gaps, polish
from packgen.clumps.equal import equal_balls
from packgen.clumps.points import surface_points
from packgen.clumps.properties import union_area, union_properties
from packgen.errors import GeometryError

SPHERES_MAX = 1000
"""Spheres of a clump at most, where an error decides."""

POINTS_MIN, POINTS_MAX, POINTS_A_SPHERE, POINTS_MISSED = 20_000, 200_000, 400, 300
"""Points within the body: at least, at most, for each sphere, and how many the wanted error leaves out."""

BALLS_MIN, BALLS_MAX, BALLS_A_SPHERE = 1500, 8000, 30
"""Balls to choose from: at least, at most, for each sphere."""

STEPS = (0.3, 0.15, 0.08, 0.04, 0.02)
"""How far spheres try to move in the rounds of a polish, in radii."""

DIRECTIONS = 12
REPLACED, REPLACEMENTS = 0.2, 2
"""Share of the spheres that is chosen anew after a polish, and how often."""

MARGIN = 0.15
"""Equivalent diameters around the body that are looked at where spheres may stick out."""

SURFACE_POINTS = 8000
SURFACE_TRIES = 4
SHRUNK = 1.0 - 1.0e-12
"""Inscribed spheres stay inside in spite of rounding."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a clump is to be like. It ends where the first of its limits is reached.

    Attributes:
        spheres: Number of spheres at most; null: `SPHERES_MAX`.
        volume_error: Volume that the spheres miss, or put outside, as a share of the body's; null: any.
        surface_error: Largest distance of the body's surface from the spheres, in equivalent diameters of the
            body; null: any.
        least_radius: Least radius of a sphere [m].
        equal: Whether all spheres have one radius.
        best_fit: Whether spheres may stick out: then the volume and the centre of mass are the body's.
    """

    spheres: int | None = None
    volume_error: float | None = None
    surface_error: float | None = None
    least_radius: float = 0.0
    equal: bool = False
    best_fit: bool = False

    def __post_init__(self) -> None:
        limits = (self.spheres, self.volume_error, self.surface_error)
        if all(each is None for each in limits):
            raise ValueError("found no limit, expected spheres, volume_error or surface_error")
        if self.volume_error is not None and self.surface_error is not None:
            raise ValueError("found volume_error and surface_error, expected one of them")
        if self.surface_error is not None and (self.equal or self.best_fit):
            raise ValueError(
                "found surface_error with equal or best_fit, expected spheres of any size, inside"
            )

    @property
    def most(self) -> int:
        """Number of spheres at most."""
        return SPHERES_MAX if self.spheres is None else self.spheres


def clump_spheres(body: Body, wanted: Wanted, place: str = "mesh") -> Float64Array:
    """Return spheres that fill a body.

    Args:
        body: The body.
        wanted: What they are to be like.
        place: What messages call the body.

    Returns:
        Centres and radii [m] along the mesh's axes, the body's centre of mass at the origin, the largest
        first, shape (N, 4), float64.

    Raises:
        GeometryError: No sphere of the least radius fits.
    """
    least = wanted.least_radius / body.unit
    maker = _Maker(body, wanted, _inscribed(body, wanted, least, place), least)
    spheres = maker.by_surface() if wanted.surface_error is not None else maker.by_volume()
    order = np.argsort(-spheres[:, 3], kind="stable")
    return body.to_mesh_axes(spheres[order])


def _inscribed(body: Body, wanted: Wanted, least: float, place: str) -> Float64Array:
    """Return the balls to choose from, all of at least the least radius."""
    likely = SPHERES_MAX if wanted.volume_error is None else round(1.2 / wanted.volume_error)
    number = min(max(BALLS_A_SPHERE * min(wanted.most, likely), BALLS_MIN), BALLS_MAX)
    ball = body.touching_balls(number)
    if len(ball) == 0:
        raise GeometryError(
            f"{place}: found no room for a sphere, expected a body with an inside; is it a sheet?"
        )
    if ball[:, 3].max() < least:
        raise GeometryError(
            f"{place}: the largest sphere inside has a radius of about {ball[:, 3].max() * body.unit:.4g} m, "
            f"expected one of at least {wanted.least_radius:.4g} m; lower the least radius"
        )
    return ball[ball[:, 3] >= least]


class _Maker:
    """Makes one clump, in equivalent diameters of its body.

    Args:
        body: The body.
        wanted: What is asked for.
        ball: Balls to choose from, shape (K, 4).
        least: Least radius.
    """

    def __init__(self, body: Body, wanted: Wanted, ball: Float64Array, least: float) -> None:
        self._body, self._wanted, self._ball, self._least = body, wanted, ball, least
        margin = MARGIN if wanted.best_fit else 0.0
        count = POINTS_A_SPHERE * (wanted.spheres or 0)
        if wanted.volume_error is not None:
            count = max(count, int(POINTS_MISSED / wanted.volume_error))
        points = body.points(min(max(count, POINTS_MIN), POINTS_MAX), margin)
        self._inside = points.inside
        self._point, self._sign = points.inside, np.ones(len(points.inside), np.int32)
        if wanted.best_fit:
            self._point = np.concatenate([points.inside, points.outside])
            self._sign = np.concatenate([self._sign, np.full(len(points.outside), -1, np.int32)])
        self._radius = 0.0

    def by_volume(self) -> Float64Array:
        """Return the spheres that cover the volume asked for, or as much as they can."""
        wanted = self._wanted
        error = 0.0 if wanted.volume_error is None else wanted.volume_error
        rest = int(error * len(self._inside))
        if wanted.equal:
            self._ball, self._radius = equal_balls(
                self._body, self._inside, self._ball, wanted.most, rest, self._least
            )
        spheres = self._improved(self._grown(np.empty((0, 4)), wanted.most, rest))
        while wanted.volume_error is not None and len(spheres) < wanted.most:
            found = self._misplaced(spheres)
            if found <= error:
                break
            # The points promised more than the spheres hold. More spheres miss less in proportion.
            needed = max(int(len(spheres) * min(found / error, 1.5)), len(spheres) + 1)
            grown = self._grown(spheres, min(needed, wanted.most), 0)
            if len(grown) == len(spheres):
                break
            spheres = self._improved(grown)
        return spheres

    def _grown(self, spheres: Float64Array, most: int, rest: int) -> Float64Array:
        """Return spheres with more of them, chosen by what they cover newly."""
        ball = np.concatenate([spheres, self._ball])
        chosen = choose(self._inside, ball, len(spheres), most, rest)
        return np.concatenate([spheres, ball[chosen]])

    def _improved(self, spheres: Float64Array) -> Float64Array:
        """Return spheres moved to where they cover more; the least useful ones are chosen anew."""
        best = self._polished(spheres)
        if len(spheres) > 1:
            for _ in range(REPLACEMENTS):
                alone = covered_alone(self._inside, best)
                kept = best[
                    np.sort(
                        np.argsort(-alone, kind="stable")[: len(best) - max(int(REPLACED * len(best)), 1)]
                    )
                ]
                other = self._polished(self._grown(kept, len(spheres), 0))
                if self._gain(other) > self._gain(best):
                    best = other
        return self._matched(best) if self._wanted.best_fit else best * [1.0, 1.0, 1.0, SHRUNK]

    def _polished(self, spheres: Float64Array) -> Float64Array:
        rng = np.random.default_rng(len(spheres))
        direction = rng.normal(size=(len(STEPS), DIRECTIONS, 3))
        direction /= np.linalg.norm(direction, axis=2, keepdims=True)
        moved = np.ascontiguousarray(spheres).copy()
        tree, inscribed = self._body.tree, not self._wanted.best_fit
        step = np.array(STEPS)
        polish(
            tree.box,
            tree.corner,
            self._point,
            self._sign,
            moved,
            step,
            direction,
            self._least,
            self._radius,
            inscribed,
        )
        return moved

    def _gain(self, spheres: Float64Array) -> int:
        """Return how many points inside are covered, less those outside."""
        return int(self._sign[gaps(self._point, spheres) <= 0.0].sum())

    def _matched(self, spheres: Float64Array) -> Float64Array:
        """Return spheres whose union has the body's volume, radii changed alike, and its centre of mass."""
        found = spheres.copy()
        for _ in range(20):
            lacking = self._body.volume - union_properties(found).volume
            if abs(lacking) <= 1e-9 * self._body.volume:
                break
            by = lacking / union_area(found)
            found[:, 3] = np.maximum(found[:, 3] + by, 0.5 * found[:, 3])
        found[:, :3] -= union_properties(found).centre
        return found

    def _misplaced(self, spheres: Float64Array) -> float:
        """Return the volume that is missing or outside, as a share of the body's."""
        if not self._wanted.best_fit:
            return 1.0 - union_properties(spheres).volume / self._body.volume
        covered = gaps(self._point, spheres) <= 0.0
        return float((covered != (self._sign > 0)).sum() / len(self._inside))

    def by_surface(self) -> Float64Array:
        """Return the fewest spheres found that are near all of the surface."""
        assert self._wanted.surface_error is not None
        corners = self._body.corners
        points = [
            surface_points(corners, count, shift)[0]
            for count, shift in ((SURFACE_POINTS, 0.5), (20_000, 0.2))
        ]
        vertices = np.unique(corners.reshape(-1, 3), axis=0)
        near, judge = (np.concatenate([each, vertices]) for each in points)
        error = self._wanted.surface_error
        spheres = self._near_all(near, error)
        for _ in range(SURFACE_TRIES):
            if gaps(judge, spheres).max() <= self._wanted.surface_error or len(spheres) >= self._wanted.most:
                break
            error *= 0.93
            spheres = self._near_all(near, error)
        return spheres * [1.0, 1.0, 1.0, SHRUNK]

    def _near_all(self, point: Float64Array, error: float) -> Float64Array:
        grown = self._ball + np.array([0.0, 0.0, 0.0, error])
        chosen = choose(point, grown, 0, self._wanted.most, 0)
        return self._ball[chosen]
