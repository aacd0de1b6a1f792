"""Linear programmes take the overlaps out of a bed on the verge of being jammed, and prove that it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from packgen.arrange.jammed.exact import exact_contacts
from packgen.arrange.jammed.meetings import Meetings
from packgen.arrange.jammed.wholes import whole_moves
from packgen.arrange.space.walls import WallTable
from packgen.arrays import BoolArray, Float64Array, Int64Array, add_at
from packgen.geometry import Container
from packgen.programmes.steps import Pins, Step, largest_step

REACH_FIRST = 2.0e-3
"""Largest move along an axis of the first step, in mean radii."""

REACH_MAX, REACH_LAST = 0.1, 1.0e-7
"""Largest and least reach of a step, in mean radii."""

LONGER, SHORTER = 3.0, 0.3
"""The next reach in that of the step before, where this kept spheres from going on, and where not."""

WIDER = 3.0
"""The next reach at most, in the moves of spheres that were held."""

BACK = 0.1
"""The next reach in that of a step that gained nothing: curved walls come nearer than their planes."""

NEAR = 1.0e-6
"""Distance beyond the reach of a step up to which rows are listed, in mean radii."""

ROUNDS = 12
"""Programmes at most."""

DONE = 1.0e-12
"""Gain of all radii that is none."""

BALANCED = 1.0e-9
"""Largest sum of forces upon a sphere, in mean forces, of one that is not kept by the reach of its step."""

TOUCHING = 1.0e-9
"""Largest gap of a contact, as a fraction of the smaller radius."""

ROUNDING = 1.0e-12
"""Share of the radii that is rounding."""

HARD = 0.02
"""Distance of surfaces up to which overlaps and contacts are sought, in mean radii."""

BEARING = 1.0e-9
"""Least force of a row that bears one, in mean forces."""


@dataclass(frozen=True, eq=False, slots=True)
class Bones:
    """What holds a bed.

    Attributes:
        contacts: Pairs and walls that bear a force.
        pair_force: Their forces, shape (P,); one unit for all.
        wall_force: Those of the walls, shape (W,).
    """

    contacts: Meetings
    pair_force: Float64Array
    wall_force: Float64Array

    @classmethod
    def of(cls, near: Meetings, step: Step) -> Bones:
        """Return what bears a force in a step."""
        least = BEARING * float(np.concatenate([step.pair_force, step.wall_force]).mean())
        pairs, walls = step.pair_force > least, step.wall_force > least
        return cls(near.chosen(pairs, walls), step.pair_force[pairs], step.wall_force[walls])

    @property
    def spheres(self) -> Int64Array:
        """The spheres that are held, rising, shape (n,)."""
        contacts = self.contacts
        return np.unique(np.concatenate([contacts.first, contacts.second, contacts.sphere]))

    @property
    def press(self) -> bool:
        """Whether all forces press."""
        return bool((self.pair_force > 0.0).all() and (self.wall_force > 0.0).all())

    def residual(self, center: Float64Array) -> float:
        """Return the largest sum of the forces upon a sphere, over the mean force."""
        contacts = self.contacts
        separation = contacts.separations(center)
        unit = separation / np.sqrt((separation * separation).sum(axis=1))[:, None]
        by_pairs = unit * self.pair_force[:, None]
        total = np.zeros((len(center), 3))
        by_walls = contacts.distances(center)[1] * self.wall_force[:, None]
        for axis in range(3):
            add_at(total[:, axis], contacts.first, by_pairs[:, axis])
            add_at(total[:, axis], contacts.second, -by_pairs[:, axis])
            add_at(total[:, axis], contacts.sphere, by_walls[:, axis])
        mean = float(np.concatenate([self.pair_force, self.wall_force]).mean())
        return float(np.sqrt((total * total).sum(axis=1)).max()) / mean


@dataclass(frozen=True, eq=False, slots=True)
class Polished:
    """A bed after its last step.

    Attributes:
        center: Centres [m], shape (N, 3).
        factor: Common factor of the radii; nothing overlaps.
        held: Which spheres are held, shape (N,).
        contacts: Contacts of these.
        excess: Contacts beyond the least number that can hold them.
        residual: Largest sum of the forces upon a sphere, over the mean force.
        gap: Largest gap of a contact that bears a force, as a fraction of the smaller radius.
        proven: Whether all forces press and balance, so that nothing can grow by small moves.
        programmes: Programmes solved.
    """

    center: Float64Array
    factor: float
    held: BoolArray
    contacts: int
    excess: int
    residual: float
    gap: float
    proven: bool
    programmes: int


@dataclass(frozen=True, eq=False, slots=True)
class _Near:
    """Spheres whose contacts are exact, near those of a step.

    Attributes:
        bones: What bears forces.
        center: Centres [m], shape (N, 3).
        factor: Common factor of the radii at which the contacts touch.
        largest: The largest one at which no spheres overlap, those without contacts included.
        proven: Whether all forces press and balance, and nothing overlaps.
    """

    bones: Bones
    center: Float64Array
    factor: float
    largest: float
    proven: bool


@dataclass(frozen=True, eq=False, slots=True)
class Polisher:
    """Polishes the beds of one zone.

    Attributes:
        container: The container.
        walls: Its walls, and those of the zone.
        located: Whether the zone has walls of its own.
    """

    container: Container
    walls: WallTable
    located: bool

    def polished(
        self, center: Float64Array, radius: Float64Array, factor: float, tell: Callable[[int], None]
    ) -> Polished:
        """Return a bed with the largest radii that small moves lead to.

        Args:
            center: Centres [m], shape (N, 3).
            radius: Radii as given [m], shape (N,).
            factor: Common factor of them, nearly as large as can be.
            tell: Called before each programme with its number.

        Raises:
            NoSolutionError: A programme was not solved.
        """
        unit = factor * float(radius.mean())
        reach = REACH_FIRST * unit
        factor = self._largest(center, radius, factor)
        for number in range(ROUNDS):
            tell(number)
            within = 2.0 * float(np.sqrt(3.0)) * reach + NEAR * unit
            near = Meetings.around(center, radius, factor, self.walls, within).one_a_wall(center)
            step = self._step(near, center, factor, reach)
            bones = Bones.of(near, step)
            moved, grown = center + step.move, factor * float(np.sqrt(1.0 + step.gain))
            exact = self._exact(bones, moved, grown)
            if exact is not None and exact.proven:
                return self._result(exact.bones, exact.center, exact.factor, number + 1, proven=True)
            balanced = bones.residual(center) <= BALANCED
            if step.gain <= DONE and balanced:
                return self._result(bones, center, factor, number + 1, proven=True)
            grown = self._largest(moved, radius, grown)
            if exact is not None and exact.largest > grown:
                moved, grown = exact.center, exact.largest
            if grown > factor:
                center, factor = moved, grown
                way = WIDER * float(np.abs(step.move[bones.spheres]).max())
                if balanced:
                    # One more programme tells whether there is anything left to gain.
                    reach = max(min(SHORTER * reach, way), REACH_LAST * unit)
                else:
                    reach = min(LONGER * reach, REACH_MAX * unit)
            else:
                reach *= BACK
            if reach < REACH_LAST * unit:
                break
        return self._result(bones, center, factor, number + 1, proven=False)

    def _largest(self, center: Float64Array, radius: Float64Array, factor: float) -> float:
        """Return the largest common factor of the radii, near one, at which nothing overlaps."""
        near = Meetings.around(center, radius, factor, self.walls, HARD * factor * float(radius.mean()))
        return near.largest_factor(center)

    def _exact(self, bones: Bones, center: Float64Array, factor: float) -> _Near | None:
        """Return spheres near by whose contacts are exact; None: there are none."""
        spheres, radius = bones.spheres, bones.contacts.radius
        exact = exact_contacts(bones.contacts, center, factor, self._pins(center, spheres), spheres)
        if exact is None:
            return None
        solved = Bones(bones.contacts, exact.pair_force, exact.wall_force)
        largest = self._largest(exact.center, radius, exact.factor)
        proven = solved.press and solved.residual(exact.center) <= BALANCED
        proven &= largest >= exact.factor * (1.0 - ROUNDING)
        return _Near(solved, exact.center, exact.factor, largest, proven)

    def _step(self, near: Meetings, center: Float64Array, factor: float, reach: float) -> Step:
        pairs, walls = near.rows(center, factor)
        pins = self._pins(center, np.arange(len(center)))
        return largest_step(len(center), pairs, walls, pins, reach)

    def _pins(self, center: Float64Array, members: Int64Array) -> Pins:
        return whole_moves(self.container, center, members, located=self.located)

    def _result(
        self, bones: Bones, center: Float64Array, factor: float, programmes: int, *, proven: bool
    ) -> Polished:
        radius, spheres = bones.contacts.radius, bones.spheres
        gap = max(float(np.abs(each).max(initial=0.0)) for each in bones.contacts.gaps(center, factor))
        near = Meetings.around(center, radius, factor, self.walls, HARD * factor * float(radius.mean()))
        near = near.one_a_wall(center)
        held = np.zeros(len(radius), bool)
        held[spheres] = True
        pair, wall = near.gaps(center, factor)
        contacts = int(((pair <= TOUCHING) & held[near.first] & held[near.second]).sum())
        contacts += int(((wall <= TOUCHING) & held[near.sphere]).sum())
        return Polished(
            center, min(factor, near.largest_factor(center)), held, contacts,
            contacts - (3 * len(spheres) - len(self._pins(center, spheres).sphere) + 1),
            bones.residual(center), gap, proven, programmes,
        )  # fmt: skip
