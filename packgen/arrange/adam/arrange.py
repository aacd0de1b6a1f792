"""ADAM: the paper's Algorithm 1, with projection sweeps as its end game."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import settle
from packgen.arrange.space.region import Region, make_region
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Filled, Listener, Progress, Task, ZoneTask
from packgen.arrange.zones import fill_zones

if TYPE_CHECKING:
    from torch import Tensor

    from packgen.arrange.adam.batch import AdamSettings
    from packgen.arrange.adam.zone import BatchProgress, Finish

BATCH_SIZE = 500
"""The paper's batch size."""

PAPER_RADIUS = 0.1
"""Radius of the paper's spheres [m]: its learning rate is a length and scales with the radii."""


def arrange(task: Task) -> Spheres:
    """Fill the zones of a task, in a container that is not periodic; see ``fill_zones``."""
    return fill_zones(task, fill_zone)


def fill_zone(zone: ZoneTask, earlier: Spheres, rng: np.random.Generator, listener: Listener) -> Filled:
    """Fill one zone batch by batch; see ``task.FillZone``.

    Raises:
        PackingError: The zone lies outside the container, or is too narrow to find room in.
    """
    import torch

    from packgen.arrange.adam.start_space import zone_space
    from packgen.arrange.adam.zone import Surroundings, pack_zone_adam
    from packgen.arrange.space.torch_features import FeatureWalls

    setting, supply = zone.setting, zone.supply.copy()
    params, device = setting.settings, setting.device
    region = make_region(
        setting.container, zone.locations, setting.down, supply.radius_max, zone.place, supply.radius_min
    )
    around = Surroundings(
        FeatureWalls.of(region.walls, device),
        zone_space(region, earlier, supply.radius_max, zone.place),
        torch.as_tensor(setting.down, device=device),
        torch.tensor(earlier.position, device=device),
        torch.tensor(earlier.radius, device=device),
    )
    reporter = _Reporter(listener, supply.asked, region, params.verbosity)
    packed = pack_zone_adam(
        supply,
        around,
        _settings(zone),
        rng,
        finish=_inside(region) if params.tolerance is None else _end_game(region, params.tolerance),
        on_progress=reporter.tell_batch,
        on_step=reporter.tell_step,
        threads=setting.threads or 1,
    )
    index = np.full(len(packed.radius), zone.index, np.int32)
    spheres = Spheres(packed.position, packed.radius, packed.set_index, index, packed.batch_index)
    return Filled(spheres, supply, int(packed.batch_index.max(initial=-1)) + 1)


def _settings(zone: ZoneTask) -> AdamSettings:
    from packgen.arrange.adam.batch import AdamSettings
    from packgen.arrange.adam.objective import Weights

    params = zone.setting.settings
    return AdamSettings(
        lr=params.lr * zone.supply.radius_reference / PAPER_RADIUS,
        n_epoch=params.n_epoch,
        patience=params.patience,
        weights=Weights(params.alpha, params.beta, params.gamma),
        batch_size=params.batch_size or BATCH_SIZE,
    )


class _Reporter:
    """Tells a listener of the batches of one zone, and of every ``every``-th step of each."""

    def __init__(self, listener: Listener, total: int | None, region: Region, every: int) -> None:
        self._listener, self._region, self._every = listener, region, every
        self._last = Progress("arrange", 0, total, 0, 0.0, 0)

    def tell_batch(self, done: BatchProgress) -> None:
        """Tell of a batch that is done."""
        region, last = self._region, self._last
        height = (done.top - region.floor) / (region.ceiling - region.floor)
        share = min(max(height, 0.0), 1.0)
        batch = last.batch + int(done.accepted)
        self._last = replace(
            last, placed=done.placed, batch=batch, height=share, thrown_back=done.thrown_back
        )
        self._listener(self._last)

    def tell_step(self, step: int, _value: float, _rate: float) -> None:
        """Tell of a step of the batch under way."""
        if self._every and step % self._every == 0:
            self._listener(replace(self._last, stage=f"arrange, step {step} of a batch"))


def _inside(region: Region) -> Finish:
    """Return what throws out the spheres of a batch that slipped through a mesh, and leaves all others."""
    import torch

    def finish(position: Tensor, _radius: Tensor, *_fixed: Tensor) -> tuple[Tensor, Tensor]:
        kept = region.holds(position.cpu().numpy())
        return torch.as_tensor(kept, device=position.device), position

    return finish


def _end_game(region: Region, tolerance: float) -> Finish:
    """Return the end game of a batch, which brings it to tolerance: projection sweeps without the sinking."""
    import torch

    recipe = Recipe(tolerance=tolerance)

    def finish(position: Tensor, radius: Tensor, *fixed: Tensor) -> tuple[Tensor, Tensor]:
        spheres = [
            np.column_stack([position.cpu(), radius.cpu()]),
            np.column_stack([each.cpu() for each in fixed]),
        ]
        settled, kept = settle(
            np.concatenate(spheres), len(radius), region.walls, region.down, recipe, sink=False
        )
        kept &= region.holds(settled)
        return torch.as_tensor(kept, device=radius.device), position.new_tensor(settled)

    return finish
