"""Spheres of given radii jammed in a region, whose walls stay: found is how much larger the radii can be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from packgen.arrange.jammed.meetings import Meetings
from packgen.arrange.jammed.params import Params
from packgen.arrange.jammed.polish import Polisher
from packgen.arrange.jammed.quench import CLOSE, COARSE, FIRST, Care, Rest, SoftBed, decompress, swapped
from packgen.arrange.jammed.starts import random_points
from packgen.arrange.jammed.wholes import whole_moves
from packgen.arrange.space.region import Region
from packgen.arrange.task import Listener, Progress
from packgen.arrays import BoolArray, Float64Array
from packgen.errors import PackingError
from packgen.geometry import Container
from packgen.portable import cube_root
from packgen.programmes.solve import NoSolutionError

FEW = 2_000
"""Number of spheres up to which ``certificate: auto`` has linear programmes prove that they are jammed."""

HELD_MIN = 4
"""Contacts that a sphere needs to be held."""

PRESSED_FIRST = 0.1
"""Largest overlap of the first stage, about, in smaller radii: progress counts from there."""


@dataclass(frozen=True, eq=False, slots=True)
class Jammed:
    """A jammed bed; see ``packgen.jamming.Jamming`` for what is not told here.

    Attributes:
        center: Centres [m], shape (N, 3).
        factor: Common factor of the radii at which nothing overlaps.
        held: Which spheres are held, shape (N,).
        overlap: Largest overlap at this factor, as a fraction of the smaller radius.
        residual: Largest sum of the forces upon a sphere over the mean force; of soft spheres the root mean
            square of all.
    """

    center: Float64Array
    factor: float
    certificate: str
    proven: bool
    held: BoolArray
    contacts: int
    excess: int
    residual: float
    overlap: float
    gap: float
    pressure: float
    programmes: int


class Jammer:
    """Jams spheres in a region.

    Args:
        container: The container.
        region: The zone in it.
        settings: The settings.
        rng: Source of randomness.
        listener: Told of the progress.
        place: Where the scene names the zone, for messages.
        located: Whether the zone has walls of its own.
    """

    def __init__(
        self,
        container: Container,
        region: Region,
        settings: Params,
        rng: np.random.Generator,
        listener: Listener,
        place: str,
        *,
        located: bool,
    ) -> None:
        self._container, self._region, self._settings = container, region, settings
        self._rng, self._listener, self._place, self._located = rng, listener, place, located

    def jam(self, radius: Float64Array, grown: float) -> Jammed:
        """Jam spheres.

        Args:
            radius: Radii [m], shape (N,).
            grown: Cube of the common factor with which they start, soft and too large.

        Raises:
            PackingError: A sphere was pressed through a wall.
        """
        wish = self._settings.certificate
        careful = len(radius) <= FEW if wish == "auto" else bool(wish)
        start = random_points(self._region, cube_root(grown) * radius, self._rng, self._place)
        bed = SoftBed(self._region, start, radius)
        if self._settings.swap:
            grown = swapped(bed, grown, self._rng, lambda share: self._tell("swap", share))
        if not careful:
            rest = self._decompress(bed, grown, COARSE)
            return self._trimmed(self._inside(bed), radius, rest)
        rest = self._decompress(bed, grown, FIRST)
        rest = self._decompress(bed, rest.grown, CLOSE, "decompress")
        try:
            return self._polished(self._inside(bed), radius, rest)
        except NoSolutionError:
            return self._trimmed(bed.center, radius, rest)

    def _inside(self, bed: SoftBed) -> Float64Array:
        """Return the centres.

        Raises:
            PackingError: One is beyond a wall.
        """
        center = bed.center
        if not self._region.holds(center).all():
            raise PackingError(
                f"{self._place}: a sphere was pressed through a wall of the mesh; expected walls farther "
                "apart than a sphere is wide; take another seed, or smaller spheres"
            )
        return center

    def _decompress(self, bed: SoftBed, grown: float, care: Care, stage: str = "quench") -> Rest:
        def tell(rest: Rest) -> None:
            share = math.log(PRESSED_FIRST / max(rest.worst, care.fine))
            self._tell(stage, max(share / math.log(PRESSED_FIRST / care.fine), 0.0))

        self._tell(stage, 0.0)
        return decompress(bed, grown, tell, care)

    def _tell(self, stage: str, share: float) -> None:
        self._listener(Progress(stage, 0, None, 1, share, 0))

    def _polished(self, center: Float64Array, radius: Float64Array, rest: Rest) -> Jammed:
        polisher = Polisher(self._container, self._region.walls, self._located)
        found = polisher.polished(
            center, radius, cube_root(rest.grown), lambda number: self._tell(f"programme {number + 1}", 1.0)
        )
        return Jammed(
            found.center, found.factor, "programme", found.proven, found.held, found.contacts, found.excess,
            found.residual, self._overlap(found.center, radius, found.factor), found.gap, rest.pressure,
            found.programmes,
        )  # fmt: skip

    def _trimmed(self, center: Float64Array, radius: Float64Array, rest: Rest) -> Jammed:
        """Return a bed whose soft spheres became hard: so small that none overlaps."""
        walls, soft = self._region.walls, cube_root(rest.grown)
        near = Meetings.around(center, radius, soft, walls, 0.0).one_a_wall(center)
        held, contacts = held_by(near, len(radius))
        factor = min(near.largest_factor(center), soft)
        ways = len(whole_moves(self._container, center, np.arange(len(radius)), located=self._located).sphere)
        pair, wall = near.gaps(center, factor)
        return Jammed(
            center, factor, "quench", False, held, contacts, contacts - (3 * int(held.sum()) - ways + 1),
            rest.residual, self._overlap(center, radius, factor),
            float(max(pair.max(initial=0.0), wall.max(initial=0.0))), rest.pressure, 0,
        )  # fmt: skip

    def _overlap(self, center: Float64Array, radius: Float64Array, factor: float) -> float:
        pair, wall = Meetings.around(center, radius, factor, self._region.walls, 0.0).gaps(center, factor)
        return max(0.0, -float(min(pair.min(initial=0.0), wall.min(initial=0.0))))


def held_by(near: Meetings, count: int) -> tuple[BoolArray, int]:
    """Return which of some spheres contacts hold, shape (N,), and the number of contacts among these.

    A sphere with fewer than four contacts is not held, nor does it hold others.
    """
    held = np.ones(count, bool)
    while True:
        pairs, walls = held[near.first] & held[near.second], held[near.sphere]
        ends = np.concatenate([near.first[pairs], near.second[pairs], near.sphere[walls]])
        enough = held & (np.bincount(ends, minlength=count) >= HELD_MIN)
        if (enough == held).all():
            return held, int(pairs.sum() + walls.sum())
        held = enough
