"""A bed by LIGGGHTS' own means: spheres inserted at random (``fix insert/pack``), then gravity until at rest.

LIGGGHTS manual, pages "fix insert/pack" and "fix particletemplate/sphere": every seed has to be a prime above
10,000 and differ from the others. LIGGGHTS loses the message of an error when its output is no terminal,
unless lines are sent at once; ``packgen.validation.process`` sees to that.
"""

from __future__ import annotations

import math
import shutil
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from columns import DENSITY, FRICTION, column_height, sphere_volume

from packgen.arrays import Float64Array
from packgen.errors import SolverError
from packgen.validation.dump import read_dump
from packgen.validation.process import run_solver

GRAVITY = 9.81  # m/s2
INSERTED = 0.25  # solid fraction that random insertion reaches quickly
POISSONS_RATIO = 0.3
RAYLEIGH_SHARE = 0.2  # of the Rayleigh time: as long a step as LIGGGHTS' manual allows
AT_REST = 1.0e-3  # kinetic energy a sphere, in m g r
CHECKS_MAX = 100

DECK = """\
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
hard_particles yes
soft_particles yes
region box block {low} {high} {low} {high} 0 {height} units box
region room {room} 0 {height} units box
create_box 1 box
neighbor {skin} bin
neigh_modify delay 0
fix youngs_modulus all property/global youngsModulus peratomtype {modulus}
fix poissons_ratio all property/global poissonsRatio peratomtype {poisson}
fix restitution all property/global coefficientRestitution peratomtypepair 1 0.5
fix friction all property/global coefficientFriction peratomtypepair 1 {friction}
pair_style gran model hertz tangential history
pair_coeff * *
timestep {timestep}
fix gravity all gravity {gravity} vector 0 0 -1
{sides}
fix wall_z0 all wall/gran model hertz tangential history primitive type 1 zplane 0
fix wall_z1 all wall/gran model hertz tangential history primitive type 1 zplane {height}
{templates}
fix spheres all particledistribution/discrete/massbased {seeds[0]} {mixture}
fix insert all insert/pack seed {seeds[1]} distributiontemplate spheres maxattempt 500 insert_every once &
 overlapcheck yes all_in yes vel constant 0 0 0 region room particles_in_region {spheres}
fix integrate all nve/sphere
thermo_style custom step atoms ke
thermo_modify lost ignore norm no
thermo {every}
run {fall}
variable energy equal ke
variable check loop {checks}
label settle
run {every}
if "${{energy}} < {rest}" then "jump SELF settled"
next check
jump SELF settle
label settled
dump end all custom 1 end.dump id x y z radius
dump_modify end format "%d %.17g %.17g %.17g %.17g"
run 0
"""

TEMPLATE = """\
fix {name} all particletemplate/sphere {seed} atom_type 1 density constant {density} &
 radius constant {radius}"""
WALL = "fix wall_{name} all wall/gran model hertz tangential history primitive type 1 {surface}"


@dataclass(frozen=True, eq=False, slots=True)
class Poured:
    """Spheres that LIGGGHTS inserted and let settle.

    Attributes:
        position: Centres [m], shape (N, 3).
        radius: Radii [m], shape (N,).
        height: Height of the column they fell in [m].
        seconds: Wall time of LIGGGHTS [s].
    """

    position: Float64Array
    radius: Float64Array
    height: float
    seconds: float


def liggghts_installed() -> bool:
    """Return whether there is a LIGGGHTS to run."""
    return shutil.which("liggghts") is not None


