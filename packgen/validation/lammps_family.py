"""LIGGGHTS and LAMMPS as judges: the written deck, included unedited, with measurements added behind it.

``-var setup_only 1`` ends the deck's ``in.bed`` before its own run. What is added is the computes and dumps
of the contacts, or of the positions, and ``run``. Sphere ids are the indices in the bed plus one; dumps are
not sorted. A deck in another unit of length than metres says which, and all is told in SI. The two programs
differ in their computes of contacts and in what they tell of walls: `Dialect`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed, has_clumps
from packgen.errors import SolverError
from packgen.measure import hertz as law
from packgen.measure.particles import alone, particle_count
from packgen.validation.contacts import Contacts
from packgen.validation.dump import read_dump
from packgen.validation.measure import Trajectory, check_loaded, gravity_run, step_zero, steps_wanted
from packgen.validation.process import describe_output, find_solver, run_solver
from packgen.validation.results import Limits, SolverReport, StepZero
from packgen.validation.still import Look, look_of, looks_of, loop_input, was_still

SAMPLES = 200  # looks at the run
SPHERES_LEAST = 1500  # a smaller bed counts for as many: what a step costs beside its spheres
START_SECONDS = 600.0  # time for the largest bed to load and do its first step
SPHERE_STEPS_A_SECOND = 2.0e4  # far below any machine's; slower than that is a hang
STEP_ZERO_INPUT = "in.packgen_step_zero"
GRAVITY_INPUT = "in.packgen_gravity"

INCLUDE = "include in.bed\n"
STEP_ZERO = """\
include in.bed
{contacts}
dump packgen_spheres all custom 1 packgen_spheres.dump id xu yu zu radius fx fy fz
dump_modify packgen_spheres format {line}"%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
variable packgen_timestep equal dt
print "packgen timestep ${{packgen_timestep}}"
run 0
"""
END = """\
dump packgen_end all custom 1 packgen_end.dump id xu yu zu
dump_modify packgen_end format {line}"%d %.17g %.17g %.17g"
run 0 post no
"""

FirstForces = tuple[Contacts, Contacts, float]
"""Contacts of pairs, contacts with walls, and how far the forces of the walls are off Hertz' law."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """How the two programs differ.

    Attributes:
        name: The solver.
        format_word: What stands before the format of a dump of spheres.
        version: Pattern of what it calls itself.
        contact_input: Returns the lines that dump the contacts of the deck with this text.
        read_contacts: Returns the contacts at step 0 from the dumps in a folder; arguments: the bed, the
            folder, the forces on the spheres without their weight [N], shape (N, 3), and the deck's unit of
            length [m].
        budget_share: Returns the share of the work budget that the gravity run of a bed gets: what a step of
            LIGGGHTS costs, as a fraction of what this solver's costs.
        weighs_members: Whether gravity acts on the spheres of clumps, and not on the clumps as such.
    """

    name: str
    format_word: str
    version: str
    contact_input: Callable[[str], str]
    read_contacts: Callable[[Bed, Path, Float64Array, float], FirstForces]
    budget_share: Callable[[Bed], float] = lambda _bed: 1.0
    weighs_members: bool = True


def measure(
    dialect: Dialect,
    bed: Bed,
    folder: Path,
    limits: Limits,
    on_progress: Callable[[str, float], None] | None,
) -> SolverReport:
    """Run both measurements in ``folder``, a copy of the deck that may be written to.

    Raises:
        SolverError: The solver is missing, or does not run the deck to the end.
    """
    notify = on_progress or (lambda _stage, _share: None)
    notify("step 0", 0.0)
    text = deck_text(dialect.name, folder)
    unit = length_unit(text)
    output, start, zero = _run_step_zero(dialect, bed, folder, limits, text)
    timestep = unit * printed_number(dialect.name, output, "packgen timestep")
    try:
        run = _run_gravity(
            dialect, bed, folder, limits, timestep, unit, lambda share: notify("gravity run", share)
        )
    except SolverError as error:  # a faulty bed can end the solver: add what step 0 found
        raise SolverError(f"{error}\nin the gravity run of a bed with, at step 0: {zero}") from error
    version = re.search(dialect.version, "\n".join(output))
    return SolverReport(
        solver=dialect.name,
        version=version.group() if version else dialect.name,
        sphere_count=bed.count,
        body_count=particle_count(bed) if has_clumps(bed) else None,
        step_zero=zero,
        gravity_run=gravity_run(bed, start, run),
        limits=limits,
    )


def _run_step_zero(
    dialect: Dialect, bed: Bed, folder: Path, limits: Limits, deck: str
) -> tuple[tuple[str, ...], Float64Array, StepZero]:
    """Return output, positions by id [m] (N, 3), and the verdict's numbers on the forces."""
    unit = length_unit(deck)
    text = STEP_ZERO.format(contacts=dialect.contact_input(deck), line=dialect.format_word)
    output = run_script(dialect.name, folder, STEP_ZERO_INPUT, text, limits.silence_max, START_SECONDS, None)
    try:
        spheres = read_dump(folder / "packgen_spheres.dump", 8)
        spheres = spheres[np.argsort(spheres[:, 0], kind="stable")]
        if not np.array_equal(spheres[:, 0], np.arange(1, bed.count + 1)):
            raise SolverError(f"loaded {len(spheres)} spheres, expected ids 1 to {bed.count}")
        spheres[:, 1:5] *= unit
        spheres[:, 5:8] *= unit**2
        check_loaded(bed, spheres[:, 1:4], spheres[:, 4])
        weighing = np.ones(bed.count, bool) if dialect.weighs_members else alone(bed)
        weight = np.where(weighing, law.sphere_mass(bed), 0.0)[:, None] * bed.acceleration
        contact_force = spheres[:, 5:8] - weight
        found = dialect.read_contacts(bed, folder, contact_force, unit)
    except SolverError as error:
        raise SolverError(f"{dialect.name}: {error}; it said:\n{describe_output(output)}") from error
    return output, spheres[:, 1:4], step_zero(bed, *found)


