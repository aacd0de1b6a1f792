"""The interface of every arrangement algorithm: a task in, spheres out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrange.crew import Alone, Crew
from packgen.arrange.spheres import Spheres, no_spheres
from packgen.arrays import Float64Array
from packgen.bodies import Form
from packgen.geometry import Container, Shape, Slice
from packgen.jamming import Jamming
from packgen.search import Search

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


Listener = Callable[[Progress], None]
"""Called with the progress of a run after each batch."""


Sink = Callable[[Spheres], None]
"""Takes spheres at rest; they come in an order that does not depend on who has arranged them."""


def no_listener(_progress: Progress) -> None:
    """Listen to nothing."""


@dataclass(frozen=True, eq=False, slots=True)
class Setting:
    """What all zones of a task share; plain data that can be sent to another process.

    Attributes:
        container: The vessel.
        down: Unit vector along which things fall, shape (3,), float64.
        settings: The scene's ``params`` as the algorithm's own ``Params``; a mapping where it has none.
        threads: Threads that the algorithm may use; None: its own choice. ``projection`` arranges each layer
            with them, by default with as many as cores are free; ``adam`` gives them to torch, one by
            default. The bed does not depend on it.
        device: ``cpu`` or ``cuda``.
    """

    container: Container
    down: Float64Array
    settings: Any
    threads: int | None = None
    device: str = "cpu"


@dataclass(frozen=True, slots=True)
class Gap:
    """The least distance between surfaces.

    Attributes:
        radii: In radii: of the mean radius of two spheres, at a wall of the sphere's own.
        length: In metres; adds to that.
    """

    radii: float = 0.0
    length: float = 0.0

    def half(self, radius: Float64Array) -> Float64Array:
        """Return what centres keep from each other: the sum of these is their least distance [m], (N,)."""
        return np.asarray(radius * (1.0 + 0.5 * self.radii) + 0.5 * self.length)

    def wall(self, radius: Float64Array) -> Float64Array:
        """Return the least distance of each centre from a wall [m], shape (N,)."""
        return np.asarray(radius * (1.0 + self.radii) + self.length)


@dataclass(frozen=True, eq=False, slots=True)
class ZoneTask:
    """A zone to fill; plain data that can be sent to another process.

    Attributes:
        index: Number of the zone.
        place: Where the scene defines it.
        locations: What bounds it beside the container.
        supply: Its spheres.
        friction: Coefficient of sliding friction of its smoothest spheres.
        seed: Seed of the zone's own randomness.
        setting: What it shares with the other zones.
        gap: Least distance between surfaces; only of algorithms that keep one.
        core_fraction: Solid fraction that its core would have with equal spheres; only of algorithms that
            make beds looser or denser. None: friction decides.
        loose_count: How many of the spheres at rest, the first ones, may move again near the surface.
        forms: Shape of each set's particles, None: spheres; none at all: those of all sets are. The supply
            then has the spheres of the particles' volumes.
    """

    index: int
    place: str
    locations: tuple[Shape | Slice, ...]
    supply: Supply
    friction: float
    seed: np.random.SeedSequence
    setting: Setting
    gap: Gap = Gap()
    core_fraction: float | None = None
    loose_count: int = 0
    forms: tuple[Form | None, ...] = ()

    @property
    def of_clumps(self) -> bool:
        """Whether any of its particles are clumps."""
        return any(
            form is not None and share > 0.0
            for form, share in zip(self.forms, self.supply.shares, strict=bool(self.forms))
        )

    def generator(self) -> np.random.Generator:
        """Return a new source of randomness, the same one each time."""
        return np.random.default_rng(self.seed)


@dataclass(frozen=True, eq=False, slots=True)
class Task:
    """All that an algorithm needs to know.

    Attributes:
        setting: Container, direction down, settings, threads, device.
        zones: What to fill, in this order.
        rng: Source of randomness for an algorithm that fills all zones together; see ``ZoneTask.generator``.
        on_progress: Called after each batch.
        crew: Who does the work of a bed that is divided into tiles.
        sink: Takes the spheres of such a bed, some at a time, which are then not returned; None: nobody does.
        earlier: Spheres that are there before; their zones have numbers that none of ``zones`` has. They come
            first among the spheres returned, in their order.
    """

    setting: Setting
    zones: tuple[ZoneTask, ...]
    rng: np.random.Generator
    on_progress: Listener = no_listener
    crew: Crew = field(default_factory=Alone)
    sink: Sink | None = None
    earlier: Spheres = field(default_factory=no_spheres)

    @property
    def container(self) -> Container:
        """The vessel."""
        return self.setting.container

    @property
    def down(self) -> Float64Array:
        """Unit vector along which things fall, shape (3,), float64."""
        return self.setting.down

    @property
    def settings(self) -> Any:
        """The scene's ``params``."""
        return self.setting.settings

    @property
    def threads(self) -> int | None:
        """Threads that the algorithm may use; None: its own choice."""
        return self.setting.threads

    @property
    def device(self) -> str:
        """``cpu`` or ``cuda``."""
        return self.setting.device

    @property
    def sphere_count(self) -> int | None:
        """Number of spheres that all zones ask for; None: some zone is to be filled."""
        asked = [zone.supply.asked for zone in self.zones]
        return None if None in asked else sum(each or 0 for each in asked)


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """Spheres, and the container that an algorithm has fitted to them.

    Attributes:
        spheres: The spheres.
        container: The container that they are in.
        jamming: How they are jammed; None: that is not known.
        search: How they were found, by an algorithm that searches; None: it does not.
    """

    spheres: Spheres
    container: Container
    jamming: Jamming | None = None
    search: Search | None = None


Algorithm = Callable[[Task], Spheres | Outcome]
"""Fills the zones of a task; what found no place stays in the zones' supplies.

An algorithm that leaves the container as it is returns spheres alone.
"""


@dataclass(frozen=True, eq=False, slots=True)
class Filled:
    """The outcome of a zone.

    Attributes:
        spheres: Those placed in it, batches counted from 0.
        supply: Those that found no place, and where the supply goes on.
        batch_count: Batches that were tried.
        earlier: Centres of the spheres at rest [m], shape (N, 3), where some may have moved; None: none has.
    """

    spheres: Spheres
    supply: Supply
    batch_count: int
    earlier: Float64Array | None = None


FillZone = Callable[[ZoneTask, Spheres, np.random.Generator, Listener], Filled]
"""Fills a zone (its task, the spheres at rest, its randomness, a listener that hears of this zone alone).

The same arguments give the same spheres, in any process, and none of them changes but the generator.
"""


def of_whole_run(listener: Listener, placed: int, total: int | None, batch: int) -> Listener:
    """Return a listener to one zone that tells another one of the whole run.

    Args:
        listener: The listener to the run.
        placed: Spheres of earlier zones.
        total: Spheres to place in all zones; None: until full.
        batch: Batches of earlier zones.
    """

    def tell(progress: Progress) -> None:
        listener(
            replace(progress, placed=placed + progress.placed, total=total, batch=batch + progress.batch)
        )

    return tell
