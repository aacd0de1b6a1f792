"""JAMMED: spheres pressed together until nothing can move, in a container that takes the size they need."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from packgen.arrange.jammed.jam import Jammed, Jammer
from packgen.arrange.jammed.starts import volume_and_loss
from packgen.arrange.space.region import Region, make_region
from packgen.arrange.space.seams import Seams
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Outcome, Task, ZoneTask
from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.geometry import Container, Slice
from packgen.geometry.scaling import fixed_point, scaled_container
from packgen.jamming import Jamming
from packgen.portable import cube, cube_root, scalar_power
from packgen.supply.supply import Draw, Supply

PERIOD_MIN = 4.0
"""Least length of a periodic box, in largest radii: no sphere meets another one twice."""

ROOM = 1.5
"""Largest radius for which a region is mapped, in those that start."""

FULL_FRACTION = 0.638
"""Solid fraction of equal spheres away from the walls, where the number of spheres follows."""

TRIES = 8
"""Times that the number of spheres is corrected."""

SLACK = 2.0e-3
"""Share of the volume that is left to spare when their number is corrected, and half a sphere."""


@dataclass(frozen=True, eq=False, slots=True)
class _Plan:
    """What is to be jammed.

    Attributes:
        region: The zone.
        volume: Its volume [m3].
        full: Solid volume of a jammed bed in it, about [m3].
        dense: Solid volume with which one starts [m3].
    """

    region: Region
    volume: float
    full: float
    dense: float


def arrange(task: Task) -> Outcome:
    """Jam the spheres of a task's one zone.

    Raises:
        PackingError: The task has several zones, or asks for what this algorithm cannot keep.
    """
    _refuse(task)
    zone = task.zones[0]
    if task.settings.adjust == "count":
        return _with_fitting_count(task, zone)
    return _with_fitting_container(task, zone)


def _refuse(task: Task) -> None:
    """Refuse what cannot be jammed.

    Raises:
        PackingError: See ``arrange``.
    """
    zone = task.zones[0]
    by_count = task.settings.adjust == "count"
    if len(task.zones) > 1:
        raise PackingError(
            f"{task.zones[1].place}: found {len(task.zones)} zones, expected one: JAMMED presses all spheres "
            "together; give their shares by `set_proportions`"
        )
    if zone.locations and not by_count:
        raise PackingError(
            f"{zone.place}: found a location, expected none: the container takes the size that its spheres "
            "need; leave it out, or take `params: {adjust: count}`"
        )
    if zone.locations and any(task.container.periodic):
        raise PackingError(
            f"{zone.place}: found a location in a periodic box, expected the whole box; leave one of both out"
        )
    if by_count and zone.supply.asked is not None:
        raise PackingError(
            f"{zone.place}: found {zone.supply.asked:,} spheres asked for, expected no amount: with `adjust: "
            "count` it follows from the container; leave it out, or take `params: {adjust: container}`"
        )


def _plan(task: Task, zone: ZoneTask, solid: float | None) -> _Plan:
    """Return where spheres of a solid volume [m3] start; None: those that fill the container."""
    supply, container = zone.supply, task.container
    full, start = (supply.solid_fraction(each) for each in (FULL_FRACTION, task.settings.phi_start))
    larger = 1.0 if solid is None else cube_root(start * container.volume / solid)
    locations = [
        replace(each, centers_only=False) if isinstance(each, Slice) else each for each in zone.locations
    ]
    region = make_region(
        container, locations, task.down, ROOM * larger * supply.radius_max, zone.place,
        larger * supply.radius_min,
    )  # fmt: skip
    volume, loss = volume_and_loss(region, larger * supply.radius_by_volume)
    volume = volume if locations else container.volume
    return _Plan(region, volume, (1.0 - loss) * full * volume, (1.0 - loss) * start * volume)


def _jammer(task: Task, zone: ZoneTask, region: Region) -> Jammer:
    return Jammer(
        task.container, region, task.settings, zone.generator(), task.on_progress, zone.place,
        located=bool(zone.locations),
    )  # fmt: skip


def _with_fitting_container(task: Task, zone: ZoneTask) -> Outcome:
    supply, container = zone.supply, task.container
    draw = (
        supply.take(supply.remaining) if supply.remaining else _filling(supply, _plan(task, zone, None).full)
    )
    solid = _solid(draw.radius)
    plan = _plan(task, zone, solid)
    _check_periods(zone, container, draw.radius, cube_root(solid / plan.full))
    jammed = _jammer(task, zone, plan.region).jam(draw.radius, plan.dense / solid)
    shorter = 1.0 / jammed.factor
    _check_periods(zone, container, draw.radius, shorter)
    fitted = scaled_container(container, shorter)
    still = fixed_point(container)
    position = Seams.of(fitted).wrapped(still + (jammed.center - still) * shorter)
    return Outcome(
        _spheres(zone, position, draw), fitted, _jamming("container", container, fitted, jammed, shorter)
    )


def _with_fitting_count(task: Task, zone: ZoneTask) -> Outcome:
    """Jam as many spheres as the container holds: a number, and a better one by what it needed."""
    supply, plan = zone.supply, _plan(task, zone, None)
    jammer = _jammer(task, zone, plan.region)
    full = plan.full
    best: tuple[Draw, Jammed] | None = None
    for _ in range(TRIES):
        draw = _filling(supply, full)
        solid = _solid(draw.radius)
        jammed = jammer.jam(draw.radius, plan.dense / solid)
        free = cube(np.array([jammed.factor]))[0]
        spare = SLACK + 0.5 * supply.mean_volume / solid
        if free >= 1.0 and (best is None or solid > _solid(best[0].radius)):
            best = draw, jammed
        if 1.0 <= free <= 1.0 + 2.0 * spare + supply.mean_volume / solid:
            break
        full = solid * free * (1.0 - spare)
        supply.put_back(draw)
    if best is None:
        raise PackingError(
            f"{zone.place}: found no number of spheres that jams in this container, expected one; take "
            "`params: {adjust: container}`"
        )
    draw, jammed = best
    jamming = _jamming("count", task.container, task.container, jammed, 1.0)
    position = Seams.of(task.container).wrapped(jammed.center)
    return Outcome(_spheres(zone, position, draw), task.container, jamming)


def _filling(supply: Supply, solid: float) -> Draw:
    """Return spheres of about a solid volume [m3], at least one."""
    count = max(round(solid / supply.mean_volume), 1)
    draw = supply.take(count)
    volume = np.cumsum(UNIT_VOLUME * cube(draw.radius))
    while volume[-1] < solid - 0.5 * supply.mean_volume:
        more = supply.take(max(count // 20, 1))
        draw = Draw(
            np.concatenate([draw.radius, more.radius]), np.concatenate([draw.set_index, more.set_index])
        )
        volume = np.cumsum(UNIT_VOLUME * cube(draw.radius))
    kept, rest = draw.split(max(int(np.searchsorted(volume, solid + 0.5 * supply.mean_volume)), 1))
    supply.put_back(rest)
    return kept


def _solid(radius: Float64Array) -> float:
    return float((UNIT_VOLUME * cube(radius)).sum())


def _check_periods(zone: ZoneTask, container: Container, radius: Float64Array, factor: float) -> None:
    """Refuse a periodic box that gets so short that a sphere meets another one twice.

    Raises:
        PackingError: It does.
    """
    extent = factor * (container.bounds[1] - container.bounds[0])
    least = PERIOD_MIN * float(radius.max())
    for axis in np.flatnonzero(container.periodic):
        if extent[axis] < least * (1.0 - 1e-9):
            enough = math.ceil(len(radius) * scalar_power(least / float(extent[axis]), 3))
            raise PackingError(
                f"{zone.place}: found {len(radius):,} spheres, whose periodic box becomes "
                f"{extent[axis]:.4g} m long along {'xyz'[axis]}, expected at least {least:.4g} m, two "
                "diameters of the largest sphere, so that none meets another one twice; ask for about "
                f"{enough:,}"
            )


def _spheres(zone: ZoneTask, position: Float64Array, draw: Draw) -> Spheres:
    nothing = np.zeros(len(draw.radius), np.int32)
    return Spheres(
        position, draw.radius, draw.set_index, nothing + np.int32(zone.index), nothing, draw.body_index
    )


def _jamming(adjusted: str, asked: Container, fitted: Container, jammed: Jammed, factor: float) -> Jamming:
    extents = [(each.bounds[1] - each.bounds[0]).tolist() for each in (asked, fitted)]
    (ax, ay, az), (x, y, z) = extents
    slack = 0.0 if adjusted == "container" else float(cube(np.array([jammed.factor]))[0]) - 1.0
    return Jamming(
        adjusted=adjusted,
        factor=factor,
        extent_asked=(ax, ay, az),
        extent=(x, y, z),
        slack=slack,
        certificate=jammed.certificate,
        proven=jammed.proven,
        contacts=jammed.contacts,
        isostatic_excess=jammed.excess,
        rattlers=1.0 - float(jammed.held.mean()),
        force_residual=jammed.residual,
        overlap_max=jammed.overlap,
        gap_max=jammed.gap,
        pressure=jammed.pressure,
        programmes=jammed.programmes,
    )
