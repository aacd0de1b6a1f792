"""The interface of every arrangement algorithm: a task in, spheres out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrange.spheres import Spheres
from packgen.arrays import Float64Array
from packgen.geometry import Container, Shape, Slice

if TYPE_CHECKING:
    from packgen.supply.supply import Supply


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a run is.

    Attributes:
        stage: What is being done.
        placed: Spheres placed so far.
        total: Spheres to place; None: until full.
        batch: Number of the batch.
        height: Filled fraction of the zone's height, 0 to 1.
        thrown_back: Spheres that found no place so far and were, or will be, tried again.
    """

    stage: str
    placed: int
    total: int | None
    batch: int
    height: float
    thrown_back: int


@dataclass(frozen=True, eq=False, slots=True)
class ZoneTask:
    """A zone to fill.

    Attributes:
        index: Number of the zone.
        place: Where the scene speaks of it.
        locations: What bounds it beside the container.
        supply: Its spheres.
        friction: Coefficient of sliding friction of its smoothest spheres.
    """

    index: int
    place: str
    locations: tuple[Shape | Slice, ...]
    supply: Supply
    friction: float


@dataclass(frozen=True, eq=False, slots=True)
class Task:
    """All that an algorithm needs to know.

    Attributes:
        container: The vessel.
        zones: What to fill, in this order.
        down: Unit vector along which things fall, shape (3,), float64.
        settings: The scene's ``params``.
        rng: Source of all randomness.
        threads: Threads to use; None: the algorithm's choice.
        device: ``cpu`` or ``cuda``.
        on_progress: Called after each batch.
    """

    container: Container
    zones: tuple[ZoneTask, ...]
    down: Float64Array
    settings: Any
    rng: np.random.Generator
    threads: int | None
    device: str
    on_progress: Callable[[Progress], None]


Algorithm = Callable[[Task], Spheres]
"""Fills the zones of a task; what found no place stays in the zones' supplies."""
