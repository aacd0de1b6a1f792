"""The paper's Algorithm 1, inner loop: one batch of spheres arranged by Adam on top of fixed ones.

Source: "Rapid Random Packing of Poly-disperse Spheres using Adam Stochastic Optimization", Algorithm 1 and
sections III-C, IV, V-A. What is printed is kept, with these readings and additions:

- Line 11 as printed keeps the *largest* objective as the best; the text minimises, and so does this module.
- The paper names torch's ReduceLROnPlateau without its settings, so torch's own defaults are taken: factor
  0.1, patience 10. Only the threshold differs: torch's is relative to the objective, so to where the origin
  lies; ours is a mean sinking in radii.
- A batch is "successfully packed" when the average overlap "between spheres or with the convex hull" stays
  below "a given threshold", not printed; the paper reports that "the average overlap measured at the contact
  points was always below 1.1 % of the particle radius", "due to line 19". So both averages, over the contacts
  between spheres and over those with walls, have to stay within 1.1 % of the (smaller) radius. A contact is a
  gap of at most 1 % of the radius: a pair that just touches, or has a hair of a gap, is one with overlap 0.
- A batch also ends when its learning rate has fallen to a small fraction of the first: it stands still then,
  while ever smaller improvements would go on to the last step.
- The sums over all pairs run over lists of near pairs. A list holds every pair with a gap below the skin and
  is renewed before anything has moved by half of it, so that objective and gradient are those of eq. 5 at
  every step. ``all_pairs=True`` evaluates eq. 5 as printed: the paper's algorithm, for comparisons.

Adam's steps have the size of the learning rate whatever the objective's scale: only the rate's ratio to the
radii matters, and 0.01 suits the paper's radius of 0.1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import torch
from torch import Tensor

from packgen.arrange.adam.objective import (
    Objective,
    PairList,
    Walls,
    Weights,
    all_pairs_objective,
    list_pairs,
    objective,
    pair_gaps,
)
from packgen.arrange.adam.update_rules import AmsGrad, Plateau

STEPS_PER_LIST = 10  # the skin lets Adam take about this many full steps before the list is renewed
SKIN_MIN = 0.02  # of the largest radius of the batch
SKIN_MAX = 1.0  # of the largest radius of the batch
CONTACT_GAP = 0.01  # largest gap of a contact, as a fraction of the (smaller) radius


@dataclass(frozen=True, slots=True)
class AdamSettings:
    """Settings of the paper's algorithm.

    Attributes:
        lr: Adam's first learning rate [m], about the length of its steps.
        n_epoch: Most steps for one batch (the paper's max_steps).
        patience: Steps without a new best objective after which the batch is done.
        weights: The weights of eq. 5.
        plateau_factor: Factor on the learning rate at a plateau.
        plateau_patience: Steps without an improvement that make a plateau; below ``patience``, to come first.
        plateau_threshold: Smallest improvement that counts, as the mean sinking of the batch that lowers the
            objective as much [mean radii].
        rate_end: Fraction of ``lr`` at which a batch is done.
        batch_size: Spheres in a batch, to begin with.
        overlap_limit: Largest average overlap of an accepted batch, as a fraction of the radius.
        start_fraction: Solid fraction of the random start positions.
    """

    lr: float = 0.01
    n_epoch: int = 2000
    patience: int = 50
    weights: Weights = field(default_factory=Weights)
    plateau_factor: float = 0.1
    plateau_patience: int = 10
    plateau_threshold: float = 1.0e-3
    rate_end: float = 1.0e-3
    batch_size: int = 500
    overlap_limit: float = 0.011
    start_fraction: float = 0.3


@dataclass(frozen=True, eq=False, slots=True)
class BatchResult:
    """A batch at the best objective found.

    Attributes:
        position: Centres [m], shape (n, 3), float64.
        objective: Value of eq. 5 there.
        steps: Steps of Adam taken.
        overlap_mean: Mean overlap of the contacts between spheres, in smaller radii; 0 without any.
        overlap_max: Largest such overlap.
        exterior_mean: Mean distance outside the walls of the contacts with walls, in radii; 0 without any.
        exterior_max: Largest such distance.
    """

    position: Tensor
    objective: float
    steps: int
    overlap_mean: float
    overlap_max: float
    exterior_mean: float
    exterior_max: float


def arrange_batch(
    start: Tensor,
    radius: Tensor,
    fixed_position: Tensor,
    fixed_radius: Tensor,
    walls: Walls,
    down: Tensor,
    settings: AdamSettings,
    on_step: Callable[[int, float, float], None] | None = None,
    *,
    all_pairs: bool = False,
) -> BatchResult:
    """Move a batch to where eq. 5 is least: Algorithm 1, lines 6 to 18.

    Args:
        start: First centres of the batch [m], shape (n, 3), float64; left as they are.
        radius: Their radii [m], shape (n,), float64.
        fixed_position: Centres of the fixed spheres [m], shape (f, 3), float64.
        fixed_radius: Their radii [m], shape (f,), float64.
        walls: The container's walls.
        down: Unit vector that points where things fall, shape (3,), float64.
        settings: Settings of the algorithm.
        on_step: Called after each step with its number, the objective and the learning rate.
        all_pairs: Evaluate eq. 5 over all pairs as printed, which gives the same to rounding, in more time.
    """
    position = start.clone()
    near = NearPairs(radius, fixed_position, fixed_radius)

    def evaluate(rate: float) -> Objective:
        if all_pairs:
            return all_pairs_objective(
                position, radius, fixed_position, fixed_radius, walls, down, settings.weights
            )
        pairs = near.at(position, rate)
        return objective(position, radius, near.fixed_position, pairs, walls, down, settings.weights)

    descent = AmsGrad(position)
    plateau = Plateau(
        settings.lr,
        factor=settings.plateau_factor,
        patience=settings.plateau_patience,
        threshold=settings.plateau_threshold * settings.weights.beta * float(radius.sum()),
    )
    current = evaluate(plateau.rate)
    best, best_position, bad_steps, step = float(current.value), position.clone(), 0, 0
    rate_end = settings.rate_end * settings.lr
    while bad_steps < settings.patience and step < settings.n_epoch and plateau.rate > rate_end:
        descent.step(position, current.gradient, plateau.rate)
        current = evaluate(plateau.rate)
        value = float(current.value)
        bad_steps += 1
        if value < best:
            best, bad_steps = value, 0
            best_position.copy_(position)
        plateau.step(value)
        step += 1
        if on_step is not None:
            on_step(step, value, plateau.rate)
    overlaps = measure_batch(best_position, radius, fixed_position, fixed_radius, walls)
    return BatchResult(best_position, best, step, *overlaps)


def batch_accepted(result: BatchResult, settings: AdamSettings) -> bool:
    """Return whether a batch is successfully packed (Algorithm 1, line 19): both averages within."""
    return max(result.overlap_mean, result.exterior_mean) <= settings.overlap_limit


def measure_batch(
    position: Tensor, radius: Tensor, fixed_position: Tensor, fixed_radius: Tensor, walls: Walls
) -> tuple[float, float, float, float]:
    """Return mean and largest overlap of pairs, and mean and largest distance outside walls, in radii."""
    pairs = list_pairs(position, radius, fixed_position, fixed_radius, CONTACT_GAP * float(radius.max()))
    _, _, gap = pair_gaps(position, fixed_position, pairs)
    smaller = torch.minimum(radius[pairs.first], torch.cat((radius, fixed_radius))[pairs.second])
    exterior = walls.exterior(position, radius) / radius[:, None]
    return (*_mean_and_max(-gap / smaller), *_mean_and_max(exterior.flatten()))


class NearPairs:
    """The pairs of a moving batch that may overlap, listed anew only when a sphere has moved far enough.

    Two lists are nested: the fixed spheres near the batch's bounding box, and the pairs with a gap below the
    skin. Both always hold all that can overlap.

    Args:
        radius: Radii of the batch [m], shape (n,), float64.
        fixed_position: Centres of all fixed spheres [m], shape (f, 3), float64.
        fixed_radius: Their radii [m], shape (f,), float64.

    Attributes:
        fixed_position: Centres of the fixed spheres that the last list refers to [m], shape (g, 3), float64.
    """

    def __init__(self, radius: Tensor, fixed_position: Tensor, fixed_radius: Tensor) -> None:
        self.fixed_position = fixed_position[:0]
        self._radius = radius
        self._radius_max = float(radius.max()) if len(radius) else 0.0
        self._all_fixed = fixed_position, fixed_radius
        self._fixed_radius = fixed_radius[:0]
        self._pairs: PairList | None = None
        self._skin = 0.0
        self._listed_at = fixed_position[:0]
        self._low = self._high = torch.full((3,), math.nan, dtype=radius.dtype, device=radius.device)

    def at(self, position: Tensor, rate: float) -> PairList:
        """Return all pairs that overlap at ``position`` (n, 3), and more, for steps of length ``rate``."""
        if self._pairs is None or self._moved_too_far(position):
            skin = max(SKIN_MIN * self._radius_max, 2.0 * STEPS_PER_LIST * rate)
            self._skin = min(skin, SKIN_MAX * self._radius_max)
            self._choose_fixed(position)
            self._listed_at = position.clone()
            self._pairs = list_pairs(
                position, self._radius, self.fixed_position, self._fixed_radius, self._skin
            )
        return self._pairs

    def _moved_too_far(self, position: Tensor) -> bool:
        if not len(position):
            return False
        moved = torch.linalg.vector_norm(position - self._listed_at, dim=1).max()
        # two spheres may approach each other; a hair less than half, for rounding
        return float(moved) > 0.4999 * self._skin

    def _choose_fixed(self, position: Tensor) -> None:
        """Choose the fixed spheres near the batch, unless the last choice still holds all that count."""
        if not len(position) or not len(self._all_fixed[0]):
            return
        low, high = position.amin(dim=0), position.amax(dim=0)
        if bool((low >= self._low).all() and (high <= self._high).all()):
            return
        margin = 4.0 * self._radius_max
        self._low, self._high = low - margin, high + margin
        centers, radii = self._all_fixed
        reach = (radii + (1.0 + SKIN_MAX) * self._radius_max)[:, None]
        near = ((centers > self._low - reach) & (centers < self._high + reach)).all(dim=1)
        self.fixed_position, self._fixed_radius = centers[near], radii[near]


def _mean_and_max(depth: Tensor) -> tuple[float, float]:
    """Return mean and largest overlap of the contacts among depths (P,) in radii; 0 without any contact."""
    overlap = depth[depth >= -CONTACT_GAP].clamp(min=0.0)
    return (float(overlap.mean()), float(overlap.max())) if len(overlap) else (0.0, 0.0)
