"""LIGGGHTS as a judge: the written deck, included unedited, with measurements added behind it.

``-var setup_only 1`` ends the deck's ``in.bed`` before its own run. What is added is the computes and dumps
of the contacts, or of the positions, and ``run``. Sphere ids are the indices in the bed plus one; dumps are
not sorted.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.errors import SolverError
from packgen.validation import law
from packgen.validation.dump import read_dump
from packgen.validation.measure import (
    Contacts,
    Trajectory,
    check_loaded,
    gravity_run,
    step_zero,
    steps_wanted,
)
from packgen.validation.process import describe_output, find_solver, run_solver
from packgen.validation.results import Limits, SolverReport

NAME = "liggghts"
SAMPLES = 200  # of the kinetic energy
START_SECONDS = 600.0  # in which the largest bed is loaded and its first step done
SPHERE_STEPS_A_SECOND = 2.0e4  # far below any machine's; slower than that is a hang
STEP_ZERO_INPUT = "in.packgen_step_zero"
GRAVITY_INPUT = "in.packgen_gravity"

STEP_ZERO = """\
include in.bed
{contacts}
dump packgen_spheres all custom 1 packgen_spheres.dump id xu yu zu radius fx fy fz
dump_modify packgen_spheres format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
variable packgen_timestep equal dt
print "packgen timestep ${{packgen_timestep}}"
run 0
"""
CONTACTS = """\
compute packgen_{kind} all {style} id force delta
dump packgen_{kind} all local 1 packgen_{kind}.dump {columns}
dump_modify packgen_{kind} format "%.0f %.0f %.0f %.15g %.15g %.15g %.15g"
"""
GRAVITY = """\
include in.bed
compute packgen_rotation all erotate/sphere
thermo_style custom step atoms ke c_packgen_rotation
thermo_modify lost ignore norm no format float %.12g
thermo {every}
dump packgen_end all custom {steps} packgen_end_*.dump id xu yu zu
dump_modify packgen_end format "%d %.17g %.17g %.17g"
run {steps}
"""


def measure(
    bed: Bed, folder: Path, limits: Limits, on_progress: Callable[[str, float], None] | None
) -> SolverReport:
    """Run both measurements in ``folder``, a copy of the deck that may be written to.

    Raises:
        SolverError: LIGGGHTS is missing, or does not run the deck to the end.
    """
    notify = on_progress or (lambda _stage, _share: None)
    notify("step 0", 0.0)
    output, spheres, pairs, walls = _run_step_zero(bed, folder, limits)
    zero = step_zero(bed, pairs, walls, _wall_force(bed, spheres, folder))
    timestep = _printed_number(output, "packgen timestep")
    try:
        run = _run_gravity(bed, folder, limits, timestep, lambda share: notify("gravity run", share))
    except SolverError as error:  # a bed that is no bed can end LIGGGHTS: say what step 0 knew of it
        raise SolverError(f"{error}\nin the gravity run of a bed with, at step 0: {zero}") from error
    version = re.search(r"LIGGGHTS-\S+ [\d.]+", "\n".join(output))
    return SolverReport(
        solver=NAME,
        version=version.group() if version else "unknown",
        sphere_count=bed.count,
        step_zero=zero,
        gravity_run=gravity_run(bed, spheres[:, 1:4], run),
        limits=limits,
    )


def _run_step_zero(
    bed: Bed, folder: Path, limits: Limits
) -> tuple[tuple[str, ...], Float64Array, Contacts, Contacts | None]:
    """Return output, spheres by id (N, 8), contacts of pairs, and contacts of mesh walls if there are any."""
    kinds = {"pairs": "pair/gran/local"}
    # The other compute knows mesh walls only, and stops LIGGGHTS where there are none.
    if re.search(r"^\s*fix\b.*\bwall/gran\b.*\bn_meshes\b", _deck_text(folder), re.MULTILINE):
        kinds["walls"] = "wall/gran/local"
    text = STEP_ZERO.format(contacts="".join(_contact_dump(kind, style) for kind, style in kinds.items()))
    output = _run(folder, STEP_ZERO_INPUT, text, limits, START_SECONDS, None)
    try:
        spheres = read_dump(folder / "packgen_spheres.dump", 8)
        pair_rows = read_dump(folder / "packgen_pairs.dump", 7)
        wall_rows = read_dump(folder / "packgen_walls.dump", 7) if "walls" in kinds else None
    except SolverError as error:
        raise SolverError(f"{NAME}: {error}; it said:\n{describe_output(output)}") from error
    spheres = spheres[np.argsort(spheres[:, 0], kind="stable")]
    if not np.array_equal(spheres[:, 0], np.arange(1, bed.count + 1)):
        raise SolverError(f"{NAME}: loaded {len(spheres)} spheres, expected ids 1 to {bed.count}")
    check_loaded(bed, NAME, spheres[:, 1:4], spheres[:, 4])
    pairs = _contacts(pair_rows, 0, 1)
    walls = None if wall_rows is None else _contacts(wall_rows, 2, None)
    return output, spheres, pairs, walls


def _contact_dump(kind: str, style: str) -> str:
    columns = " ".join(f"c_packgen_{kind}[{column}]" for column in range(1, 8))
    return CONTACTS.format(kind=kind, style=style, columns=columns)


def _contacts(rows: Float64Array, first: int, second: int | None) -> Contacts:
    return Contacts(
        first=rows[:, first].astype(np.int64) - 1,
        second=None if second is None else rows[:, second].astype(np.int64) - 1,
        force=np.linalg.norm(rows[:, 3:6], axis=1),
        overlap=rows[:, 6],
    )


def _wall_force(bed: Bed, spheres: Float64Array, folder: Path) -> Float64Array:
    """Return what is left of each sphere's force [N] (N, 3) without its weight and its neighbours' pushes."""
    force: Float64Array = spheres[:, 5:8] - law.sphere_mass(bed)[:, None] * bed.gravity
    rows = read_dump(folder / "packgen_pairs.dump", 7)
    for column, sign in ((0, 1.0), (1, -1.0)):
        np.subtract.at(force, rows[:, column].astype(np.int64) - 1, sign * rows[:, 3:6])
    return force


def _run_gravity(
    bed: Bed, folder: Path, limits: Limits, timestep: float, on_share: Callable[[float], None]
) -> Trajectory:
    wanted, steps = steps_wanted(bed, limits, timestep)
    samples: list[tuple[float, float]] = []

    def on_line(line: str) -> None:
        numbers = _numbers(line)
        if numbers is not None:
            samples.append((numbers[0], numbers[2] + numbers[3]))
            on_share(numbers[0] / steps)

    text = GRAVITY.format(steps=steps, every=max(1, steps // SAMPLES))
    seconds = START_SECONDS + steps * bed.count / SPHERE_STEPS_A_SECOND
    output = _run(folder, GRAVITY_INPUT, text, limits, seconds, on_line)
    if not samples or samples[-1][0] != steps:
        raise SolverError(f"{NAME}: ended before step {steps}; it said:\n{describe_output(output)}")
    rows = read_dump(folder / f"packgen_end_{steps}.dump", 4)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return Trajectory(
        timestep=timestep,
        steps=steps,
        steps_wanted=wanted,
        index=rows[:, 0].astype(np.int64) - 1,
        position=rows[:, 1:4],
        energy=np.array([energy for _, energy in samples]),
    )


def _run(
    folder: Path, name: str, text: str, limits: Limits, seconds: float, on_line: Callable[[str], None] | None
) -> tuple[str, ...]:
    (folder / name).write_text(text, encoding="ascii")
    command = [str(find_solver(NAME)), "-in", name, "-log", "none", "-var", "setup_only", "1"]
    return run_solver(
        NAME, command, folder, silence_max=limits.silence_max, seconds_max=seconds, on_line=on_line
    )


def _deck_text(folder: Path) -> str:
    try:
        return (folder / "in.bed").read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise SolverError(f"{NAME}: the deck's input cannot be read: {error}") from error


def _numbers(line: str) -> tuple[float, float, float, float] | None:
    """Return the four numbers of a line of the run's table; None for any other line."""
    words = line.split()
    if len(words) != 4 or not words[0].isdigit():
        return None
    try:
        step, atoms, energy, rotation = (float(word) for word in words)
    except ValueError:
        return None
    return step, atoms, energy, rotation


def _printed_number(output: tuple[str, ...], label: str) -> float:
    for line in output:
        if line.startswith(label):
            try:
                number = float(line.removeprefix(label))
            except ValueError:
                break
            if number > 0:
                return number
    raise SolverError(f"{NAME}: did not tell its time step; it said:\n{describe_output(output)}")
