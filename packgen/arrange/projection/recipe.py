"""The constants of the arrangement, and what each sweep of a layer takes of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from packgen.arrays import BoolArray, Float64Array
from packgen.portable import log, power, scalar_power

SWEEPS_MAX = 320
"""Sweeps of one schedule: as many as most layers take."""

FRICTION_USUAL = 1.0 / 3.0
"""Friction from which on all spheres are arranged alike; smoother ones are arranged more densely."""

FRICTION_LEAST = 0.1
"""Smoother spheres are arranged as those of this friction: their sinking would take ever longer."""

TUBE_WIDTHS, TUBE_SHARES = (4.5, 6.5, 13.0, 30.0), (0.0, 1.0, 1.0, 0.0)
"""Widths of round vessels [sphere diameters], and how far each is arranged as a tube, see
``Recipe.of_friction``."""

TUBE_GRAIN, TUBE_MOMENTUM = 1.25, 0.9
"""Roughness of a tube's wall, in radii, and momentum in it, at usual friction."""

BREADTH_MAX = 2.0
"""Ratio of mean radii beyond which broader sizes get no more momentum, time or skin, but longer steps."""

FARTHER_MAX = 1.75
"""Longest steps, in usual ones: with longer steps small spheres would outrun their lists at once."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """The constants of the arrangement, all relative to radii, found by measurement (tests/benchmarks).

    The defaults are for usual friction; ``of_friction`` returns the recipe for smoother spheres.

    Attributes:
        gap: Spheres and walls are arranged larger by this fraction: once the overlaps are below it, the true
            spheres do not overlap at all.
        sink_sweeps: Sweeps until the layer has sunk.
        sink_first: First step down before a sweep, in radii; the steps shrink with the third power of the
            sweeps left.
        sink_last: What they shrink to, in radii: small enough that the weight of the layer leaves no overlap
            beyond the gap.
        sink_fade: Factor on the step with each sweep after that: without any weight a layer loses the
            contacts that it stands on while its last overlaps are parted.
        momentum: Share of a sphere's last displacement that is added again.
        momentum_sweeps: Sweeps over which it rises to that: deep overlaps at the start would throw spheres
            far.
        relaxation: Factor on the sum of a sphere's pushes.
        stride: Largest displacement of one sweep by pushes, in radii.
        grain: Depth of the walls' roughness at first, in radii: on smooth walls spheres would crystallise.
        grain_sweeps: Sweeps until they are smooth.
        skin_first: Reach of the neighbour list beyond touching, at the start.
        skin_last: The same at the end, when little moves.
        strays: The list is renewed when this share of the spheres has outrun it, at the start.
        strays_last: The same at the end: a sphere that falls past a neighbour unseen ends deep inside it.
        far: Margins by which a single sphere may move before the list is renewed: beyond, it may be inside
            another one unseen.
        far_sweeps: Sweeps before ``far`` counts: at first deep overlaps throw many spheres far.
        give_up_first: First sweep after which spheres that overlap too much are thrown back.
        give_up_every: Sweeps from one such time to the next.
        give_up: Overlap that is too much, one value for each time; thereafter any overlap is.
        part_first: First sweep of a layer without sinking.
        throw_share: Largest share of the layer's spheres that is thrown back at a time.
        tolerance: Largest overlap of the true spheres, as a fraction of the smaller radius; None: stop after
            the sinking, whatever overlaps.
        friction: Coefficient of friction between spheres while they are arranged: such beds are looser. 0:
            they slide freely, and how slowly they sink decides how dense the bed is.
        grip: Largest share of the sliding of a contact that friction takes in one sweep. Beyond 2/7 a single
            contact is turned back; spheres that many hold stick before they have found their rest.
    """

    gap: float = 2.0e-4
    sink_sweeps: int = 225
    sink_first: float = 0.021
    sink_last: float = 5.0e-5
    sink_fade: float = 0.95
    momentum: float = 0.85
    momentum_sweeps: int = 20
    relaxation: float = 1.0
    stride: float = 0.2
    grain: float = 3.25
    grain_sweeps: int = 75
    skin_first: float = 1.6
    skin_last: float = 0.7
    strays: float = 0.03
    strays_last: float = 0.001
    far: float = 2.0
    far_sweeps: int = 105
    give_up_first: int = 120
    give_up_every: int = 12
    give_up: tuple[float, ...] = (
        0.1, 0.075, 0.055, 0.04, 0.028, 0.019, 0.0125, 0.008, 0.0052, 0.0038, 0.0028, 0.0018, 0.001, 0.0004,
    )  # fmt: skip
    part_first: int = 105
    throw_share: float = 0.05
    tolerance: float | None = 1.0e-6
    friction: float = 0.0
    grip: float = 0.3

    @classmethod
    def of_friction(cls, friction: float, tolerance: float | None, tube_width: float | None = None) -> Recipe:
        """Return the recipe of a bed about as dense as gravity would make it of spheres of some friction.

        Twice as many sweeps for spheres that rub half as much: LIGGGHTS pours beds of core density 0.602,
        0.615 and 0.629 at friction 0.5, 0.2 and 0.1, with 1.9, 3.1 and 7 % of the spheres at its walls in
        crystals.

        Args:
            friction: Coefficient of sliding friction of sphere on sphere.
            tolerance: Largest overlap of the true spheres; see ``Recipe``.
            tube_width: Width of a round vessel, in sphere diameters; None: not round, or sizes are broad.
        """
        slower = FRICTION_USUAL / min(max(friction, FRICTION_LEAST), FRICTION_USUAL)
        return cls.slowed(slower, tolerance, tube_width)

    @classmethod
    def slowed(cls, slower: float, tolerance: float | None, tube_width: float | None = None) -> Recipe:
        """Return the recipe of a bed that sinks more slowly, and becomes denser.

        The slower a layer sinks, the more of it becomes crystal on walls as rough as before; a little rougher
        ones (by the fourth root) keep the porosity near walls within 0.05 of de Klerk's.

        The layers of a crystal are flat and fit a curved wall badly: less rough ones leave in a tube the
        waves of the porosity that experiments show. With the usual ones its minima are 0.05 too shallow, and
        its mean is 0.01 above that of Zou and Yu's loose packings. It costs some order: of the spheres at the
        wall 1 and 3 % are in crystals at 10 and 20 diameters, 0.2 and 1.6 % behind usual walls. Tubes of
        hardly more than two shells need rough walls, and so do vessels so wide that a sphere finds their
        walls flat. Smooth spheres sink slowly enough to find those waves by themselves. Measured by
        tests/benchmarks/porosity.py.

        Args:
            slower: Sweeps, in usual ones.
            tolerance: Largest overlap of the true spheres; see ``Recipe``.
            tube_width: Width of a round vessel, in sphere diameters; None: not round, or sizes are broad.
        """
        usual = cls(tolerance=tolerance)
        tube = _tube_share(tube_width, slower)
        smoother = float(power(np.array(TUBE_GRAIN / usual.grain), tube))
        return replace(
            usual,
            sink_sweeps=round(slower * usual.sink_sweeps),
            momentum=usual.momentum + tube * (TUBE_MOMENTUM - usual.momentum),
            grain=usual.grain * math.sqrt(math.sqrt(slower)) * smoother,
            grain_sweeps=round(slower * usual.grain_sweeps),
            far_sweeps=round(slower * usual.far_sweeps),
            give_up_first=round(slower * usual.give_up_first),
            give_up_every=round(slower * usual.give_up_every),
            part_first=round(slower * usual.part_first),
        )

    def of_sizes(self, breadth: float) -> Recipe:
        """Return the recipe for a layer of broad sizes.

        Steps down go with the mean radius, but the layer is as thick as its large spheres: these have to sink
        by their own radii, and on small ones they come to rest slowly. More momentum does both, and beyond
        that longer steps. The overlaps take longer to part, too: at the usual sweep one sphere in seven would
        be thrown back, and would leave a hole. What falls farther outruns its list sooner: the skin grows.

        Args:
            breadth: Mean radius by volume over that by number; 1 for equal spheres.
        """
        if breadth < 1.0 + 1e-9:
            return self
        farther = min(max(breadth / BREADTH_MAX, 1.0), FARTHER_MAX)
        breadth = min(breadth, BREADTH_MAX)
        return replace(
            self,
            sink_first=farther * self.sink_first,
            sink_last=farther * self.sink_last,
            momentum=1.0 - (1.0 - self.momentum) / breadth,
            skin_first=0.5 * (1.0 + breadth) * self.skin_first,
            give_up_first=round(0.5 * (1.0 + breadth) * self.give_up_first),
        )

    def fall(self, number: int) -> float:
        """Return the step down before a sweep, in radii."""
        left = self.sink_sweeps - number
        if left <= 0:
            return self.sink_last * scalar_power(self.sink_fade, -left)
        return self.sink_last + self.sink_first * scalar_power(left / self.sink_sweeps, 3)

    def too_much(self, number: int) -> float | None:
        """Return the overlap above which a sweep throws spheres back; None: this sweep throws none back."""
        times, rest = divmod(number - self.give_up_first, self.give_up_every)
        if times < 0 or rest:
            return None
        return self.give_up[times] if times < len(self.give_up) else 0.0

    def step(self, number: int, *, rough: bool) -> Step:
        """Return how a sweep moves the spheres; ``rough``: whether the walls begin rough."""
        far = self.far if number >= self.far_sweeps else math.inf
        roughness = self.grain * max(0.0, 1.0 - number / self.grain_sweeps) if rough else 0.0
        momentum = self.momentum * min(1.0, number / self.momentum_sweeps)
        return Step(
            momentum, self.relaxation, self.stride, roughness, far, self.friction, self.grip
        )  # fmt: skip

    def schedule(self, number: int, *, sink: bool, most: int = SWEEPS_MAX) -> Schedule:
        """Return what the sweeps from one on take, as many as are at hand, up to where all of them end.

        Args:
            number: Number of the first sweep; below ``sink_sweeps`` where there is no tolerance.
            sink: Whether the layer sinks, and the walls begin rough.
            most: Sweeps at most, at least 1.
        """
        end = (number // SWEEPS_MAX + 1) * SWEEPS_MAX
        if self.tolerance is None:
            end = min(end, self.sink_sweeps)
        whole = _schedule(self, number - number % SWEEPS_MAX, end, sink)
        return whole.part(number - whole.first, most)

    def skin(self, number: int) -> float:
        """Return the skin of a neighbour list made before a sweep."""
        return self.skin_first + (self.skin_last - self.skin_first) * self._share(number)

    def strays_allowed(self, number: int) -> float:
        """Return the share of strays with which a neighbour list holds in a sweep."""
        return self.strays + (self.strays_last - self.strays) * self._share(number)

    def _share(self, number: int) -> float:
        return min(1.0, number / self.sink_sweeps)


@lru_cache(maxsize=256)
def _schedule(recipe: Recipe, first: int, end: int, sink: bool) -> Schedule:
    numbers = range(first, end)
    steps = [recipe.step(number, rough=sink) for number in numbers]
    limits = [None if recipe.tolerance is None else recipe.too_much(number + 1) for number in numbers]
    tolerance = recipe.tolerance or 0.0
    return Schedule(
        first,
        np.array([recipe.fall(number) if sink else 0.0 for number in numbers]),
        np.array([step.momentum for step in steps]),
        np.array([step.roughness for step in steps]),
        np.array([step.far for step in steps]),
        np.array([recipe.strays_allowed(number) for number in numbers]),
        np.array([recipe.skin(number) for number in numbers]),
        np.array([sink and number < recipe.sink_sweeps for number in numbers]),
        np.array([math.inf if limit is None else limit for limit in limits]),
        recipe.relaxation,
        recipe.stride,
        2.5 * (recipe.gap + tolerance),
        # Just below the tolerance: the independent check rounds differently.
        0.99 * tolerance,
        1.0 / (1.0 + recipe.gap),
        recipe.throw_share,
        recipe.friction,
        recipe.grip,
    )


def _tube_share(width: float | None, slower: float) -> float:
    """Return how much a vessel is arranged as a tube, 0 to 1; the less, the slower its spheres sink."""
    if width is None:
        return 0.0
    slowest = FRICTION_USUAL / FRICTION_LEAST
    share = float(np.interp(log(np.array(width)), log(np.array(TUBE_WIDTHS)), TUBE_SHARES))
    return share * min(max((slowest - slower) / (slowest - 1.0), 0.0), 1.0)


class Step(NamedTuple):
    """How a sweep moves the spheres; see ``Recipe``.

    Attributes:
        momentum: Share of a sphere's last displacement that is added again.
        relaxation: Factor on the sum of a sphere's pushes.
        stride: Largest displacement by pushes, in radii.
        roughness: Depth of the walls' roughness, in radii: each sphere is kept off the walls by a part of it.
        far: Margins after which a single sphere, which may be inside another one unseen, makes the neighbour
            list void.
        friction: Coefficient of friction between spheres.
        grip: Largest share of the sliding of a contact that friction takes.
    """

    momentum: float
    relaxation: float
    stride: float
    roughness: float = 0.0
    far: float = math.inf
    friction: float = 0.0
    grip: float = 0.0


class Schedule(NamedTuple):
    """What a run of S sweeps takes; see ``Step`` and ``Recipe``.

    Attributes:
        first: Number of the first sweep.
        fall: Step down before each sweep, in mean radii, shape (S,).
        momentum: Momentum of each sweep, shape (S,).
        roughness: Depth of the walls' roughness, in radii, shape (S,).
        far: Margins after which a single sphere makes the neighbour list void, shape (S,).
        strays: Share of spheres that may have outrun the list before each sweep, shape (S,).
        skin: Skin of a neighbour list made before each sweep, shape (S,).
        sinking: Whether the layer still sinks, shape (S,), bool.
        limit: Overlap above which each sweep throws spheres back, shape (S,); infinite where none are.
        relaxation: Factor on the sum of a sphere's pushes.
        stride: Largest displacement by pushes, in radii.
        calm: Largest overlap at which a layer that no longer sinks is looked at.
        least: Largest overlap of the true spheres of a layer that is arranged.
        scale: True radius over arranged radius.
        throw_share: Largest share of the layer's spheres that is thrown back at a time.
        friction: Coefficient of friction between spheres.
        grip: Largest share of the sliding of a contact that friction takes.
    """

    first: int
    fall: Float64Array
    momentum: Float64Array
    roughness: Float64Array
    far: Float64Array
    strays: Float64Array
    skin: Float64Array
    sinking: BoolArray
    limit: Float64Array
    relaxation: float
    stride: float
    calm: float
    least: float
    scale: float
    throw_share: float
    friction: float
    grip: float

    def part(self, start: int, most: int) -> Schedule:
        """Return the schedule without its first ``start`` sweeps, of at most so many."""
        chosen = slice(start, start + most)
        return self._replace(
            first=self.first + start,
            fall=self.fall[chosen],
            momentum=self.momentum[chosen],
            roughness=self.roughness[chosen],
            far=self.far[chosen],
            strays=self.strays[chosen],
            skin=self.skin[chosen],
            sinking=self.sinking[chosen],
            limit=self.limit[chosen],
        )


class Tally(NamedTuple):
    """What a run of sweeps did.

    Attributes:
        sweeps: Sweeps done.
        rebuilds: How often the lists were made anew.
        thrown_back: Spheres taken out.
        strays: Spheres that outran the lists in the last sweep; see ``sweep``.
        done: Whether the layer is arranged.
    """

    sweeps: int
    rebuilds: int
    thrown_back: int
    strays: int
    done: bool
