"""The paper's objective, eq. 5, and its gradient: overlap, height, and distance outside the walls.

Source: "Rapid Random Packing of Poly-disperse Spheres using Adam Stochastic Optimization", eqs. 1 to 5.
For a batch of centres C with radii r on top of fixed spheres C', r':

    Z(C) = alpha P(C, C) + beta A(C) + gamma E(C) + alpha P(C, C')

P is the sum of penetration depths (eq. 1), A the sum of altitudes (eq. 3, along any direction), E the sum of
the distances by which spheres stick out through walls (eq. 2). **As printed, eq. 1 sums over all ordered
pairs**: two spheres of the batch count twice, once as (i, j) and once as (j, i), while a sphere of the batch
and a fixed one count once. That is kept: contacts within a batch are twice as stiff as those with fixed ones.

`objective` takes a list of the pairs that may overlap and is linear in the spheres; `all_pairs_objective` is
the formula as printed, differentiated by torch, of cost batch x (batch + fixed). As long as the list holds
every overlapping pair both are equal to rounding. Where Z has a kink (spheres or walls that just touch,
centres that coincide) both take the same subgradient: a term of no depth, or no direction, pulls nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from packgen.arrange.neighbors.torch_pairs import neighbor_pairs, neighbor_pairs_between


class Walls(Protocol):
    """What the optimiser needs to know of the walls."""

    def exterior(self, position: Tensor, radius: Tensor) -> Tensor:
        """Return how far spheres stick out through each wall (eq. 2's rho tilde).

        Args:
            position: Sphere centres [m], shape (n, 3), float64.
            radius: Sphere radii [m], shape (n,), float64.

        Returns:
            Signed distance of the centre to each wall plus the radius [m], positive outside, shape (n, m).
        """
        ...


@dataclass(frozen=True, eq=False, slots=True)
class PlaneWalls:
    """A convex container bounded by planes: ``normal @ x <= offset`` for every plane.

    Attributes:
        normal: Outward unit normals, shape (m, 3), float64.
        offset: Distances of the planes from the origin along their normals [m], shape (m,), float64.
    """

    normal: Tensor
    offset: Tensor

    def exterior(self, position: Tensor, radius: Tensor) -> Tensor:
        """Return signed distance to each plane plus radius [m], shape (n, m); see `Walls`."""
        return torch.addmm(radius[:, None] - self.offset, position, self.normal.T)

    def exterior_gradient(self, position: Tensor, weight: Tensor) -> Tensor:  # noqa: ARG002
        """Return the gradient of ``sum(weight * exterior)`` by the centres, shape (n, 3).

        Args:
            position: Sphere centres [m], shape (n, 3), float64.
            weight: Weight of each sphere and wall, shape (n, m), float64.
        """
        return weight @ self.normal


@dataclass(frozen=True, slots=True)
class Weights:
    """The weights of eq. 5: alpha for overlap, beta for height, gamma for walls; the paper's values."""

    alpha: float = 100.0
    beta: float = 10.0
    gamma: float = 100.0


@dataclass(frozen=True, eq=False, slots=True)
class Objective:
    """Value of eq. 5 [m], a tensor of shape (), and its gradient by the batch's centres, shape (n, 3)."""

    value: Tensor
    gradient: Tensor


@dataclass(frozen=True, eq=False, slots=True)
class PairList:
    """The pairs of a batch of n spheres that may overlap, each once.

    Attributes:
        first: Index into the batch, shape (P,), int64.
        second: Index into the batch, or n plus an index into the fixed spheres, shape (P,), int64.
        touch: Sum of the two radii: the distance at which they touch [m], shape (P,), float64.
        count: How often eq. 5 counts the pair, shape (P,), float64: 2 within the batch, 1 with a fixed one.
    """

    first: Tensor
    second: Tensor
    touch: Tensor
    count: Tensor


def list_pairs(
    position: Tensor, radius: Tensor, fixed_position: Tensor, fixed_radius: Tensor, skin: float
) -> PairList:
    """Return every pair whose surfaces are closer than ``skin``: all that can overlap before moving skin / 2.

    Args:
        position: Centres of the batch [m], shape (n, 3), float64.
        radius: Their radii [m], shape (n,), float64.
        fixed_position: Centres of the fixed spheres [m], shape (f, 3), float64.
        fixed_radius: Their radii [m], shape (f,), float64.
        skin: Largest gap of a listed pair [m].
    """
    reach, fixed_reach = radius + 0.5 * skin, fixed_radius + 0.5 * skin
    within = neighbor_pairs(position, reach)
    against = neighbor_pairs_between(position, reach, fixed_position, fixed_reach)
    first = torch.cat((within[:, 0], against[:, 0]))
    second = torch.cat((within[:, 1], against[:, 1] + len(position)))
    touch = radius[first] + torch.cat((radius, fixed_radius))[second]
    count = torch.ones_like(touch)
    count[: len(within)] = 2.0
    return PairList(first, second, touch, count)


def pair_gaps(position: Tensor, fixed_position: Tensor, pairs: PairList) -> tuple[Tensor, Tensor, Tensor]:
    """Return the pairs' difference (P, 3), distance (P,) and gap (P,) [m]; the gap is eq. 1's delta."""
    everyone = torch.cat((position, fixed_position))
    difference = everyone.index_select(0, pairs.first) - everyone.index_select(0, pairs.second)
    distance = torch.linalg.vector_norm(difference, dim=1)
    return difference, distance, distance - pairs.touch


def objective(
    position: Tensor,
    radius: Tensor,
    fixed_position: Tensor,
    pairs: PairList,
    walls: Walls,
    down: Tensor,
    weights: Weights,
) -> Objective:
    """Return eq. 5 and its gradient from a list of pairs.

    Args:
        position: Centres of the batch [m], shape (n, 3), float64.
        radius: Their radii [m], shape (n,), float64.
        fixed_position: Centres of the fixed spheres [m], shape (f, 3), float64.
        pairs: All pairs that overlap, and any others.
        walls: The container's walls. If they have a method ``exterior_gradient(position, weight)`` it gives
            the gradient (see `PlaneWalls`), else torch differentiates ``exterior``.
        down: Unit vector that points where things fall, shape (3,), float64.
        weights: The weights of the terms.
    """
    difference, distance, gap = pair_gaps(position, fixed_position, pairs)
    depth = -gap.clamp(max=0.0)
    # d depth / d x_i = -(x_i - x_j) / distance where they overlap, and the opposite for x_j
    overlaps = (gap < 0.0) & (distance > 0.0)
    pull = torch.where(overlaps, weights.alpha * pairs.count / distance, 0.0)[:, None] * difference
    gradient = torch.zeros(
        (len(position) + len(fixed_position), 3), dtype=position.dtype, device=position.device
    )
    gradient.index_add_(0, pairs.second, pull)
    gradient.index_add_(0, pairs.first, pull.neg_())
    exterior, exterior_gradient = _exterior(position, radius, walls)
    # Sums of products, not products of matrices: those differ by machine.
    overlap = (depth * pairs.count).sum()
    value = weights.alpha * overlap - weights.beta * (position * down).sum() + weights.gamma * exterior
    total = gradient[: len(position)].add_(exterior_gradient, alpha=weights.gamma).sub_(weights.beta * down)
    return Objective(value, total)


def all_pairs_objective(
    position: Tensor,
    radius: Tensor,
    fixed_position: Tensor,
    fixed_radius: Tensor,
    walls: Walls,
    down: Tensor,
    weights: Weights,
) -> Objective:
    """Return eq. 5 as printed, over all ordered pairs, and its gradient by torch: the oracle of `objective`.

    Args:
        position: Centres of the batch [m], shape (n, 3), float64.
        radius: Their radii [m], shape (n,), float64.
        fixed_position: Centres of the fixed spheres [m], shape (f, 3), float64.
        fixed_radius: Their radii [m], shape (f,), float64.
        walls: The container's walls.
        down: Unit vector that points where things fall, shape (3,), float64.
        weights: The weights of the terms.
    """
    centers = position.detach().clone().requires_grad_(True)
    with torch.enable_grad():
        itself = torch.eye(len(centers), dtype=torch.bool, device=centers.device)
        within = _penetration(centers, radius, centers, radius).masked_fill(itself, 0.0).sum()  # eq. 1
        against = _penetration(centers, radius, fixed_position, fixed_radius).sum()  # eq. 1
        exterior = torch.relu(walls.exterior(centers, radius)).sum()  # eq. 2
        altitude = -(centers @ down).sum()  # eq. 3
        value = (
            weights.alpha * within
            + weights.beta * altitude
            + weights.gamma * exterior
            + weights.alpha * against
        )  # eq. 5
        (gradient,) = torch.autograd.grad(value, centers)
    return Objective(value.detach(), gradient)


def _penetration(position: Tensor, radius: Tensor, other_position: Tensor, other_radius: Tensor) -> Tensor:
    """Return eq. 1's p_ij, penetration depths of all pairs [m], shape (n, m)."""
    difference = position[:, None, :] - other_position[None, :, :]
    distance = torch.linalg.vector_norm(difference, dim=2)
    return torch.relu(radius[:, None] + other_radius[None, :] - distance)


def _exterior(position: Tensor, radius: Tensor, walls: Walls) -> tuple[Tensor, Tensor]:
    """Return eq. 2, shape (), and its gradient by the centres, shape (n, 3)."""
    by_hand = getattr(walls, "exterior_gradient", None)
    if by_hand is not None:
        exterior = walls.exterior(position, radius)
        return exterior.clamp(min=0.0).sum(), by_hand(position, (exterior > 0.0).to(position.dtype))
    with torch.enable_grad():
        centers = position.detach().clone().requires_grad_(True)
        total = torch.relu(walls.exterior(centers, radius)).sum()
        (gradient,) = torch.autograd.grad(total, centers)
    return total.detach(), gradient