def _run_gravity(
    dialect: Dialect,
    bed: Bed,
    folder: Path,
    limits: Limits,
    timestep: float,
    unit: float,
    on_share: Callable[[float], None],
) -> Trajectory:
    allowed = replace(limits, work_budget=dialect.budget_share(bed) * limits.work_budget)
    wanted, steps = steps_wanted(bed, allowed, timestep, least=SPHERES_LEAST)
    looks = looks_of(bed, timestep=timestep, steps=steps, every=steps // SAMPLES, share=limits.still_speed)
    samples: list[Look] = []

    def on_line(line: str) -> None:
        look = look_of(line)
        if look is not None:
            samples.append(look)
            on_share(look.step / max(1, steps))

    text = (
        INCLUDE
        + loop_input(looks, deck=deck_text(dialect.name, folder))
        + END.format(line=dialect.format_word)
    )
    seconds = START_SECONDS + steps * bed.count / SPHERE_STEPS_A_SECOND
    output = run_script(dialect.name, folder, GRAVITY_INPUT, text, limits.silence_max, seconds, on_line)
    still = was_still(output, looks)
    if not samples or (samples[-1].step != steps and not still):
        raise SolverError(f"{dialect.name}: ended before step {steps}; it said:\n{describe_output(output)}")
    rows = read_dump(folder / "packgen_end.dump", 4)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return Trajectory(
        timestep=timestep,
        steps=samples[-1].step,
        steps_wanted=wanted,
        index=rows[:, 0].astype(np.int64) - 1,
        position=unit * rows[:, 1:4],
        energy=unit**3 * np.array([each.energy for each in samples]),
        still=still,
    )


def run_script(
    solver: str,
    folder: Path,
    name: str,
    text: str,
    silence_max: float,
    seconds_max: float,
    on_line: Callable[[str], None] | None,
) -> tuple[str, ...]:
    """Let a solver run an input of this name in a folder, and return the last lines of what it printed.

    Raises:
        SolverError: See `run_solver`.
    """
    (folder / name).write_text(text, encoding="ascii")
    command = [str(find_solver(solver)), "-in", name, "-log", "none", "-var", "setup_only", "1"]
    return run_solver(
        solver, command, folder, silence_max=silence_max, seconds_max=seconds_max, on_line=on_line
    )


def deck_text(solver: str, folder: Path) -> str:
    """Return the text of a deck.

    Raises:
        SolverError: It cannot be read.
    """
    try:
        return (folder / "in.bed").read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise SolverError(f"{solver}: the deck's input cannot be read: {error}") from error


def length_unit(deck: str) -> float:
    """Return the unit of length [m] that a deck's text states; 1 where it states none.

    Times are in as many seconds, forces in its square of newtons, energies in its cube of joules.
    """
    found = re.search(r"^variable length_unit index (\S+)$", deck, re.MULTILINE)
    return float(found[1]) if found else 1.0


def printed_number(solver: str, output: tuple[str, ...], label: str) -> float:
    """Return the number above 0 that a solver printed behind a label.

    Raises:
        SolverError: It did not.
    """
    for line in output:
        if line.startswith(label):
            try:
                number = float(line.removeprefix(label))
            except ValueError:
                break
            if number > 0:
                return number
    raise SolverError(f"{solver}: did not tell its time step; it said:\n{describe_output(output)}")
