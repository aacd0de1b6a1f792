"""The wall features in plain torch: the same closed forms as ``wall_gap``, for whole tensors."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from packgen.arrange.space.feature_kernels import BALL, CENTER_PLANE, CONE, PLANE, TRIANGLE
from packgen.arrange.space.walls import WallTable


def feature_gaps(kind: Tensor, row: Tensor, position: Tensor, radius: Tensor) -> tuple[Tensor, Tensor]:
    """Return how far each sphere is inside its feature, and the direction back inside.

    Args:
        kind: Kind of each sphere's feature, shape (k,), int.
        row: That feature, shape (k, FEATURE_WIDTH), float64.
        position: Sphere centres [m], shape (k, 3), float64.
        radius: Sphere radii [m], shape (k,), float64.

    Returns:
        (gaps [m], shape (k,), negative outside; unit vectors, shape (k, 3)).
    """
    gap = torch.empty_like(radius)
    push = torch.empty_like(position)
    for number, form in (
        (PLANE, _plane),
        (CENTER_PLANE, _plane),
        (CONE, _cone),
        (BALL, _ball),
        (TRIANGLE, _triangle),
    ):
        chosen = kind == number
        if bool(chosen.any()):
            size = torch.zeros_like(radius[chosen]) if number == CENTER_PLANE else radius[chosen]
            gap[chosen], push[chosen] = form(row[chosen], position[chosen], size)
    return gap, push


def _plane(row: Tensor, position: Tensor, radius: Tensor) -> tuple[Tensor, Tensor]:
    return row[:, 3] - (row[:, :3] * position).sum(dim=1) - radius, -row[:, :3]


def _cone(row: Tensor, position: Tensor, radius: Tensor) -> tuple[Tensor, Tensor]:
    axis, cosine, sine = row[:, 3:6], row[:, 7], row[:, 8]
    away = position - row[:, :3]
    along = (away * axis).sum(dim=1)
    across = away - along[:, None] * axis
    off = torch.linalg.vector_norm(across, dim=1)
    gap = (row[:, 6] - off) * cosine + along * sine - radius
    push = -across / off.clamp(min=1e-300)[:, None] * cosine[:, None] + axis * sine[:, None]
    return gap, push


def _ball(row: Tensor, position: Tensor, radius: Tensor) -> tuple[Tensor, Tensor]:
    away = position - row[:, :3]
    off = torch.linalg.vector_norm(away, dim=1)
    return row[:, 3] - off - radius, -away / off.clamp(min=1e-300)[:, None]


def _triangle(row: Tensor, position: Tensor, radius: Tensor) -> tuple[Tensor, Tensor]:
    away = position - closest_points(row, position)
    off = torch.linalg.vector_norm(away, dim=1)
    apart = off > 1e-12 * radius
    push = torch.where(apart[:, None], away / off.clamp(min=1e-300)[:, None], row[:, 9:12])
    return torch.where(apart, off - radius, -radius), push


def closest_points(row: Tensor, position: Tensor) -> Tensor:
    """Return the point of each triangle closest to each position [m], shape (k, 3).

    The Voronoi regions of a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
    """
    a, b, c = row[:, 0:3], row[:, 3:6], row[:, 6:9]
    ab, ac = b - a, c - a

    def dot(left: Tensor, right: Tensor) -> Tensor:
        return (left * right).sum(dim=1)

    d1, d2 = dot(ab, position - a), dot(ac, position - a)
    d3, d4 = dot(ab, position - b), dot(ac, position - b)
    d5, d6 = dot(ab, position - c), dot(ac, position - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    scale = 1.0 / (va + vb + vc)
    point = a + (vb * scale)[:, None] * ab + (vc * scale)[:, None] * ac
    regions = (
        (
            (va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0),
            b + ((d4 - d3) / (d4 - d3 + d5 - d6))[:, None] * (c - b),
        ),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), a + (d2 / (d2 - d6))[:, None] * ac),
        ((d6 >= 0) & (d5 <= d6), c),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), a + (d1 / (d1 - d3))[:, None] * ab),
        ((d3 >= 0) & (d4 <= d3), b),
        ((d1 <= 0) & (d2 <= 0), a),
    )
    for inside, value in regions:  # later ones win: the order of the scalar form, backwards
        point = torch.where(inside[:, None], value, point)
    return point


@dataclass(frozen=True, eq=False, slots=True)
class FeatureWalls:
    """A table of wall features as the paper's objective wants them (eq. 2): each sphere against each feature.

    Attributes:
        kind: Kind of each feature, shape (m,), int.
        row: The features, shape (m, FEATURE_WIDTH), float64.
    """

    kind: Tensor
    row: Tensor

    @classmethod
    def of(cls, walls: WallTable, device: str) -> FeatureWalls:
        """Return the features of a table on a device."""
        return cls(*(torch.as_tensor(each, device=device) for each in walls.features))

    def _all(self, position: Tensor, radius: Tensor) -> tuple[Tensor, Tensor]:
        count, features = len(position), len(self.kind)
        gap, push = feature_gaps(
            self.kind.repeat(count),
            self.row.repeat(count, 1),
            position.repeat_interleave(features, dim=0),
            radius.repeat_interleave(features),
        )
        return gap.view(count, features), push.view(count, features, 3)

    def exterior(self, position: Tensor, radius: Tensor) -> Tensor:
        """Return how far spheres stick out through each feature [m], positive outside, shape (n, m)."""
        return -self._all(position, radius)[0]

    def exterior_gradient(self, position: Tensor, weight: Tensor) -> Tensor:
        """Return the gradient of ``sum(weight * exterior)`` by the centres, shape (n, 3)."""
        push = self._all(position, torch.zeros_like(position[:, 0]))[1]
        return -(weight[:, :, None] * push).sum(dim=1)
