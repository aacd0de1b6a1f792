"""Forces by which contacts carry weights: a convex programme over Coulomb cones.

Each sphere is rigid. A contact pushes and never pulls, and its force lies in the friction cone about the
normal. Among all such forces those are sought that leave the least of Gauss' constraint, half the sum of
m |a|^2 + I |alpha|^2, where a and alpha are the accelerations with which the spheres would start to move.
Nothing is left where the contacts can carry all weights. What is left is unique, although forces are not.

The cones are the exact round ones. Accelerated projected gradients (Nesterov, with the restarts of O'Donoghue
and Candes, Found. Comput. Math. 15 (2015) 715; for contacts Mazhar et al., ACM Trans. Graph. 34 (2015) 32)
need some hundred passes over the contacts. The tests ask the same by linear programming.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import Float64Array, Int64Array

if TYPE_CHECKING:
    from numpy.typing import NDArray

FIXED = -1  # in place of a sphere's index: a wall, or a sphere that is held from elsewhere
STEPS_MAX = 4000
STALLED = 2.0e-3  # relative loss of what is left from one look to the next, below which no more is awaited
STALLED_ROUGH = 1.0e-2  # the same where frictions are tried: near the least one little is lost for long
FEW = 1000  # contacts
FRICTION_STEP = 0.005  # to which the least friction is found
FRICTION_MAX = 2.0  # no material has more


@dataclass(frozen=True, eq=False, slots=True)
class Structure:
    """Spheres, their weights, and the contacts that may carry them.

    Attributes:
        radius: Radii [m], shape (N,), float64.
        weight: What pulls at each sphere's centre [N], shape (N, 3), float64.
        mass: Masses [kg], shape (N,), float64; they weigh what is left of the sphere's balance.
        first: One sphere of each contact, shape (C,), int64.
        second: The other one, or `FIXED`, shape (C,), int64.
        normal: Unit vectors from the first sphere's centre towards the contact, shape (C, 3), float64.
        friction: Coefficient of friction of each contact, shape (C,), float64.
    """

    radius: Float64Array
    weight: Float64Array
    mass: Float64Array
    first: Int64Array
    second: Int64Array
    normal: Float64Array
    friction: Float64Array

    @property
    def count(self) -> int:
        """Number of spheres."""
        return len(self.radius)

    @property
    def weight_sum(self) -> float:
        """Sum of the weights' amounts [N]."""
        return float(np.linalg.norm(self.weight, axis=1).sum())


@dataclass(frozen=True, eq=False, slots=True)
class Balance:
    """Contact forces, and what they leave of the spheres' balance.

    Attributes:
        force: Force of each contact on its second sphere [N], the opposite of that on the first, (C, 3).
        left: Force on each sphere that nothing balances [N], shape (N, 3).
        torque_left: Torque on each sphere that nothing balances, divided by its radius [N], shape (N, 3).
        share: Sum of the forces left, as a share of the sum of all weights: the spheres' mean acceleration
            when they are let go, by mass, in units of gravity.
        steps: Steps that were taken.
    """

    force: Float64Array
    left: Float64Array
    torque_left: Float64Array
    share: float
    steps: int

    def falling(self, structure: Structure) -> NDArray[np.bool_]:
        """Return the spheres that more than half of their weight is left of, shape (N,), bool."""
        weight = np.linalg.norm(structure.weight, axis=1)
        return np.asarray(np.linalg.norm(self.left, axis=1) > 0.5 * weight)


def balance(
    structure: Structure,
    friction: float | None = None,
    *,
    enough: float = 1.0e-5,
    stalled: float = STALLED,
    start: Float64Array | None = None,
) -> Balance:
    """Return forces that leave as little as may be of the spheres' weights.

    Args:
        structure: Spheres and contacts.
        friction: Coefficient of friction of all contacts; None: each contact's own.
        enough: Share of the weights that may be left: the search ends there.
        stalled: Relative loss from one look at what is left to the next, below which it ends as well.
        start: Forces to start from [N], shape (C, 3); None: none.

    Returns:
        The forces; they obey the cones exactly, so that `share` is never too small.
    """
    search = _Search(structure, friction, start)
    before, share = np.inf, search.share
    while search.steps < STEPS_MAX and share > enough:
        share, cost = search.go_on()
        if abs(before - cost) <= stalled * cost:
            break
        before = cost
    return search.balance()


