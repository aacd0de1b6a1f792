"""COLLECTIVE_ARRANGEMENT: spheres come in layers that arrange themselves together, zone by zone."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from packgen.arrange.collective.clump_plan import clump_plan, slenderness
from packgen.arrange.collective.clumps import fill_with_clumps
from packgen.arrange.collective.compaction import compaction_of
from packgen.arrange.collective.layers import fill_in_layers
from packgen.arrange.collective.loose import marked, places
from packgen.arrange.collective.no_floor import fill_at_once
from packgen.arrange.collective.open_zone import LayerReport, OpenZone
from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.collective.tiles.fill import fill_in_tiles, tile_layout
from packgen.arrange.collective.tiles.refusals import check_divisible, check_tiles
from packgen.arrange.crew import Crew
from packgen.arrange.pile import Pile
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.rigid.recipe import RigidRecipe
from packgen.arrange.space.region import Region, make_region
from packgen.arrange.spheres import Spheres, no_spheres
from packgen.arrange.task import Filled, Listener, Progress, Sink, Task, ZoneTask
from packgen.arrange.zones import fill_zones
from packgen.cores import free_cores
from packgen.geometry import floor_direction


def arrange(task: Task) -> Spheres:
    """Fill the zones of a task; see ``fill_zones``."""
    if task.settings.tile is not None:
        check_divisible(task)
        if task.sink is not None:
            return _fill_away(task, task.sink)
        return fill_zones(task, partial(fill_zone_in_tiles, crew=task.crew))
    return fill_zones(task, fill_zone)


def _fill_away(task: Task, sink: Sink) -> Spheres:
    """Fill the only zone of a task by tiles for a sink; return no spheres."""
    [zone] = task.zones
    filled = fill_zone_in_tiles(
        zone, no_spheres(), zone.generator(), task.on_progress, crew=task.crew, sink=sink
    )
    zone.supply.go_on_from(filled.supply)
    return filled.spheres


def fill_zone_in_tiles(
    zone: ZoneTask,
    _earlier: Spheres,
    _rng: np.random.Generator,
    listener: Listener,
    *,
    crew: Crew,
    sink: Sink | None = None,
) -> Filled:
    """Fill the only zone of a task by tiles; see ``task.FillZone``.

    Args:
        zone: The zone.
        listener: Hears of its progress.
        crew: Who does the work.
        sink: Takes the spheres in place of the result; None: the result has them.

    Raises:
        PackingError: The zone cannot be divided.
    """
    setting, supply = zone.setting, zone.supply
    region = make_region(
        setting.container, zone.locations, setting.down, supply.radius_max, zone.place, supply.radius_min
    )
    tile = setting.settings.tile
    layout = tile_layout(region, supply, None if tile == "auto" else tile)
    check_tiles(region, layout, supply.radius_reference)
    recipe = _recipe(zone, region, endless=False)
    tell = _report(listener, 0, supply.asked, region)
    return fill_in_tiles(zone, region, layout, recipe, crew, tell, sink)


def fill_zone(zone: ZoneTask, earlier: Spheres, rng: np.random.Generator, listener: Listener) -> Filled:
    """Fill one zone layer by layer, or at once where it has no floor; see ``task.FillZone``.

    Raises:
        PackingError: The zone lies outside the container.
    """
    if zone.of_clumps:
        return _fill_with_clumps(zone, earlier, rng, listener)
    setting, supply = zone.setting, zone.supply.copy()
    container = setting.container
    region = make_region(
        container, zone.locations, setting.down, supply.radius_max, zone.place, supply.radius_min
    )
    endless = floor_direction(setting.down, container.periodic) is None
    recipe = _recipe(zone, region, endless=endless)
    plan = LayerPlan()
    if zone.core_fraction is not None:
        plan = compaction_of(zone.core_fraction).plan(plan)
    if setting.settings.batch_size is not None:
        plan = plan.of_size(setting.settings.batch_size, supply, region)
    begun = marked(earlier, zone.loose_count)
    batch, threads = 0, setting.threads or free_cores()
    for gap in (recipe.gap, 0.0):
        open_zone = OpenZone(zone.index, region, supply, Pile(begun), rng, setting.device, threads)
        tell = _report(listener, len(earlier), supply.asked, region)
        recipe = replace(recipe, gap=gap)
        if endless:
            batch = fill_at_once(open_zone, recipe, tell, batch)
        else:
            batch = fill_in_layers(open_zone, recipe, plan, tell, batch)
        if len(open_zone.pile) > len(earlier):
            break
        # Walls one sphere apart leave no room for the gap with which spheres are arranged.
    spheres = open_zone.pile.all()
    moved = places(spheres, len(earlier), zone.index) if zone.loose_count else None
    return Filled(spheres[spheres.zone_index == zone.index], supply, batch, moved)


def _fill_with_clumps(
    zone: ZoneTask, earlier: Spheres, rng: np.random.Generator, listener: Listener
) -> Filled:
    """Fill one zone with bodies, layer by layer; see ``fill_zone``."""
    setting, supply = zone.setting, zone.supply.copy()
    slender = slenderness(zone.forms, supply.shares)
    region = make_region(
        setting.container, zone.locations, setting.down, slender * supply.radius_max, zone.place,
        supply.radius_min,
    )  # fmt: skip
    open_zone = OpenZone(zone.index, region, supply, Pile(earlier), rng, setting.device)
    tell = _report(listener, len(earlier), supply.asked, region)
    recipe = RigidRecipe.of_bodies(zone.friction, setting.settings.tolerance)
    batch = fill_with_clumps(open_zone, zone.forms, recipe, clump_plan(slender), tell)
    spheres = open_zone.pile.all()
    return Filled(spheres[spheres.zone_index == zone.index], supply, batch)


def _recipe(zone: ZoneTask, region: Region, *, endless: bool) -> Recipe:
    tolerance = zone.setting.settings.tolerance
    if endless:
        return Recipe(tolerance=tolerance)  # nothing sinks
    tube = _tube_width(zone, region)
    if zone.core_fraction is not None:
        return compaction_of(zone.core_fraction).recipe(tolerance, tube)
    return Recipe.of_friction(zone.friction, tolerance, tube)


def _tube_width(zone: ZoneTask, region: Region) -> float | None:
    """Return the width of a round region in sphere diameters; None: not round, or of broad sizes."""
    width = None if zone.supply.broad else region.tube_width()
    return None if width is None else width / (2.0 * zone.supply.radius_reference)


def _report(listener: Listener, before: int, total: int | None, region: Region) -> LayerReport:
    """Return a report of layers that tells a listener of one zone's progress."""

    def on_layer(batch: int, placed: int, level: float, thrown_back: int) -> None:
        height = (level - region.floor) / (region.ceiling - region.floor)
        share = min(max(height, 0.0), 1.0)
        listener(Progress("arrange", placed - before, total, batch, share, thrown_back))

    return on_layer
