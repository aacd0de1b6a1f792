"""DISPERSED: spheres spread over their zones without gravity and without contacts."""

from __future__ import annotations

import numpy as np

from packgen.arrange.dispersed.crowding import Room
from packgen.arrange.dispersed.disperse import FULL_FRACTION, LOOSE_FRACTION, Dispersion
from packgen.arrange.space.region import Region, make_region
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Filled, Gap, Listener, Progress, Task, ZoneTask
from packgen.arrange.zones import fill_zones
from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube
from packgen.supply.supply import Draw, Supply


def arrange(task: Task) -> Spheres:
    """Fill the zones of a task; see ``fill_zones``."""
    return fill_zones(task, fill_zone)


def fill_zone(zone: ZoneTask, earlier: Spheres, rng: np.random.Generator, listener: Listener) -> Filled:
    """Disperse the spheres of one zone among those of earlier ones; see ``task.FillZone``.

    Raises:
        PackingError: The zone lies outside the container.
    """
    setting, supply, gap = zone.setting, zone.supply.copy(), zone.gap
    smallest, largest = (np.array([each]) for each in (supply.radius_min, supply.radius_max))
    region = make_region(
        setting.container,
        zone.locations,
        setting.down,
        float(gap.wall(largest)[0]),
        zone.place,
        float(gap.wall(smallest)[0]),
    )
    room = Room(region, *_nearby(region, earlier, gap, float(gap.half(largest)[0])))
    draw = _drawn(supply, room, gap)
    total = supply.asked

    def tell(stage: str, placed: int, share: float) -> None:
        listener(Progress(stage, placed, total, 1, share, 0))

    state = Dispersion(
        room, gap.half(draw.radius), gap.wall(draw.radius), supply.solid_fraction(LOOSE_FRACTION), rng
    )
    tell("part", 0, 0.0)
    state.start()
    state.retry()
    placed = int(state.kept.sum())
    state.stir(state.settle_rounds(), lambda share: tell("stir", placed, share))
    kept = state.kept & region.holds(state.center)
    bodies = draw.body_index
    rest = None if bodies is None else bodies[~kept]
    if not kept.all():
        supply.put_back(Draw(draw.radius[~kept], draw.set_index[~kept], rest))
    count = len(draw.radius)
    spheres = Spheres(
        state.center, draw.radius, draw.set_index,
        np.full(count, zone.index, np.int32), np.zeros(count, np.int32), bodies,
    )  # fmt: skip
    return Filled(spheres[kept], supply, 1)


def _nearby(region: Region, earlier: Spheres, gap: Gap, reach: float) -> tuple[Float64Array, Float64Array]:
    """Return centres and half distances of the earlier spheres that can touch the zone's."""
    half = gap.half(earlier.radius)
    low, high = region.bounds
    beyond = half[:, None] + reach
    near = ((earlier.position >= low - beyond) & (earlier.position <= high + beyond)).all(axis=1)
    if region.walls.seams.wraps:
        near[:] = True  # a zone's neighbours may be on the other side of the box
    return earlier.position[near], half[near]


def _drawn(supply: Supply, room: Room, gap: Gap) -> Draw:
    """Return the zone's spheres: all that it asks for, or as many as fill it."""
    if supply.remaining is not None:
        return supply.take(supply.remaining)
    radius = np.array([supply.radius_by_volume])
    half = gap.half(radius)
    larger = float(half[0] / radius[0])
    solid = room.solid(supply.solid_fraction(FULL_FRACTION), half, gap.wall(radius))
    solid /= larger * larger * larger
    draw = supply.take(max(round(solid / supply.mean_volume), 1))
    while float((UNIT_VOLUME * cube(draw.radius)).sum()) < solid - 0.5 * supply.mean_volume:
        more = supply.take(max(len(draw.radius) // 20, 1))
        draw = Draw(
            np.concatenate([draw.radius, more.radius]), np.concatenate([draw.set_index, more.set_index])
        )
    return draw
