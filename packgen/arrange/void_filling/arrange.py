"""VOID_FILLING: the largest sphere that fits, again and again; or drawn ones, each into the smallest void."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from packgen.arrange.space.seams import Seams
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Filled, Listener, Progress, Task, ZoneTask
from packgen.arrange.void_filling.hollow import Hollow
from packgen.arrange.zones import fill_zones
from packgen.distributions import UNIT_VOLUME, Free
from packgen.errors import PackingError
from packgen.geometry import Slice
from packgen.geometry.bounds import shape_bounds
from packgen.portable import cube, cube_root, scalar_power
from packgen.supply.supply import COUNT_LIMIT, Draw, Supply

PERIOD_SHARE = 0.25
"""Largest radius in a periodic box, in periods: no sphere meets another one twice."""

MOST = 2_000_000
"""Spheres from which a zone without a number and without a coverage is refused."""

PER_SIZE, DIMENSION = 0.05, 2.47
"""How many spheres of free sizes are larger than a share s of a body's size: about 0.05 s^-2.47."""

DRAWN = 0.6
"""Solid fraction up to which spheres of equal size are drawn for a zone that is to be filled."""


def arrange(task: Task) -> Spheres:
    """Fill the zones of a task, each beside the spheres of those before.

    Raises:
        PackingError: Nothing fits, or a zone asks for what this algorithm cannot keep.
    """
    for zone in task.zones:
        _refuse(zone)
    return fill_zones(task, fill_zone)


def _refuse(zone: ZoneTask) -> None:
    """Refuse what would never end, and what cannot be told.

    Raises:
        PackingError: See `arrange`.
    """
    coverage, free = zone.setting.settings.coverage, zone.supply.free
    if coverage is not None and zone.locations:
        raise PackingError(
            f"{zone.place}: found a location beside `coverage`, expected one of both: coverage is that of "
            "the whole container; leave the other out"
        )
    if free is None or coverage is not None or zone.supply.asked is not None:
        return
    size = cube_root(zone.setting.container.volume)
    count = PER_SIZE * (size / free.radius_min) ** DIMENSION
    if count > MOST:
        enough = size * (PER_SIZE / MOST) ** (1.0 / DIMENSION)
        raise PackingError(
            f"{zone.place}: found radius_min = {free.radius_min:.4g} m and no other end, for about "
            f"{count:.2g} spheres, expected at most {MOST:,}; give n_particles, "
            f"`params: {{coverage: 0.85}}`, or a radius_min of {enough:.2g} m"
        )


def fill_zone(zone: ZoneTask, earlier: Spheres, rng: np.random.Generator, listener: Listener) -> Filled:
    """Fill the voids of one zone.

    Args:
        zone: The zone.
        earlier: Spheres of earlier zones; they stay where they are.
        rng: Source of randomness; all follows from the radii.
        listener: Called with the progress.

    Returns:
        The zone's spheres and the rest of its supply.
    """
    del rng
    supply = zone.supply.copy()
    hollow = hollow_of(zone, earlier)
    solid = np.inf
    if zone.setting.settings.coverage is not None:
        wanted = zone.setting.settings.coverage * zone.setting.container.volume / UNIT_VOLUME
        solid = wanted - float(cube(earlier.radius).sum())

    def tell(placed: int) -> None:
        listener(Progress("fill voids", placed, supply.asked, 1, 0.0, 0))

    tell(0)
    if supply.free is not None:
        draw = _free(zone, supply, supply.free, hollow, solid, tell)
    else:
        draw = _drawn(zone, supply, hollow, solid, tell)
    count = len(draw.radius)
    position = Seams.of(zone.setting.container).wrapped(hollow.ball[:, :3])
    spheres = Spheres(
        position, draw.radius, draw.set_index, np.full(count, zone.index, np.int32),
        np.zeros(count, np.int32), draw.body_index,
    )  # fmt: skip
    return Filled(spheres, supply, 1)


def hollow_of(zone: ZoneTask, earlier: Spheres) -> Hollow:
    """Return the space of a zone with the spheres that are there.

    Raises:
        PackingError: The zone lies outside the container.
    """
    container = zone.setting.container
    bounds = np.array(container.bounds)
    own = [replace(each, centers_only=False) if isinstance(each, Slice) else each for each in zone.locations]
    for location in own:
        least, most = shape_bounds(location)
        bounds = np.stack([np.maximum(bounds[0], least), np.minimum(bounds[1], most)])
    if (bounds[0] >= bounds[1]).any():
        raise PackingError(f"{zone.place}: the location lies outside the container; move it inside")
    seams = Seams.of(container)
    ball = np.column_stack([earlier.position, earlier.radius])
    return Hollow([container.shape, *own], bounds, seams, ball)


def _free(
    zone: ZoneTask, supply: Supply, free: Free, hollow: Hollow, solid: float, tell: Callable[[int], None]
) -> Draw:
    """Fill a zone with spheres as large as its voids; take as many of the supply."""
    most = float(COUNT_LIMIT if supply.remaining is None else supply.remaining)
    periods = [each for each in zone.setting.container.period if each is not None]
    cap = min([np.inf if free.radius_max is None else free.radius_max, *(PERIOD_SHARE * p for p in periods)])
    capped = 0
    if np.isfinite(cap):
        capped = hollow.repeat(cap, int(most), solid, zone.setting.down, free.radius_min, tell)
        solid -= capped * scalar_power(cap, 3)
    hollow.fill(free.radius_min, most - capped, solid, tell)
    draw = supply.take(len(hollow.ball))
    return Draw(hollow.ball[:, 3], draw.set_index)


def _drawn(zone: ZoneTask, supply: Supply, hollow: Hollow, solid: float, tell: Callable[[int], None]) -> Draw:
    """Put a zone's spheres into its voids, the largest first; give back what finds no place."""
    if supply.remaining is not None:
        draw = supply.take(supply.remaining)
    else:
        volume = zone.setting.container.volume * supply.solid_fraction(DRAWN)
        draw = supply.take(max(round(volume / supply.mean_volume), 1))
    order = np.lexsort((draw.set_index, -draw.radius))
    radius = np.ascontiguousarray(draw.radius[order])
    placed = hollow.place(radius, solid, zone.setting.down, tell=tell)
    kept, rest = order[placed], np.sort(order[~placed])
    supply.put_back(Draw(draw.radius[rest], draw.set_index[rest]))
    return Draw(draw.radius[kept], draw.set_index[kept])
