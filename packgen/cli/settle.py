"""``--settle``: a solver runs the packed bed's deck, and what it leaves becomes the bed of the run."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.exports import write_decks
from packgen.cli.plan import Plan
from packgen.cli.progress import Share, show_progress
from packgen.cli.stopwatch import Stopwatch
from packgen.errors import PackgenError, SolverError
from packgen.resultfolder import UNSETTLED, ResultFolder
from packgen.stopping import unhurried

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from packgen.bed import AnyBed, Bed
    from packgen.geometry import Container
    from packgen.report import Measures
    from packgen.scene import Scene
    from packgen.settlement import BedFigures
    from packgen.settling import Settled
    from packgen.validation import Limits

SCRATCH = "settling"  # inside the unfinished result folder
STATE = "settled"  # name of the solver's own state, without its suffixes


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of settling; by its defaults that of a run without it.

    Attributes:
        bed: The bed that the run goes on with.
        settled: What the solver left; None where nothing was asked or it failed.
        before: The bed as it was packed, in figures; None likewise.
        missed: A line for what went wrong.
        until: What was asked for, in words.
        folder: Where the solver ran; None likewise.
    """

    bed: AnyBed
    settled: Settled | None = None
    before: BedFigures | None = None
    missed: tuple[str, ...] = ()
    until: str = ""
    folder: Path | None = None

    @property
    def interrupted(self) -> bool:
        """Whether a stop ended the solver's run."""
        return self.settled is not None and self.settled.interrupted


def refuse_unsettled(plan: Plan, scene: Scene, container: Container) -> None:
    """Refuse to settle beds that have nothing to fall on.

    Raises:
        PackgenError: There is no gravity, or the container wraps around along it.
    """
    if plan.settle is None:
        return
    import numpy as np

    from packgen.geometry import floor_direction

    down = np.asarray(scene.gravity_direction, np.float64)
    found = "no gravity" if scene.gravity == 0.0 else "a box that wraps around along gravity"
    if scene.gravity == 0.0 or floor_direction(down, container.periodic) is None:
        raise PackgenError(
            f"--settle: found a scene with {found}, expected one whose spheres fall on something; "
            "leave --settle out"
        )


def refuse_unjudged(solvers: Sequence[str], container: Container) -> None:
    """Refuse to have solvers confirm a bed in a periodic cell of any shape: not supported yet.

    Raises:
        PackgenError: There are such a cell and solvers.
    """
    if solvers and container.cell is not None:
        raise PackgenError(
            "--validate: found a periodic cell whose edges are not along x, y and z, expected a box or "
            "walls; leave --validate out: packgen's own check knows such cells"
        )


def settle_bed(bed: AnyBed, plan: Plan, folder: ResultFolder, watch: Stopwatch, *, quiet: bool) -> Outcome:
    """Let the solver settle the bed; one that fails, or loses spheres, costs no bed."""
    solver = plan.settle
    from packgen.bed import Bed

    if solver is None or not isinstance(bed, Bed):  # no solver settles a bed in pieces
        return Outcome(bed)
    from packgen.settling import settle

    before = _figures(bed, watch.seconds.get("arrange", 0.0))
    until = "still" if plan.settle_time is None else f"{plan.settle_time:g} s"
    scratch = folder.path / SCRATCH
    with watch.stage("settle"), unhurried():
        scratch.mkdir()
        unwritten = write_decks(bed, scratch, {solver: plan.formats[solver]})
        if unwritten:
            return Outcome(bed, missed=tuple(f"not settled: {line}" for line in unwritten), folder=scratch)
        try:
            with show_progress(sys.stderr, quiet=quiet) as listener:
                settled = settle(
                    bed, scratch / solver, solver=solver, time=plan.settle_time,
                    on_progress=lambda stage, share: listener(
                        Share(f"{solver} settles, {stage}", share)
                    ),
                )  # fmt: skip
        except SolverError as error:
            return Outcome(
                bed, missed=(f"not settled, the bed is as it was packed: {error}",), folder=scratch
            )
    if settled.interrupted:
        folder.keep_beside(UNSETTLED)
    return Outcome(_as_dem_bed(settled, plan.scene, until), settled, before, (), until, scratch)


