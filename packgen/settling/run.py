"""What a settling run is told, what it keeps while it goes on, and what it leaves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.validation.still import Looks, free_fall_time, look_steps, looks_of, speed_unit

STILL_SPEED = 1.0e-4  # mean speed below which a bed counts as still [sqrt(g r)]
TIMES_MAX = 400.0  # most free-fall times until a bed is still; after that it counts as one that never is
SILENCE_MAX = 3600.0  # seconds
RUN_MAX = 1.0e9  # seconds; the run has a bound of its own in steps

Tell = Callable[[str, float], None]


@dataclass(frozen=True, eq=False, slots=True)
class Left:
    """What a run leaves.

    Attributes:
        index: Spheres that are left, as indices in the bed, shape (M,).
        position: Where they are, not wrapped around [m], shape (M, 3).
        steps: Steps that were run.
        time: Time that passed [s].
        speed: Mean speed in the end, in sqrt(g r).
        still: Whether the bed was still.
        version: What the solver calls itself; empty where it did not say.
        restart: The solver's own state; None where there is none.
    """

    index: Int64Array
    position: Float64Array
    steps: int = 0
    time: float = 0.0
    speed: float = 0.0
    still: bool = False
    version: str = ""
    restart: Path | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Settled:
    """A bed that a solver has settled; see `packgen.settlement.Settling` for what it does not say here.

    Attributes:
        bed: The bed, with the solver's positions.
        restart: The solver's own state, where the run has left it; None where it has not.
    """

    bed: Bed
    solver: str
    version: str
    time: float
    steps: int
    free_fall_times: float
    speed: float
    still: bool
    interrupted: bool
    displacement_mean: float
    displacement_max: float
    restart: Path | None


class Kept:
    """What there is of a run before its end; a solver's module says how it is read.

    Args:
        bed: The bed.
    """

    def __init__(self, bed: Bed) -> None:
        self._bed = bed
        self.read: Callable[[], Left | None] = lambda: None

    def latest(self) -> Left:
        """Return what was kept last; the bed as it was where nothing was."""
        return self.read() or self.unmoved()

    def unmoved(self) -> Left:
        """Return the bed as it was."""
        return Left(np.arange(self._bed.count), self._bed.position)


@dataclass(frozen=True, eq=False, slots=True)
class Order:
    """What a run is told.

    Attributes:
        bed: The bed.
        folder: Its deck, which the run writes into.
        time: How long [s]; None: until the bed is still.
        tell: Told of the progress.
        kept: What there is of the run before its end.
    """

    bed: Bed
    folder: Path
    time: float | None
    tell: Tell
    kept: Kept = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "kept", Kept(self.bed))

    def looks(self, timestep: float) -> Looks:
        """Return when the run is looked at, given its time step [s]."""
        time = TIMES_MAX * free_fall_time(self.bed) if self.time is None else self.time
        return looks_of(
            self.bed, timestep=timestep, steps=max(1, math.ceil(time / timestep)),
            every=look_steps(self.bed, timestep), share=STILL_SPEED if self.time is None else 0.0,
        )  # fmt: skip

    def progress(self, looks: Looks, timestep: float) -> Callable[[int, float], None]:
        """Return what tells how far a run is, called with the step and the mean speed [m/s].

        The share of a run until the bed is still is guessed: speeds fall by a like factor in a like time.
        """
        unit, free_fall = speed_unit(self.bed), free_fall_time(self.bed)
        fastest = done = 0.0

        def tell(step: int, speed: float) -> None:
            nonlocal fastest, done
            share = step / looks.steps
            if self.time is None and speed > 0.0:
                fastest = max(fastest, speed)
                if fastest > looks.speed:
                    fallen = math.log(fastest / speed) / math.log(fastest / looks.speed)
                    share = max(share, min(fallen, 0.99))
            done = max(done, share)
            times = step * timestep / free_fall
            self.tell(f"{times:.3g} free-fall times, mean speed {speed / unit:.1e} sqrt(g r)", done)

        return tell
