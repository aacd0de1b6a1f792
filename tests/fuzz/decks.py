"""Decks loaded by their solvers for a few steps: all spheres stay, and nothing is pushed hard at step 0."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np

from tests.fuzz.generator import Case
from tests.fuzz.judge import Bed, read_bed
from tests.fuzz.solids import Array

PROGRAMS = {"liggghts": "liggghts", "lammps": "lmp", "yade": "yade"}
STEPS = 5
FORCE_MAX = 1.0  # weights of a mean sphere, beside what the tolerance and rounded walls allow
NEIGHBOURS = 12.0
DEFAULT_MODULUS = 1e8
WEIGHT_MAX = 1e-3  # a sphere's weight over its cross-section, as a share of its modulus
SINGLE = 1.2e-7  # rounding of float32, in which solvers read meshes
SECONDS = 120.0

DUMPED = """\
include in.bed
dump fuzz all custom {steps} fuzz_*.dump id x y z radius fx fy fz
dump_modify fuzz {word}"%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
thermo_modify lost error
run {steps}
"""
YADE = """\
import numpy as np
setup_only = True
exec(compile(open("bed.py").read(), "bed.py", "exec"))
newton = [each for each in O.engines if isinstance(each, NewtonIntegrator)][0]
newton.dead = True
O.step()
spheres = [O.bodies[index] for index in range({count})]
rows = [(*each.state.pos, each.shape.radius, *O.forces.f(each.id)) for each in spheres]
newton.dead = False
O.run({steps}, True)
left = sum(isinstance(each.shape, Sphere) for each in O.bodies)
np.savez("fuzz.npz", rows=np.array(rows), left=left)
"""


def installed() -> list[str]:
    """Return the solvers whose programs are on the PATH."""
    return [name for name, program in PROGRAMS.items() if shutil.which(program)]


def is_loadable(case: Case) -> bool:
    """Tell whether spheres hold their own weight: of a mountain on springs no solver makes a bed."""
    radius, density = max(law.high for law in case.laws), float(case.densities.max())
    stress = density * float(case.data.get("gravity", 9.81)) * radius
    return stress < WEIGHT_MAX * _moduli(case)[0]


def _moduli(case: Case) -> tuple[float, float]:
    """Return the smallest and the largest Young's modulus [Pa]; who names none has the default."""
    values = [each.get("youngs_modulus", DEFAULT_MODULUS) for each in case.data.get("materials", {}).values()]
    return min([*values, DEFAULT_MODULUS]), max([*values, DEFAULT_MODULUS])


def judge_deck(case: Case, solver: str) -> list[str]:
    """Let a solver load the deck in a scene's result, in a copy of its folder; return what is wrong."""
    bed, folder = read_bed(case.folder / "out" / "bed.npz"), case.folder / f"run_{solver}"
    shutil.copytree(case.folder / "out" / solver, folder)
    command = {"liggghts": ["liggghts", "-in", "fuzz.in", "-log", "none", "-var", "setup_only", "1"],
               "lammps": ["lmp", "-in", "fuzz.in", "-log", "none", "-var", "setup_only", "1"],
               "yade": ["yade", "-n", "-x", "-j1", "fuzz.py"]}[solver]  # fmt: skip
    word = "format " if solver == "liggghts" else "format line "
    (folder / "fuzz.in").write_text(DUMPED.format(steps=STEPS, word=word), encoding="ascii")
    (folder / "fuzz.py").write_text(YADE.format(steps=STEPS, count=len(bed.radius)), encoding="ascii")
    try:
        done = subprocess.run(["stdbuf", "-oL", *command], cwd=folder, capture_output=True, timeout=SECONDS,
                              stdin=subprocess.DEVNULL, check=False)  # fmt: skip
    except subprocess.TimeoutExpired:
        return [f"{solver}: not done after {SECONDS:g} s"]
    said = (done.stdout + done.stderr).decode(errors="replace")
    if done.returncode or "ERROR" in said:
        lines = [line for line in said.splitlines() if "ERROR" in line or "Error" in line]
        return [f"{solver}: exit code {done.returncode}: {(lines or said.splitlines()[-1:])[:2]}"]
    rows, left = _yade_rows(folder) if solver == "yade" else _dumped_rows(folder)
    return [f"{solver}: {each}" for each in judge_rows(case, bed, rows, left)]


def _dumped_rows(folder: Path) -> tuple[Array, int]:
    rows = np.loadtxt(folder / "fuzz_0.dump", skiprows=9, ndmin=2)
    left = len(np.loadtxt(folder / f"fuzz_{STEPS}.dump", skiprows=9, ndmin=2))
    unit = _length_unit((folder / "in.bed").read_text(encoding="utf-8"))
    rows = rows[np.argsort(rows[:, 0])][:, 1:]
    # Moduli keep their numbers: forces go with the square of the unit of length.
    return rows * np.array([unit] * 4 + [unit * unit] * 3), left


def _length_unit(deck: str) -> float:
    """Return the unit of length that a deck states [m]; metres where it states none."""
    stated = [line.split() for line in deck.splitlines() if line.startswith("variable length_unit ")]
    return float(stated[0][-1]) if stated else 1.0


def _yade_rows(folder: Path) -> tuple[Array, int]:
    with np.load(folder / "fuzz.npz") as file:
        return file["rows"], int(file["left"])


def judge_rows(case: Case, bed: Bed, rows: Array, left: int) -> list[str]:
    """Return what is wrong with rows of position, radius and force (N, 7) at step 0."""
    if len(rows) != len(bed.radius) or left != len(bed.radius):
        return [f"{len(rows)} spheres at step 0, {left} at step {STEPS}, the bed has {len(bed.radius)}"]
    faults = []
    near = 1e-9 * float(np.abs(case.container.bounds).max())
    same = np.allclose(rows[:, :3], bed.position, rtol=0.0, atol=near)
    if not (same and np.allclose(rows[:, 3], bed.radius)):
        faults.append("its spheres are not those of bed.npz")
    gravity = float(case.data.get("gravity", 9.81))
    mass = 4.0 / 3.0 * np.pi * bed.radius**3 * case.densities[bed.set_index]
    force = np.linalg.norm(rows[:, 4:], axis=1) - 1.001 * gravity * mass
    worst = int(force.argmax())
    limit = FORCE_MAX * gravity * float(mass.mean()) + _allowed_force(case, bed)
    if case.tolerance is not None and force[worst] > limit:
        faults.append(
            f"sphere {worst} is pushed with {force[worst] / gravity / mass.mean():.3g} mean weights "
            f"at step 0, allowed {limit / gravity / mass.mean():.3g}"
        )
    return faults


def _allowed_force(case: Case, bed: Bed) -> float:
    """Return what overlaps of the tolerance and rounded walls may push by Hertz' law [N]."""
    stiffest = _moduli(case)[1]
    radius = float(bed.radius.max())
    depth = (case.tolerance or 0.0) * radius + SINGLE * float(np.abs(case.container.bounds).max())
    return NEIGHBOURS * 4.0 / 3.0 * stiffest * float(np.sqrt(radius)) * depth**1.5
