"""Zone after zone: what all algorithms that fill one zone at a time have in common."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrange.proportions import trimmed_to_shares
from packgen.arrange.spheres import Spheres, count_of_bodies, joined
from packgen.arrange.task import FillZone, Task, of_whole_run
from packgen.errors import PackingError
from packgen.geometry import Mesh, Polyhedron

__all__ = ["fill_zones"]


def fill_zones(task: Task, fill: FillZone) -> Spheres:
    """Fill the zones of a task in their order, each beside the spheres of those before.

    Args:
        task: What to fill and with what.
        fill: Fills one zone.

    Returns:
        The spheres that were there before, and those that found a place, zone by zone; the others stay in the
        zones' supplies.

    Raises:
        PackingError: A zone lies outside the container, or nothing at all could be placed.
    """
    spheres, before = task.earlier, count_of_bodies(task.earlier)
    batch = int(spheres.batch_index.max(initial=-1)) + 1
    for zone in task.zones:
        if zone.supply.finished:
            continue
        placed = count_of_bodies(spheres) - before
        tell = of_whole_run(task.on_progress, placed, task.sphere_count, batch)
        filled = fill(zone, spheres, zone.generator(), tell)
        zone.supply.go_on_from(filled.supply)
        added = replace(filled.spheres, batch_index=filled.spheres.batch_index + np.int32(batch))
        if zone.supply.asked is None and np.count_nonzero(zone.supply.shares) > 1:
            added = trimmed_to_shares(added, zone.supply.shares, -task.down)
        if filled.earlier is not None:
            spheres = replace(spheres, position=filled.earlier)
        spheres, batch = joined([spheres, added]), batch + filled.batch_count
    if len(spheres) == len(task.earlier):
        raise PackingError(_nothing_fits(task))
    return spheres


def _nothing_fits(task: Task) -> str:
    smallest = min(zone.supply.radius_min for zone in task.zones)
    meshed = isinstance(task.container.shape, Mesh | Polyhedron)
    beside = f" beside the {len(task.earlier):,} of start_from" if len(task.earlier) else ""
    return (
        f"{task.zones[0].place}: not one sphere fits{beside} (smallest radius {smallest:.4g} m); expected a "
        f"larger container or smaller spheres{'; are the `units` of the mesh right?' if meshed else ''}"
    )