def pour(
    spheres: int,
    *,
    width: float,
    radius: float,
    youngs_modulus: float,
    seed: int,
    friction: float = FRICTION,
    cylinder: bool = False,
    sizes: Sequence[tuple[float, float]] = (),
) -> Poured:
    """Let LIGGGHTS insert spheres in a column and settle them.

    Args:
        spheres: How many.
        width: Side of the square base, whose corner is the origin; or diameter of the round one, whose middle
            it is [m].
        radius: Their radius, or that of a sphere of mean volume [m].
        youngs_modulus: Young's modulus [Pa].
        seed: Chooses LIGGGHTS' seeds.
        friction: Coefficient of friction, of spheres and walls.
        cylinder: Whether the base is round.
        sizes: Radius [m] and share of the mass of each size; none: all have ``radius``.

    Raises:
        SolverError: LIGGGHTS stopped, or did not insert all spheres.
    """
    side = width * math.sqrt(math.pi / 4.0) if cylinder else width
    height = column_height(spheres, width=side, radius=radius, fraction=INSERTED) + 4.0 * radius
    with tempfile.TemporaryDirectory(prefix="packgen_") as scratch:
        folder = Path(scratch)
        mixture = tuple(sizes) or ((radius, 1.0),)
        deck = _deck(spheres, width, height, radius, youngs_modulus, seed, friction, cylinder, mixture)
        (folder / "in.pour").write_text(deck, encoding="ascii")
        start = time.perf_counter()
        command = [shutil.which("liggghts") or "liggghts", "-in", "in.pour", "-log", "none"]
        run_solver("liggghts", command, folder, silence_max=3600.0, seconds_max=86400.0)
        seconds = time.perf_counter() - start
        rows = read_dump(folder / "end.dump", 5)
    if len(rows) != spheres:
        raise SolverError(f"liggghts: {len(rows)} spheres settled, expected {spheres}")
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return Poured(rows[:, 1:4], rows[:, 4], height, seconds)


def rayleigh_time(radius: float, youngs_modulus: float) -> float:
    """Return the Rayleigh time [s] (LIGGGHTS manual, page "fix check/timestep/gran")."""
    shear = youngs_modulus / (2.0 * (1.0 + POISSONS_RATIO))
    return math.pi * radius * math.sqrt(DENSITY / shear) / (0.1631 * POISSONS_RATIO + 0.8766)


def _deck(
    spheres: int,
    width: float,
    height: float,
    radius: float,
    modulus: float,
    seed: int,
    friction: float,
    cylinder: bool,
    mixture: Sequence[tuple[float, float]],
) -> str:
    low, high = (-0.5 * width, 0.5 * width) if cylinder else (0.0, width)
    if cylinder:
        room = f"cylinder z 0 0 {high}"
        sides = [WALL.format(name="round", surface=f"zcylinder {high} 0 0")]
    else:
        room = f"block 0 {width} 0 {width}"
        sides = [
            WALL.format(name=f"{axis}{end}", surface=f"{axis}plane {place}")
            for axis in "xy"
            for end, place in enumerate((low, high))
        ]
    smallest = min(size for size, _ in mixture)
    timestep = RAYLEIGH_SHARE * rayleigh_time(smallest, modulus)
    weight = sphere_volume(radius) * DENSITY * GRAVITY
    *template_seeds, one, other = primes_above(10_000 + 100 * seed, len(mixture) + 2)
    seeds = one, other
    templates = [
        TEMPLATE.format(name=f"size{i}", seed=prime, density=DENSITY, radius=size)
        for i, (prime, (size, _)) in enumerate(zip(template_seeds, mixture, strict=True))
    ]
    return DECK.format(
        low=low,
        high=high,
        room=room,
        sides="\n".join(sides),
        friction=friction,
        height=height,
        templates="\n".join(templates),
        mixture=f"{len(mixture)} " + " ".join(f"size{i} {share}" for i, (_, share) in enumerate(mixture)),
        modulus=modulus,
        poisson=POISSONS_RATIO,
        gravity=GRAVITY,
        spheres=spheres,
        skin=0.5 * smallest,
        timestep=timestep,
        seeds=seeds,
        # Until the highest spheres are down there is nothing to wait for.
        fall=math.ceil(math.sqrt(2.0 * height / GRAVITY) / timestep),
        every=math.ceil(2.0 * math.sqrt(2.0 * radius / GRAVITY) / timestep),
        checks=CHECKS_MAX,
        rest=AT_REST * spheres * weight * radius,
    )


def primes_above(low: int, count: int) -> list[int]:
    """Return the first primes above a number."""
    found: list[int] = []
    while len(found) < count:
        low += 1
        if all(low % divisor for divisor in range(2, math.isqrt(low) + 1)):
            found.append(low)
    return found
