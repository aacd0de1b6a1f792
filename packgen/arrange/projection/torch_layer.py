"""A layer of spheres under arrangement in plain torch, on any device: the fused loops' equal to rounding."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from packgen.arrange.neighbors.seam_pairs import images
from packgen.arrange.neighbors.torch_pairs import neighbor_pairs, neighbor_pairs_between
from packgen.arrange.projection.friction_kernels import TURN
from packgen.arrange.projection.pair_rules import (
    GRAIN_PUSH,
    GRAIN_STEP,
    PARTING_X,
    PARTING_Y,
    list_reach,
    pairs_to_part,
    push_weights,
)
from packgen.arrange.projection.ranks import closed_ranks
from packgen.arrange.projection.recipe import Schedule, Step, Tally
from packgen.arrange.projection.stepwise import run_by_steps
from packgen.arrange.space.torch_features import feature_gaps
from packgen.arrange.space.walls import WallTable, no_walls, walls_in_reach
from packgen.arrays import Float64Array, Int64Array


class PlainLayer:
    """The spheres being arranged, as tensors; see ``projection.Layer`` for what its methods do."""

    def __init__(
        self,
        ball: Float64Array,
        moving: int,
        walls: WallTable,
        device: str,
        body: Int64Array | None = None,
    ) -> None:
        self._body = np.empty(0, np.int64) if body is None else body
        self.device = "cpu" if device == "torch" else device
        self.ball = torch.as_tensor(ball, device=self.device).clone()
        self.moving = moving
        self.walls = walls
        self.identity: Int64Array = np.arange(moving)
        self.previous = self.ball[:moving, :3].clone()
        self._spin = torch.zeros_like(self.ball[:, :3])
        self._reference = float(ball[:moving, 3].mean()) if moving else 0.0
        self._kind = torch.as_tensor(walls.features.kind, device=self.device)
        self._row = torch.as_tensor(walls.features.row, device=self.device)

    def rebuild(self, skin: float) -> None:
        """List neighbours and walls anew, good until a sphere moves by its margin; see ``list_reach``."""
        self._close_ranks()
        position, radius, moving = self.ball[:, :3], self.ball[:, 3], self.moving
        reach = self._reach(skin)
        self.margin = (reach - radius)[:moving]
        inner = neighbor_pairs(position[:moving], reach[:moving])
        outer = neighbor_pairs_between(position[:moving], reach[:moving], position[moving:], reach[moving:])
        shifted = outer + torch.tensor([0, moving], device=self.device)
        self.pairs: Tensor = torch.cat([inner, shifted])
        self.offset = torch.zeros((1, 3), dtype=torch.float64, device=self.device)
        if self.walls.seams.wraps:
            self._list_seams(reach)
        if len(self._body):
            self._leave_out_bodies()
        self.anchor = position[:moving].clone()
        self._spin = torch.zeros_like(position)
        weight = push_weights(self.ball.cpu().numpy(), moving, self._reference)
        self.weight = torch.as_tensor(weight, device=self.device)
        self._list_walls()

    def _reach(self, skin: float) -> Tensor:
        reach = list_reach(self.ball.cpu().numpy(), self.moving, skin, self._reference)
        return torch.as_tensor(reach, device=self.device)

    def _close_ranks(self) -> None:
        ball, previous = self.ball.cpu().numpy(), self.previous.cpu().numpy()
        ball, previous, self.identity = closed_ranks(ball, previous, self.identity, self.walls.seams)
        self.ball = torch.as_tensor(ball, device=self.device)
        self.previous = torch.as_tensor(previous, device=self.device)
        self.moving = len(previous)

    def _list_seams(self, reach: Tensor) -> None:
        """Append the pairs of a sphere and another one's image to the list, each pair once."""
        sphere, shift = images(self.ball.cpu().numpy(), reach.cpu().numpy(), self.walls.seams)
        owner = torch.as_tensor(sphere, device=self.device)
        offset = torch.as_tensor(shift, device=self.device)
        position = self.ball[:, :3]
        found = neighbor_pairs_between(position, reach, position[owner] + offset, reach[owner])
        first, second, offset = found[:, 0], owner[found[:, 1]], offset[found[:, 1]]
        # The first of a pair moves, as in the list of all others.
        turn = first >= self.moving
        first, second = torch.where(turn, second, first), torch.where(turn, first, second)
        offset = torch.where(turn[:, None], -offset, offset)
        wanted = first < self.moving
        self.offset = torch.cat([self.offset.expand(len(self.pairs), 3), offset[wanted]])
        self.pairs = torch.cat([self.pairs, torch.stack([first, second], dim=1)[wanted]])

    def _leave_out_bodies(self) -> None:
        """Take the pairs of one body out of the list: its spheres may overlap each other."""
        first, second = self.pairs.cpu().numpy().T
        wanted = pairs_to_part(first, second, self._body, self.identity)
        apart = torch.as_tensor(wanted, device=self.device)
        self.offset = self.offset.expand(len(self.pairs), 3)[apart]
        self.pairs = self.pairs[apart]

    def _list_walls(self) -> None:
        ball = np.ascontiguousarray(self.ball[: self.moving].cpu().numpy())
        begin, item, _ = walls_in_reach(ball, self.margin.cpu().numpy(), self.walls, no_walls())
        count = np.diff(begin)
        self.wall_count = torch.as_tensor(count, device=self.device)
        sphere = np.repeat(np.arange(self.moving), count)
        rank = np.arange(begin[-1]) - begin[sphere]
        # The fused loop puts a sphere back from one feature after the other: here rank by rank, all at once.
        self.wall_ranks = [
            (
                torch.as_tensor(sphere[rank == k], device=self.device),
                torch.as_tensor(item[: begin[-1]][rank == k].astype(np.int64), device=self.device),
            )
            for k in range(int(count.max(initial=0)))
        ]

    def _pair_depths(self, scale: float) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        first, second = self.pairs.unbind(dim=1)
        difference = self.ball[first, :3] - (self.ball[second, :3] + self.offset)
        distance = torch.linalg.vector_norm(difference, dim=1)
        overlap = scale * (self.ball[first, 3] + self.ball[second, 3]) - distance
        smaller = scale * torch.minimum(self.ball[first, 3], self.ball[second, 3])
        return difference, distance, overlap, smaller

    def _pushes(self) -> tuple[float, Tensor]:
        first, second = self.pairs.unbind(dim=1)
        difference, distance, overlap, smaller = self._pair_depths(1.0)
        deep = overlap > 0.0
        worst = float((overlap / smaller)[deep].max()) if bool(deep.any()) else 0.0
        first, second, overlap = first[deep], second[deep], overlap[deep]
        difference, distance = difference[deep], distance[deep]
        reach = self.ball[first, 3] + self.ball[second, 3]
        same = distance < 1e-9 * reach
        across, along = PARTING_X * (first + second), PARTING_Y * (first + second)
        parting = torch.stack([across.frac() - 0.5, along.frac() - 0.5, 0.5 - (first & 1)], dim=1)
        difference = torch.where(same[:, None], parting, difference)
        distance = torch.where(same, torch.linalg.vector_norm(parting, dim=1), distance)
        both = second < self.moving
        share = self.weight[first] / (self.weight[first] + self.weight[second])
        push = (overlap / distance)[:, None] * difference
        shift = torch.zeros_like(self.previous)
        shift.index_add_(0, first, share[:, None] * push)
        shift.index_add_(0, second[both], -((1.0 - share)[:, None] * push)[both])
        return worst, shift

    def _rubs(self, travel: Tensor, step: Step) -> Tensor:
        """Return what friction adds to the pushes, and turn the spheres; see ``friction_kernels.rub``."""
        first, second = self.pairs.unbind(dim=1)
        difference, distance, overlap, _ = self._pair_depths(1.0)
        deep = (overlap > 0.0) & (distance >= 1e-9 * (self.ball[first, 3] + self.ball[second, 3]))
        first, second, overlap = first[deep], second[deep], overlap[deep]
        normal = difference[deep] / distance[deep, None]
        spin, size = step.momentum * self._spin, self.ball[:, 3, None]
        rolling = torch.linalg.cross(size[first] * spin[first] + size[second] * spin[second], normal)
        sliding = travel[first] - travel[second] - rolling
        sliding -= (sliding * normal).sum(dim=1, keepdim=True) * normal
        speed = torch.linalg.vector_norm(sliding, dim=1).clamp(min=1e-300)
        held = torch.clamp(step.friction * overlap / speed, max=step.grip)[:, None] * sliding
        share = (self.weight[first] / (self.weight[first] + self.weight[second]))[:, None]
        shift, turned = torch.zeros_like(spin), torch.zeros_like(spin)
        shift.index_add_(0, first, -share * held).index_add_(0, second, (1.0 - share) * held)
        torque = TURN * torch.linalg.cross(normal, held)
        turned.index_add_(0, first, share / size[first] * torque)
        turned.index_add_(0, second, (1.0 - share) / size[second] * torque)
        self._spin = spin + turned
        self._spin[self.moving :] = 0.0
        return shift

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Sink, extrapolate, push apart, put back; return (largest overlap, spheres that outran the list)."""
        moving = self.moving
        before = self.ball[:, :3].clone()
        here = before[:moving] + torch.as_tensor(sink, device=self.device)
        self.ball[:moving, :3] = here + step.momentum * (here - self.previous)
        self.previous = here
        worst, shift = self._pushes()
        if step.friction > 0.0:
            shift += self._rubs(self.ball[:, :3] - before, step)[:moving]
        shift *= step.relaxation
        radius = self.ball[:moving, 3]
        length = torch.linalg.vector_norm(shift, dim=1)
        limit = step.stride * radius
        shift *= torch.where(length > limit, limit / length.clamp(min=1e-300), 1.0)[:, None]
        position = self.ball[:moving, :3] + shift
        self._put_back(position, radius, step.roughness)
        self.ball[:moving, :3] = position
        moved = torch.linalg.vector_norm(position - self.anchor, dim=1)
        far = int((moved > step.far * self.margin).sum())
        return worst, int((moved > self.margin).sum()) + far * moving

    def run(self, down: Float64Array, schedule: Schedule, strays: int) -> Tally:
        """Run the sweeps of a schedule one by one; see ``stepwise.run_by_steps``."""
        return run_by_steps(self, down, schedule, strays, self._reference, self._body)

    def _put_back(self, position: Tensor, radius: Tensor, roughness: float) -> None:
        """Put spheres back inside their walls, twice where they meet several, or keep them off rough ones."""
        number = torch.as_tensor(self.identity, dtype=torch.float64, device=self.device)
        keep_off = roughness * radius * (number * GRAIN_STEP % 1.0)
        gentle = GRAIN_PUSH * radius
        several = self.wall_count > 1
        for ranks in (self.wall_ranks, [(s[several[s]], f[several[s]]) for s, f in self.wall_ranks]):
            for sphere, feature in ranks:
                gap, normal = feature_gaps(
                    self._kind[feature], self._row[feature], position[sphere], radius[sphere]
                )
                rough = torch.minimum(keep_off[sphere] - gap.clamp(min=0.0), gentle[sphere]).clamp(min=0.0)
                gentle[sphere] -= rough
                push = (-gap).clamp(min=0.0) + rough
                position[sphere] += push[:, None] * normal

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""
        moving = self.moving
        blame = torch.zeros(moving, dtype=torch.float64, device=self.device)
        height = -(self.ball[:, :3] @ torch.as_tensor(down, device=self.device))
        first, second = self.pairs.unbind(dim=1)
        _, _, overlap, smaller = self._pair_depths(scale)
        deep = overlap > 0.0
        first, second, depth = first[deep], second[deep], (overlap / smaller)[deep]
        # A small sphere finds another place more easily than a large one.
        size_first, size_second = self.ball[first, 3], self.ball[second, 3]
        takes_second = (size_second < 0.6 * size_first) | (height[second] > height[first])
        takes_second &= (second < moving) & ~(size_first < 0.6 * size_second)
        blamed = torch.where(takes_second, second, first)
        blame.scatter_reduce_(0, blamed, depth, "amax")
        for sphere, feature in self.wall_ranks:
            radius = scale * self.ball[sphere, 3]
            center = self.ball[sphere, :3]
            gap, _ = feature_gaps(self._kind[feature], self._row[feature], center, radius)
            depth = (-gap / radius).clamp(min=0.0)
            blame.scatter_reduce_(0, sphere, depth.where(~torch.isnan(center[:, 0]), 0.0), "amax")
        worst = float(blame.max()) if moving else 0.0
        return worst, blame.cpu().numpy()

    def take_out(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of all contacts."""
        self.ball[: self.moving][torch.as_tensor(out, device=self.device), :3] = torch.nan

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3)."""
        return self.walls.seams.wrapped(self.ball[: self.moving, :3].cpu().numpy())

    def radii(self) -> Float64Array:
        """Return the arranged radii of the moving spheres, in the layer's own order [m], shape (moving,)."""
        return self.ball[: self.moving, 3].cpu().numpy()