def _as_dem_bed(settled: Settled, scene: Scene, until: str) -> Bed:
    """Return the settled bed with the tolerance of soft spheres, and with what settled it."""
    from packgen.settlement import DEM_TOLERANCE

    tolerance = None if scene.soft_materials else DEM_TOLERANCE
    told = {
        "solver": settled.solver,
        "version": settled.version,
        "until": until,
        "still": settled.still,
        "time": settled.time,
        "tolerance": tolerance,
    }
    bed = settled.bed
    return replace(bed, tolerance=tolerance, provenance={**bed.provenance, "settled": told})


def _figures(bed: Bed, seconds: float) -> BedFigures:
    """Return the packed bed in figures."""
    from packgen.check import check_bed
    from packgen.measure import contacts, solid_fraction
    from packgen.settlement import CONTACT_GAP, bed_figures

    return bed_figures(check_bed(bed), solid_fraction(bed), contacts(bed, (CONTACT_GAP,)), seconds)


def keep_state(outcome: Outcome, folder: ResultFolder) -> str:
    """Put the solver's own state into its deck's folder, and tidy up after its run.

    Returns:
        The state's name, relative to the result folder; empty where there is none.
    """
    name, settled = "", outcome.settled
    if settled is not None and settled.restart is not None:
        place = folder.path / settled.solver
        if place.is_dir():  # its deck was written
            state = place / (STATE + "".join(settled.restart.suffixes))
            shutil.move(settled.restart, state)
            name = state.relative_to(folder.path).as_posix()
    if outcome.folder is not None:
        shutil.rmtree(outcome.folder, ignore_errors=True)
    return name


def with_settling(measures: Measures, outcome: Outcome, state: str, watch: Stopwatch) -> Measures:
    """Return the measures of a bed with what is known of its settling.

    Args:
        measures: Those of the settled bed.
        outcome: What came of settling.
        state: Name of the solver's own state.
        watch: What has timed the solver.
    """
    settled, before = outcome.settled, outcome.before
    from packgen.bed import Bed

    if settled is None or before is None or not isinstance(outcome.bed, Bed):
        return measures
    from packgen.settlement import Settling, bed_figures
    from packgen.settling.run import STILL_SPEED

    settling = Settling(
        solver=settled.solver, version=settled.version, until=outcome.until, still=settled.still,
        interrupted=settled.interrupted, time=settled.time, steps=settled.steps,
        free_fall_times=settled.free_fall_times, speed=settled.speed, still_speed=STILL_SPEED,
        displacement_mean=settled.displacement_mean, displacement_max=settled.displacement_max,
        tolerance=outcome.bed.tolerance, restart=state, before=before,
        after=bed_figures(
            measures.overlap, measures.solid_fraction, measures.contacts, watch.seconds["settle"]
        ),
    )  # fmt: skip
    return replace(measures, settling=settling)


def limits_of(scene: Scene, outcome: Outcome) -> Limits:
    """Return the limits of a validation: forces in a settled bed are those that hold it, and no fault.

    So are those in a bed that goes on from one that a solver has settled.
    """
    from packgen.bed import Bed
    from packgen.validation import Limits

    limits = Limits(**scene.validation.model_dump())
    bed, held = outcome.bed, outcome.settled is not None
    if isinstance(bed, Bed):  # one in pieces goes on from no other
        told = bed.provenance.get("start_from", {})
        held |= told.get("overlap_max", 0.0) > (bed.tolerance or 0.0)
    if not held or "force_limit" in scene.validation.model_fields_set:
        return limits
    return replace(limits, force_limit=None)