class _Search:
    """Accelerated projected gradients, in units of a mean weight and a mean mass."""

    def __init__(self, structure: Structure, friction: float | None, start: Float64Array | None) -> None:
        from packgen.programmes import force_kernels as kernels

        self._kernels = kernels
        contacts = len(structure.first)
        self._unit = structure.weight_sum / max(structure.count, 1) or 1.0
        self._weight = structure.weight / self._unit
        self._lightness = float(structure.mass.mean()) / structure.mass if contacts else structure.mass
        self._graph = structure.first, structure.second, np.ascontiguousarray(structure.normal)
        self._friction = structure.friction if friction is None else np.full(contacts, friction)
        self._force = np.zeros((contacts, 3)) if start is None else start / self._unit
        self._ahead, self._pace = self._force.copy(), 1.0
        self._left, self._torque = self._weight, np.zeros_like(self._weight)
        self.steps, self.share = 0, 1.0 if contacts and structure.weight_sum else 0.0
        if not contacts:
            self.share = float(np.linalg.norm(self._weight, axis=1).mean()) if structure.count else 0.0
            self.steps = STEPS_MAX
            return
        # Light spheres make stiff contacts: each contact has a step of its own.
        both = np.where(structure.second == FIXED, 0.0, self._lightness[structure.second])
        ease = 1.0 / (self._lightness[structure.first] + both)
        self._step = ease / kernels.curvature(*self._graph, ease, self._lightness)

    def go_on(self) -> tuple[float, float]:
        """Take some steps; return the share of the weights that is left, and Gauss' constraint."""
        self._pace = self._kernels.descend(
            *self._graph, self._friction, self._lightness, self._weight, self._step,
            self._force, self._ahead, self._pace,
        )  # fmt: skip
        self.steps += self._kernels.PASSES
        self._left, self._torque = self._kernels.what_is_left(*self._graph, self._weight, self._force)
        self.share = float(np.linalg.norm(self._left, axis=1).mean())
        squares = (self._left**2).sum(axis=1) + self._kernels.SPIN * (self._torque**2).sum(axis=1)
        return self.share, float((squares * self._lightness).sum())

    def balance(self) -> Balance:
        """Return what was found, in SI units."""
        unit = self._unit
        return Balance(self._force * unit, self._left * unit, self._torque * unit, self.share, self.steps)


def least_friction(structure: Structure, share: float, known: Balance | None = None) -> float | None:
    """Return the least friction, the same at all contacts, at which they carry all but a share of the weight.

    Args:
        structure: Spheres and contacts.
        share: Share of the weights that may be left.
        known: Result of `balance` at the contacts' own frictions, which spares work.

    Returns:
        Coefficient of friction, found to `FRICTION_STEP` or a twentieth, and some hundredths more where
        little changes with it: the search ends early. None where `FRICTION_MAX` is not enough.
    """
    high, force = FRICTION_MAX, None if known is None else known.force
    if known is not None and known.share <= share:
        high = float(structure.friction.max(initial=0.0))
    else:
        found = balance(structure, high, enough=share, start=force)
        if found.share > share:
            return None
        force = found.force
    # Few contacts cost little to be exact about.
    stalled = STALLED if len(structure.first) < FEW else STALLED_ROUGH
    low = 0.0
    while high - low > max(FRICTION_STEP, 0.05 * high):
        # Materials' frictions are small numbers: the search goes down by halves first.
        middle = 0.5 * (low + high)
        tried = balance(structure, middle, enough=share, stalled=stalled, start=force)
        if tried.share <= share:
            high, force = middle, tried.force
        else:
            low = middle
    if low == 0.0 and balance(structure, 0.0, enough=share, start=force).share <= share:
        return 0.0
    return high
