"""Scenes of the benchmark of clumps, and LAMMPS' verdict on their beds."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

from columns import DENSITY, YOUNGS_MODULUS, sphere_volume

from exporters import lammps
from packgen.bed import Bed
from packgen.validation import Limits, SolverReport, validate

RADIUS = 0.005  # m, of the sphere of a clump's volume
WIDE, NARROW = 12.0, 6.0  # radii of cylinders, in diameters of that sphere
LOOSEST = 0.3  # solid fraction that any bed reaches: what heights are chosen by
ACROSS = 10.0  # sides of the periodic box, in diameters of that sphere
SPACING = 0.2  # of the spheres of a rod, in their diameters: its waist is 1 % narrower

Shape = dict[str, Any]


def rod(aspect: float) -> Shape:
    """Return a rod with round ends of an aspect: its length over its width."""
    count = 1 + max(2, math.ceil((aspect - 1.0) / SPACING))
    return {"rod": {"radius": 0.0025, "length": 0.005 * aspect}, "spheres": count}


def pair(aspect: float) -> Shape:
    """Return two equal spheres, together as long as an aspect times their diameter."""
    return {"dumbbell": {"radius": 0.005, "distance": 0.01 * (aspect - 1.0)}, "spheres": 2}


TIMED: dict[str, Shape] = {
    "rod of 3": {"rod": {"radius": 0.0025, "length": 0.012}, "spheres": 3},
    "rod of 8": {"rod": {"radius": 0.0025, "length": 0.015}, "spheres": 8},
    "ellipsoid of 20": {"ellipsoid": {"x": 0.012, "y": 0.01, "z": 0.008}, "spheres": 20},
}
JUDGED: dict[str, Shape] = {
    "dimer": pair(1.8),
    "rod": {"rod": {"radius": 0.0025, "length": 0.015}, "spheres": 6},
    "tetrapod": {"tetrapod": {"radius": 0.003, "arm": 0.008}, "spheres": 5},
    "ellipsoid": {"ellipsoid": {"x": 0.012, "y": 0.01, "z": 0.008}, "spheres": 8},
    "ring": {"ring": {"radius": 0.0035, "thickness": 0.003}, "spheres": 8},
}
NOTES = (
    "Speed: processor time of one thread, of packing alone; the column's by the same clock, in the same run.",
    "Curve: boxes that wrap around sideways, 10 equivalent diameters wide. Published, of particles without",
    "friction: spheres 0.64; rods at most 0.721 at aspect 1.45 (Imaz Gonzalez and Cinacchi, J. Phys. Chem. B",
    "127 (2023) 6814), by theory 0.731, and pairs 0.707 (Baule et al., Nat. Commun. 4 (2013) 2194); pairs",
    "poured in LAMMPS are densest at aspect 1.4 to 1.5 (Kurban and Baule, Soft Matter 17 (2021) 8877).",
    "Rods of aspect 4 and 5 without friction come out looser than with it: an open fault of tall beds.",
    "Gravity: 20 free-fall times, or until still. Elastic part: what the overlaps at the end account for.",
    "LAMMPS, trimmed: poured by LAMMPS from apart until still; each clump thinner until none overlaps.",
)


def body_count(bed: Bed) -> int:
    """Return the number of particles of a bed."""
    return bed.count if bed.bodies is None else len(bed.bodies)


def sphere_count(bed: Bed) -> int:
    """Return the number of spheres of each particle of a bed."""
    return bed.count // body_count(bed)


def _set(shape: Shape | None) -> dict[str, Any]:
    known = {"radius_distribution": "constant", "radius": RADIUS, "density": DENSITY, "material": "ore"}
    return known if shape is None else {**known, "shape": shape}


def _document(container: dict[str, Any], shape: Shape | None, count: int, seed: int, friction: float) -> Any:
    return {
        "container": container,
        "seed": seed,
        "particle_sets": [_set(shape)],
        "materials": {"ore": {"youngs_modulus": YOUNGS_MODULUS, "friction": friction}},
        "zones": [{"n_particles": count}],
    }


def in_cylinder(shape: Shape, count: int, seed: int, wide: float = WIDE) -> Any:
    """Return the scene of a number of clumps in a cylinder that is higher than they need."""
    radius = 2.0 * RADIUS * wide
    height = count * sphere_volume(RADIUS) / (LOOSEST * math.pi * radius**2) + 20.0 * RADIUS
    return _document({"cylinder": {"radius": radius, "height": height}}, shape, count, seed, 0.5)


def in_periodic_box(shape: str, aspect: float, friction: float, count: int, seed: int) -> Any:
    """Return the scene of a number of rods or pairs in a box that wraps around sideways."""
    side = 2.0 * RADIUS * ACROSS
    height = count * sphere_volume(RADIUS) / (LOOSEST * side**2) + 20.0 * RADIUS
    container = {"box": {"min": [0, 0, 0], "max": [side, side, height]}, "periodic": ["x", "y"]}
    made = None if aspect == 1.0 else {"rod": rod, "pair": pair}[shape](aspect)
    return _document(container, made, count, seed, friction)


def judge(bed: Bed) -> SolverReport:
    """Return what LAMMPS measures of a bed in a gravity run."""
    limits = Limits(work_budget=1.0e18, silence_max=3600.0)
    with tempfile.TemporaryDirectory(prefix="packgen_") as scratch:
        lammps.write(bed, Path(scratch), lammps.Options())
        return validate(bed, Path(scratch), solver="lammps", limits=limits)
