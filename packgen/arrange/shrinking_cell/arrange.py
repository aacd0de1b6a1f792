"""SHRINKING_CELL: random cells of a few spheres shrink until nothing can move; the densest is the bed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from packgen.arrange.shrinking_cell.shrink import (
    PeriodicCell,
    Reach,
    largest_factor,
    random_cell,
    shaken,
    shrunk,
)
from packgen.arrange.spheres import Spheres
from packgen.arrange.starts import results_of
from packgen.arrange.task import Outcome, Progress, Task
from packgen.arrays import Float64Array
from packgen.cores import free_cores
from packgen.errors import PackingError
from packgen.geometry.cells import cell_container, into_cell, upright_cell
from packgen.portable import length, matrix_product
from packgen.search import Search

SPHERES_MAX = 300
"""Most spheres of a cell: with more, a single linear programme takes minutes."""

EQUAL_BOUND = math.pi / math.sqrt(18.0)
"""Largest solid fraction of equal spheres (Hales and others, Forum Math. Pi 5 (2017) e2)."""

SAME = 1.0e-6
"""Difference of solid fractions of one and the same packing."""

ROUNDING = 1.0e-10
"""Difference of solid fractions that is rounding: of equals the first start's cell is taken."""


def arrange(task: Task) -> Outcome:
    """Find the densest periodic cell of the spheres of a task's one zone.

    Raises:
        PackingError: The task has several zones, or asks for what this algorithm cannot keep.
    """
    _refuse(task)
    zone, settings = task.zones[0], task.settings
    draw = zone.supply.take(zone.supply.remaining or 0)
    radius, reach = draw.radius, Reach(settings.phi_start, settings.influence, settings.move)
    # The cell's size in radii, so that all lengths are alike to the solver.
    unit = float(radius.max())
    calls = [
        (np.asarray(radius / unit), reach, seed)
        for seed in zone.seed.spawn(settings.starts)
    ]  # fmt: skip
    found: dict[int, PeriodicCell] = {}
    densest = 0.0
    for number, cell in results_of(cell_from, calls, task.threads or free_cores()):
        found[number] = cell
        densest = max(densest, cell.fraction)
        stage = f"start {len(found)} of {settings.starts}, densest {densest:.8f}"
        task.on_progress(Progress(stage, 0, None, 1, len(found) / settings.starts, 0))
    best = min(number for number, cell in found.items() if cell.fraction >= densest - ROUNDING)
    vectors, turn = upright_cell(found[best].vectors)
    center = into_cell(matrix_product(found[best].center, turn), vectors)
    # Turning rounds: the last digits are given back.
    give = unit / min(largest_factor(center, radius / unit, vectors), 1.0)
    container = cell_container(vectors * give)
    nothing = np.zeros(len(radius), np.int32)
    spheres = Spheres(
        center * give, radius, draw.set_index, nothing + np.int32(zone.index), nothing, draw.body_index
    )
    return Outcome(spheres, container, search=_search(found, found[best], radius, container.cell))


def cell_from(radius: Float64Array, reach: Reach, seed: np.random.SeedSequence) -> PeriodicCell:
    """Return the densest cell that a random start leads to: where it comes to rest, or once more when shaken.

    Args:
        radius: Radii [m], shape (N,).
        reach: How far the first steps go.
        seed: Seed of the start.
    """
    rng = np.random.default_rng(seed)
    first = shrunk(random_cell(radius, reach.start, rng), radius, reach)
    again = shrunk(shaken(first, radius, rng), radius, reach)
    # A gain that is rounding is none: the cell that came first stays.
    best = again if again.fraction > first.fraction + ROUNDING else first
    return replace(best, steps=first.steps + again.steps)


def _refuse(task: Task) -> None:
    """Refuse what has no densest cell.

    Raises:
        PackingError: See ``arrange``.
    """
    zone = task.zones[0]
    if len(task.zones) > 1:
        raise PackingError(
            f"{task.zones[1].place}: found {len(task.zones)} zones, expected one: SHRINKING_CELL makes one "
            "cell of all spheres; give their shares by `set_proportions`"
        )
    if zone.locations:
        raise PackingError(
            f"{zone.place}: found a location, expected none: the cell takes the shape that its spheres need; "
            "leave it out"
        )
    if zone.supply.asked is None:
        raise PackingError(
            f"{zone.place}: found no amount, expected the number of spheres in the cell; give `n_particles`"
        )
    if zone.supply.asked > SPHERES_MAX:
        raise PackingError(
            f"{zone.place}: found {zone.supply.asked:,} spheres, expected at most {SPHERES_MAX}: the densest "
            "cell of more takes too long to be found; take `algorithm: JAMMED` for a dense bed of many"
        )


def _search(
    found: dict[int, PeriodicCell], best: PeriodicCell, radius: Float64Array, vectors: Float64Array | None
) -> Search:
    equal = bool((radius == radius[0]).all())
    gap = EQUAL_BOUND / best.fraction - 1.0 if equal else None
    return Search(
        maximized="fraction",
        value=best.fraction,
        fraction=best.fraction,
        bound=EQUAL_BOUND if equal else None,
        bound_by="no packing of equal spheres is denser" if equal else "",
        gap=gap,
        proven=gap is not None and gap < ROUNDING,
        starts=len(found),
        hits=sum(cell.fraction >= best.fraction - SAME for cell in found.values()),
        programmes=sum(cell.steps for cell in found.values()),
        chosen=len(radius),
        candidates=len(radius),
        ended="done",
        cell=None if vectors is None else _edges(vectors),
    )


def _edges(vectors: Float64Array) -> tuple[float, float, float, float, float, float]:
    a, b, c = (length(each) for each in vectors)
    angles = [
        math.degrees(math.acos(max(-1.0, min(1.0, float((one * other).sum()) / length(one) / length(other)))))
        for one, other in ((vectors[1], vectors[2]), (vectors[0], vectors[2]), (vectors[0], vectors[1]))
    ]
    return a, b, c, angles[0], angles[1], angles[2]
