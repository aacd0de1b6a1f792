"""When does nothing move any more? The same rule for every run of a solver, and its form for two of them.

A bed is still once the mean speed of its spheres has stayed below a small share of sqrt(g r), r the mean
radius, for one free-fall time sqrt(2 r / g), at every look. The mean speed bounds what is of interest, the
mean displacement: at 1e-3 sqrt(g r) that grows by 0.03 r at most in twenty more free-fall times. A largest
speed would not do: without rolling friction a single sphere on a flat floor rolls for ever.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from packgen.bed import Bed
from packgen.measure import hertz as law

CALM_TIMES = 1.0  # how long it has to last [free-fall times]
LOOKS = 4  # least looks in that time: a sphere that bounces is at rest for a moment
CALM_LINE = "packgen calm"  # and how many looks in a row the bed was still, at the end of the run

# A row a look, "step atoms ke rotation speed", at the start and at the end of each part of the run.
TABLE = """\
{energies}variable packgen_speed_each atom sqrt(vx*vx+vy*vy+vz*vz)
compute packgen_speed all reduce ave v_packgen_speed_each
thermo_style custom step atoms {words} c_packgen_speed
thermo_modify lost ignore norm no format float %.12g
thermo {every}
"""
OF_SPHERES = ("compute packgen_rotation all erotate/sphere\n", "ke c_packgen_rotation")
OF_CLUMPS = ("", "v_motion v_rotation")
"""Energies of a deck that tells those of its clumps itself: LAMMPS' "ke" stops where all are in clumps."""
# What follows "next" is skipped once there is no part left.
LOOP = """\
variable packgen_mean_speed equal c_packgen_speed
variable packgen_calm equal 0
variable packgen_part loop {parts}
run {first} post no
label packgen_loop
if "${{packgen_mean_speed}} < {speed}" then "variable packgen_calm equal ${{packgen_calm}}+1" &
  else "variable packgen_calm equal 0"
{each}if "${{packgen_calm}} >= {calm}" then "jump SELF packgen_end"
next packgen_part
jump SELF packgen_more
jump SELF packgen_end
label packgen_more
run {every} pre no post no
jump SELF packgen_loop
label packgen_end
print "{line} ${{packgen_calm}}"
"""


@dataclass(frozen=True, slots=True)
class Looks:
    """How a run is looked at while it goes on.

    Attributes:
        steps: Steps of the whole run, if the bed never is still.
        every: Steps from one look to the next.
        calm: Looks in a row at a still bed that end the run.
        speed: Mean speed below which it is still [m/s]; 0: it never is.
    """

    steps: int
    every: int
    calm: int
    speed: float

    @property
    def parts(self) -> int:
        """Number of looks, if the bed never is still; the first comes after what the others leave over."""
        return max(1, self.steps // self.every)

    @property
    def first(self) -> int:
        """Steps before the first look."""
        return self.steps - self.every * (self.parts - 1)


def free_fall_time(bed: Bed) -> float:
    """Return the time of free fall over a mean radius, sqrt(2 r / g) [s]; without gravity at Earth's g."""
    return math.sqrt(2.0 * law.mean_radius(bed) / law.gravity_strength(bed))


def speed_unit(bed: Bed) -> float:
    """Return sqrt(g r), r the mean radius, in which mean speeds are told [m/s]."""
    return math.sqrt(law.gravity_strength(bed) * law.mean_radius(bed))


def look_steps(bed: Bed, timestep: float) -> int:
    """Return the most steps from one look to the next, given the time step [s]."""
    return max(1, int(CALM_TIMES * free_fall_time(bed) / LOOKS / timestep))


def looks_of(bed: Bed, *, timestep: float, steps: int, every: int, share: float) -> Looks:
    """Return when a run is looked at.

    Args:
        bed: The bed.
        timestep: Time step [s].
        steps: Steps of the whole run, if the bed never is still.
        every: Steps from one look to the next, where that is often enough to tell whether it is still.
        share: Mean speed below which it is still, as a share of sqrt(g r); 0: it never is.
    """
    every = max(1, min(every, look_steps(bed, timestep)))
    calm = math.ceil(CALM_TIMES * free_fall_time(bed) / (every * timestep))
    return Looks(steps, every, calm, share * speed_unit(bed))


def loop_input(looks: Looks, *, deck: str = "", before: str = "", each: str = "") -> str:
    """Return the lines of LIGGGHTS and LAMMPS that run in parts until the bed is still.

    Speeds have the same numbers in every unit of length, see ``exporters.shared.lengths``.

    Args:
        looks: When it is looked at.
        deck: The text of the deck, which says whether it tells its energies itself.
        before: Lines between the table and the run, each with its end.
        each: More lines for each look, likewise.
    """
    energies, words = OF_CLUMPS if "\nvariable motion equal " in deck else OF_SPHERES
    return (
        TABLE.format(every=looks.every, energies=energies, words=words)
        + before
        + LOOP.format(
            parts=looks.parts, first=looks.first, every=looks.every, speed=repr(looks.speed),
            calm=looks.calm, each=each, line=CALM_LINE,
        )
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Look:
    """What a row of the table says: the step, spheres left, kinetic energy [its unit], mean speed [m/s]."""

    step: int
    count: int
    energy: float
    speed: float


def look_of(line: str) -> Look | None:
    """Return what a row of the table says; None for any other line."""
    words = line.split()
    if len(words) != 5 or not words[0].isdigit():
        return None
    try:
        step, count, energy, rotation, speed = (float(word) for word in words)
    except ValueError:
        return None
    return Look(int(step), int(count), energy + rotation, speed)


def was_still(output: Sequence[str], looks: Looks) -> bool:
    """Return whether what a solver printed says that the bed was still in the end."""
    calm = [line.split()[-1] for line in output if line.startswith(CALM_LINE)]
    return bool(calm) and calm[-1].isdigit() and int(calm[-1]) >= looks.calm
