"""COLLECTIVE_ARRANGEMENT: spheres come in batches that arrange themselves together, zone by zone.

The two optimisers share the regions, the walls and the end game: ``projection`` (``layers``) and the paper's
``adam`` (``adam_zone``, ``adam_space``).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrange.collective.layers import START_FRACTION, LayerPlan, fill_in_layers
from packgen.arrange.collective.no_floor import fill_at_once
from packgen.arrange.pile import Pile
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import settle
from packgen.arrange.proportions import trim_to_shares
from packgen.arrange.space.region import Region, make_region
from packgen.arrange.spheres import Spheres, joined
from packgen.arrange.task import Progress, Task, ZoneTask
from packgen.errors import PackingError
from packgen.geometry import Mesh, Polyhedron, floor_direction

if TYPE_CHECKING:
    from torch import Tensor

    from packgen.arrange.adam.zone import Finish

ADAM_BATCH = 500
"""The paper's batch size."""

PAPER_RADIUS = 0.1
"""Radius of the paper's spheres [m]: its learning rate is a length, and goes with the spheres."""


def arrange(task: Task) -> Spheres:
    """Fill the zones of a task.

    Args:
        task: What to fill and with what.

    Returns:
        The spheres that found a place, zone by zone; the others stay in the zones' supplies.

    Raises:
        PackingError: A zone lies outside the container, or nothing at all could be placed.
    """
    pile = Pile()
    batch = 0
    for zone in task.zones:
        if zone.supply.finished:
            continue
        supply = zone.supply
        region = make_region(
            task.container, zone.locations, task.down, supply.radius_max, zone.place, supply.radius_min
        )
        pile.unearth()
        fill = _fill_with_adam if task.settings.optimizer == "adam" else _fill_with_projection
        batch = fill(task, zone, region, pile, batch)
        if supply.asked is None and np.count_nonzero(supply.shares) > 1:
            trim_to_shares(pile, zone.index, supply.shares, -task.down)
    if len(pile) == 0:
        smallest = min(zone.supply.radius_min for zone in task.zones)
        meshed = isinstance(task.container.shape, Mesh | Polyhedron)
        raise PackingError(
            f"{task.zones[0].place}: not one sphere fits (smallest radius {smallest:.4g} m); expected a "
            f"larger container or smaller spheres{'; are the `units` of the mesh right?' if meshed else ''}"
        )
    return pile.all()


def _fill_with_projection(task: Task, zone: ZoneTask, region: Region, pile: Pile, first_batch: int) -> int:
    endless = floor_direction(task.down, task.container.periodic) is None
    tolerance = task.settings.tolerance
    # Nothing sinks in an endless bed.
    recipe = (
        Recipe(tolerance=tolerance)
        if endless
        else Recipe.of_friction(zone.friction, tolerance, _tube_width(zone, region))
    )
    plan = LayerPlan()
    if task.settings.batch_size is not None:
        plan = _plan_of_size(plan, task.settings.batch_size, zone, region)
    total = _total(task)

    def on_layer(batch: int, placed: int, level: float, thrown_back: int) -> None:
        height = (level - region.floor) / (region.ceiling - region.floor)
        task.on_progress(Progress("arrange", placed, total, batch, min(max(height, 0.0), 1.0), thrown_back))

    placed, batch = len(pile), first_batch
    for gap in (recipe.gap, 0.0):
        recipe = replace(recipe, gap=gap)
        supply, index, rng, device = zone.supply, zone.index, task.rng, task.device
        if endless:
            batch = fill_at_once(region, supply, pile, index, recipe, rng, on_layer, batch, device)
        else:
            batch = fill_in_layers(
                region, supply, pile, index, recipe, plan, rng, on_layer, batch, device=device
            )
        if len(pile) > placed:
            break
        # Walls as far apart as a sphere is wide leave no room for the gap that spheres are arranged with.
        pile.unearth()
    return batch


def _tube_width(zone: ZoneTask, region: Region) -> float | None:
    """Return the width of a round region in sphere diameters; None: not round, or of broad sizes."""
    width = region.tube_width() if zone.supply.radius_max <= 2.0 * zone.supply.radius_min else None
    return None if width is None else width / (2.0 * zone.supply.radius_reference)


def _plan_of_size(plan: LayerPlan, batch_size: int, zone: ZoneTask, region: Region) -> LayerPlan:
    """Return a plan whose layers hold about ``batch_size`` spheres at half of the region's height.

    Between half a diameter, thinner ones make loose beds, and twenty.
    """
    area = region.area(0.5 * (region.floor + region.ceiling))
    fraction = zone.supply.solid_fraction(START_FRACTION)
    per_diameter = fraction * area * 2.0 * zone.supply.radius_reference / zone.supply.mean_volume
    thickness = float(np.clip(batch_size / per_diameter, 0.5, 20.0))
    # A first layer thinner than its spheres would have no room between the floor and its own top.
    return replace(plan, thickness=thickness, first=max(1.0, 1.0 / thickness))


def _fill_with_adam(task: Task, zone: ZoneTask, region: Region, pile: Pile, first_batch: int) -> int:
    import torch

    from packgen.arrange.adam.batch import AdamSettings
    from packgen.arrange.adam.objective import Weights
    from packgen.arrange.adam.start_space import zone_space
    from packgen.arrange.adam.zone import BatchProgress, pack_zone_adam
    from packgen.arrange.space.torch_features import FeatureWalls

    params, before, total = task.settings, pile.front, _total(task)
    settings = AdamSettings(
        lr=params.lr * zone.supply.radius_reference / PAPER_RADIUS,
        n_epoch=params.n_epoch,
        patience=params.patience,
        weights=Weights(params.alpha, params.beta, params.gamma),
        batch_size=params.batch_size or ADAM_BATCH,
    )

    def on_batch(done: BatchProgress) -> None:
        height = (done.top - region.floor) / (region.ceiling - region.floor)
        placed = len(before) + done.placed
        share = min(max(height, 0.0), 1.0)
        task.on_progress(Progress("arrange", placed, total, first_batch, share, done.thrown_back))

    packed = pack_zone_adam(
        zone.supply,
        FeatureWalls.of(region.walls, task.device),
        zone_space(region, before, zone.supply.radius_max, zone.place),
        torch.as_tensor(task.down, device=task.device),
        torch.tensor(before.position, device=task.device),
        torch.tensor(before.radius, device=task.device),
        settings,
        task.rng,
        finish=None if params.tolerance is None else _end_game(region, Recipe(tolerance=params.tolerance)),
        on_progress=on_batch,
        threads=task.threads or 1,
    )
    added = Spheres(
        packed.position,
        packed.radius,
        packed.set_index,
        np.full(len(packed.radius), zone.index, np.int32),
        packed.batch_index + np.int32(first_batch),
    )
    pile.front = joined([before, added])
    return first_batch + int(packed.batch_index.max(initial=-1)) + 1


def _end_game(region: Region, recipe: Recipe) -> Finish:
    """Return what brings a batch of adam to tolerance: the projection sweeps without the sinking."""
    import torch

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


def _total(task: Task) -> int | None:
    """Return the number of spheres that all zones ask for; None: some zone is to be filled."""
    asked = [zone.supply.asked for zone in task.zones]
    return None if None in asked else sum(each or 0 for each in asked)
