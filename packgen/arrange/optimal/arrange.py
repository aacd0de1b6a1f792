"""OPTIMAL: which of a zone's spheres, and where, fill a convex container best; the best of many starts."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from packgen.arrange.optimal import proof
from packgen.arrange.optimal.bounds import Bound, scale_bound
from packgen.arrange.optimal.chain import Improved, chain
from packgen.arrange.optimal.choose import Chosen, search, volume_bound
from packgen.arrange.optimal.descend import Placed
from packgen.arrange.optimal.room import Room
from packgen.arrange.spheres import Spheres
from packgen.arrange.starts import results_in_order
from packgen.arrange.task import Outcome, Progress, Task, ZoneTask
from packgen.arrays import Float64Array, Int64Array
from packgen.cores import free_cores
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.geometry import Box
from packgen.portable import cube, matrix_product
from packgen.search import Search
from packgen.stopping import answer
from packgen.supply.supply import Draw

SPHERES_MAX = 200
"""Most spheres: with more, no start comes near the best."""

SAME = 1.0e-9
"""Share by which factors differ of one and the same arrangement."""

CLOSED = 1.0e-9
"""Share by which a bound is above what it proves."""


@dataclass(frozen=True, eq=False, slots=True)
class _Found:
    """What a search led to.

    Attributes:
        placed: The arrangement.
        radius: Radii of its spheres, as drawn [m], shape (n,).
        starts: Starts, or tries, that were made.
        hits: Those that led to it.
        programmes: Linear programmes solved.
        ended: ``done``, ``time_limit`` or ``stopped``.
    """

    placed: Placed
    radius: Float64Array
    starts: int
    hits: int
    programmes: int
    ended: str


def arrange(task: Task) -> Outcome:
    """Fill a task's container by its one zone's spheres as well as can be.

    Raises:
        PackingError: The task has several zones, or asks for what this algorithm cannot keep.
    """
    zone = task.zones[0]
    _refuse(task, zone)
    room = Room.of(task.container)
    if room is None:
        raise PackingError(
            f"{zone.place}: found a container with a curved or inner wall, or that wraps around, expected "
            "a box, a sphere or a convex mesh; OPTIMAL knows no others"
        )
    draw = zone.supply.take(zone.supply.remaining or 0)
    # Falling sizes, equal ones in their order: the spheres of a set of sizes are its first ones.
    order = np.argsort(-draw.radius, kind="stable")
    if task.settings.maximize == "scale":
        return _scaled(task, zone, room, draw, order)
    return _chosen(task, zone, room, draw, order)


def _refuse(task: Task, zone: ZoneTask) -> None:
    """Refuse what has no best arrangement.

    Raises:
        PackingError: See ``arrange``.
    """
    if len(task.zones) > 1:
        raise PackingError(
            f"{task.zones[1].place}: found {len(task.zones)} zones, expected one: OPTIMAL looks at all "
            "spheres together; give their shares by `set_proportions`"
        )
    if zone.locations:
        raise PackingError(
            f"{zone.place}: found a location, expected none: OPTIMAL fills the whole container; make the "
            "location the container"
        )
    if zone.supply.asked is None:
        raise PackingError(
            f"{zone.place}: found no amount, expected the number of spheres to look at; give `n_particles`, "
            "or a file of radii"
        )
    if zone.supply.asked > SPHERES_MAX:
        raise PackingError(
            f"{zone.place}: found {zone.supply.asked:,} spheres, expected at most {SPHERES_MAX}: of more, no "
            "search comes near the best; take `algorithm: JAMMED`"
        )
    if task.settings.proof is True and not proof.is_installed():
        raise PackingError(
            f"{zone.place}: found proof: true without the package pyscipopt, expected it; {proof.INSTALL}"
        )


def _scaled(task: Task, zone: ZoneTask, room: Room, draw: Draw, order: Int64Array) -> Outcome:
    """Place all spheres, their radii times the largest common factor."""
    began = time.time()
    radius = draw.radius[order]
    is_box = isinstance(task.container.shape, Box)
    bound = scale_bound(room, radius, is_box=is_box)
    found = _best_scale(task, zone, room, radius, bound)
    closed = bound.value <= found.placed.factor * (1.0 + CLOSED)
    proven = None
    if not closed and _wants_proof(task, len(radius)) and found.ended != "stopped":
        task.on_progress(Progress("proof", 0, None, 1, 1.0, 0))
        seconds = task.settings.time_limit - (time.time() - began)
        reached = found.placed.factor
        proven = proof.prove_scale(room, radius, reached, bound.value, seconds, is_box=is_box)
        if proven.bound < bound.value:
            bound = Bound(proven.bound, f"branch and bound, {proven.nodes:,} nodes")
    factor = found.placed.factor
    gap = max(bound.value / factor - 1.0, 0.0)
    solid = float((UNIT_VOLUME * cube(radius * factor)).sum())
    search = Search(
        "scale", factor, solid / room.volume, bound.value, bound.reason, gap,
        closed or (proven is not None and proven.finished and gap <= 2.0 * proof.RELATIVE),
        found.starts, found.hits, found.programmes, len(radius), len(radius), found.ended,
    )  # fmt: skip
    spheres = _spheres(zone, draw, order, found.placed.center, factor)
    return Outcome(spheres, task.container, search=search)


def _best_scale(task: Task, zone: ZoneTask, room: Room, radius: Float64Array, bound: Bound) -> _Found:
    settings = task.settings
    until = time.time() + settings.time_limit
    seeds = zone.seed.spawn(settings.starts)
    calls = [(room, radius, number, seed, until) for number, seed in enumerate(seeds)]
    best: Improved | None = None
    factors: list[float] = []
    programmes, ended = 0, "done"
    try:
        for result in results_in_order(chain, calls, task.threads or free_cores()):
            factors.append(result.placed.factor)
            programmes += result.programmes
            if best is None or result.placed.factor > best.placed.factor * (1.0 + SAME):
                best = result
            top = best.placed.factor
            stage = f"start {len(factors)}, largest factor {top:.9g}, bound {bound.value:.6g}"
            share = 1.0 - (until - time.time()) / settings.time_limit
            task.on_progress(Progress(stage, 0, None, 1, min(max(share, 0.0), 1.0), 0))
            if _hits(factors, top) >= settings.agree or bound.value <= top * (1.0 + CLOSED):
                break
            if time.time() > until:
                ended = "time_limit"
                break
    except KeyboardInterrupt:
        if best is None:
            raise
        answer()  # what was found is kept, and written
        ended = "stopped"
    assert best is not None
    hits = _hits(factors, best.placed.factor)
    return _Found(best.placed, radius, len(factors), hits, programmes, ended)


def _hits(factors: list[float], top: float) -> int:
    return sum(each >= top * (1.0 - SAME) for each in factors)


def _chosen(task: Task, zone: ZoneTask, room: Room, draw: Draw, order: Int64Array) -> Outcome:
    """Place the spheres of the set of largest volume."""
    began, settings = time.time(), task.settings
    radius = draw.radius[order]
    size, first, number = np.unique(-radius, return_index=True, return_counts=True)
    size = -size
    bound, volume = volume_bound(room, size, number), UNIT_VOLUME * cube(size)
    until, ended = began + settings.time_limit, "done"
    best: Chosen | None = None

    def tell(here: Chosen) -> None:
        reached = float(matrix_product(here.numbers, volume))
        stage = f"try {here.tries}, {int(here.numbers.sum())} spheres, largest volume {reached:.9g} m3"
        share = (time.time() - began) / settings.time_limit
        task.on_progress(Progress(stage, 0, None, 1, min(max(share, 0.0), 1.0), 0))

    try:
        for best in search(room, size, number, zone.seed, until, 3 * settings.agree, tell):
            if float(matrix_product(best.numbers, volume)) >= bound.value * (1.0 - CLOSED):
                break
        if time.time() > until:
            ended = "time_limit"
    except KeyboardInterrupt:
        if best is None:
            raise
        answer()  # what was found is kept, and written
        ended = "stopped"
    if best is None or not best.numbers.any():
        raise PackingError(
            f"{zone.place}: not one sphere fits (smallest radius {radius.min():.4g} m); expected a larger "
            "container or smaller spheres"
        )
    value = float(matrix_product(best.numbers, volume))
    proven = bound.value <= value * (1.0 + CLOSED)
    if not proven and _wants_proof(task, len(radius)) and ended != "stopped":
        task.on_progress(Progress("proof", 0, None, 1, 1.0, 0))
        seconds = settings.time_limit - (time.time() - began)
        is_box = isinstance(task.container.shape, Box)
        found = proof.prove_volume(room, radius, value / UNIT_VOLUME, seconds, is_box=is_box)
        if found.bound * UNIT_VOLUME < bound.value:
            bound = Bound(found.bound * UNIT_VOLUME, f"branch and bound, {found.nodes:,} nodes")
        proven = found.finished and bound.value <= value * (1.0 + 2.0 * proof.RELATIVE)
    kept = np.concatenate([order[at : at + count] for at, count in zip(first, best.numbers, strict=True)])
    search_told = Search(
        "volume", value, value / room.volume, bound.value, bound.reason, max(bound.value / value - 1.0, 0.0),
        proven, best.tries, best.hits, best.programmes, len(kept), len(radius), ended,
    )  # fmt: skip
    zone.supply.offered()
    return Outcome(_spheres(zone, draw, kept, best.placed.center, 1.0), task.container, search=search_told)


def _wants_proof(task: Task, count: int) -> bool:
    wish = task.settings.proof
    return bool(wish) if wish != "auto" else count <= proof.SPHERES_MAX and proof.is_installed()


def _spheres(zone: ZoneTask, draw: Draw, order: Int64Array, center: Float64Array, factor: float) -> Spheres:
    nothing = np.zeros(len(order), np.int32)
    body_index = None if draw.body_index is None else draw.body_index[order]
    return Spheres(
        center, draw.radius[order] * factor, draw.set_index[order], nothing + np.int32(zone.index), nothing,
        body_index,
    )  # fmt: skip
