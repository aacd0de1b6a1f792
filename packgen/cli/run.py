"""One run: a function a stage, from the scene file to the folder of results.

Each stage returns what it found. All of it comes together in the report, at the end.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.crews import crew_of, gathering_remark, parts_of
from packgen.cli.ending import EXIT_INTERRUPTED, Ending
from packgen.cli.exports import check_formats, check_whole, outlook_of, write_decks
from packgen.cli.options import RunOptions
from packgen.cli.plan import Plan, make_plan
from packgen.cli.progress import Share, show_progress
from packgen.cli.screen import say, say_json, table
from packgen.cli.settle import Outcome, keep_state, limits_of, refuse_unsettled, settle_bed, with_settling
from packgen.cli.stopwatch import Stopwatch
from packgen.cli.visuals import composer, write_looks
from packgen.errors import PackgenError
from packgen.resultfolder import UNVALIDATED, ResultFolder
from packgen.stopping import held, unhurried
from packgen.summary import summary

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from packgen.arrange.crew import Crew
    from packgen.bed import AnyBed
    from packgen.filling.in_pieces import PiecesResult
    from packgen.filling.pack import PackResult
    from packgen.geometry import Container
    from packgen.report import Measures, Report
    from packgen.scene import Scene
    from packgen.validation import OnProgress, Verdict


@dataclass(frozen=True, slots=True)
class _Vessel:
    """The container as it was loaded.

    Attributes:
        container: The container.
        mended: A line for each repair of its surface, and for a bed too large to be gathered; shown at the
            end, or with an error.
        for_solver: Whether the bed is for a solver.
    """

    container: Container
    mended: tuple[str, ...]
    for_solver: bool


def run_scene(options: RunOptions, ending: Ending) -> int:
    """Make a bed, write its results, and say how it went; ``ending`` is told when they are in place."""
    watch = Stopwatch()
    with watch.stage("scene"):
        plan = make_plan(options)
    folder = ResultFolder(plan.target, force=options.force, keep=_inputs(plan.scene))
    with folder, parts_of(options) as parts:
        vessel = _load(plan, options, watch)
        with crew_of(options, plan.scene, parts, ending) as crew:
            packed = _pack(plan.scene, vessel, options, watch, crew, folder.path)
        outcome = settle_bed(packed.bed, plan, folder, watch, quiet=options.quiet)
        bed = outcome.bed
        measures = _measure(plan.scene, packed, bed, options.threads, watch, folder)
        unwritten = _write(bed, plan, folder, watch)
        measures = with_settling(measures, outcome, keep_state(outcome, folder), watch)
        verdict = _validate(outcome, plan, folder, watch, quiet=options.quiet)
        unconfirmed, unjudged = ((), ()) if verdict is None else (verdict.missed, verdict.unjudged)
        compose = composer(
            measures, bed.provenance, watch,
            missed=(*outcome.missed, *unwritten, *unconfirmed),
            warnings=(*vessel.mended, *packed.warnings, *unjudged),
        )  # fmt: skip
        hurry = bool(folder.beside)
        report = write_looks(
            bed, compose, folder.path, folder.target.name, watch,
            page=options.page and not hurry, picture=options.picture and not hurry,
        )  # fmt: skip
        code = EXIT_INTERRUPTED if hurry else int(bool(report.missed))
        with held():
            folder.commit()
            ending.done(code, f"the bed is in {folder.target}")
        if parts is not None:
            parts.remove()
    if options.json:
        say_json(summary(json.loads(report.as_json()), str(folder.target), code))
    conclude(report, folder, verdict=verdict, quiet=options.quiet or options.json)
    return code


def _inputs(scene: Scene) -> tuple[Path, ...]:
    """Return the files that must not be in the result folder, which is replaced."""
    return (scene.path,) if scene.start_from is None else (scene.path, scene.start_from.path)


def _load(plan: Plan, options: RunOptions, watch: Stopwatch) -> _Vessel:
    """Load the container, and let formats refuse it before the run.

    Raises:
        PackgenError: The container cannot be loaded, or a format takes no bed of this scene.
    """
    from packgen.container import load_container

    mended: list[str] = []
    with watch.stage("container"), explained(mended):
        container = load_container(plan.scene, mended.append)
        if plan.formats:
            check_formats(plan.formats, outlook_of(plan.scene, container))
        refuse_unsettled(plan, plan.scene, container)
        remark = gathering_remark(options, plan.scene)
        if remark is not None:
            mended.append(remark)
            warn(remark)
        if options.pieces:
            amounts = [zone.n_particles for zone in plan.scene.zones]
            check_whole(plan.formats, sum(each or 0 for each in amounts))
    for_solver = any(each.exporter.IS_DECK for each in plan.formats.values())
    return _Vessel(container, tuple(mended), for_solver)


@contextmanager
def explained(warnings: Sequence[str]) -> Iterator[None]:
    """Show warnings before an error that ends the code inside: a repair may well be the cause."""
    try:
        yield
    except PackgenError:
        for line in warnings:
            warn(line)
        raise


def warn(line: str) -> None:
    """Show a warning."""
    say(f"packgen: warning: {line}", sys.stderr)


def _pack(
    scene: Scene, vessel: _Vessel, options: RunOptions, watch: Stopwatch, crew: Crew | None, folder: Path
) -> PackResult | PiecesResult:
    """Fill the container; warnings are shown while there is time to stop the run."""
    with (
        watch.stage("arrange"),
        show_progress(sys.stderr, quiet=options.quiet) as listener,
        explained(vessel.mended),
    ):
        if options.pieces and crew is not None:
            from packgen.filling.in_pieces import pack_in_pieces

            return pack_in_pieces(
                scene, vessel.container, folder, crew=crew, on_progress=listener, threads=options.threads,
                warn=warn, for_solver=vessel.for_solver,
            )  # fmt: skip
        from packgen.filling.pack import pack

        return pack(
            scene,
            vessel.container,
            on_progress=listener,
            threads=options.threads,
            device=options.device,
            warn=warn,
            for_solver=vessel.for_solver,
            crew=crew,
        )


def _measure(
    scene: Scene,
    packed: PackResult | PiecesResult,
    bed: AnyBed,
    threads: int | None,
    watch: Stopwatch,
    folder: ResultFolder,
) -> Measures:
    """Check and measure a bed, the packed one or what a solver has made of it; note what is left out."""
    from packgen.bed import Bed
    from packgen.check import check_bed, wall_clearance
    from packgen.distributions import Free
    from packgen.measure.order import WALL_REACH
    from packgen.pieces import PieceBed
    from packgen.report import measure_bed

    drawn = [each for each in scene.particle_sets if not isinstance(each.distribution, Free)]
    by_name = {each.name: each.distribution for each in drawn}
    laws = [by_name.get(each.name) for each in bed.particle_sets]
    if isinstance(bed, PieceBed):
        from packgen.report_in_pieces import check_pieces, left_out, measure_pieces

        folder.notes.append(left_out())
        with watch.stage("check"):
            check = check_pieces(bed)
        with watch.stage("measure"):
            return measure_pieces(bed, check, zones=packed.zones, laws=laws)
    assert isinstance(bed, Bed)
    with watch.stage("check"):
        clearance = wall_clearance(bed.container, bed.position, WALL_REACH * bed.radius)
        check = check_bed(bed, clearance)
    with watch.stage("measure"):
        return measure_bed(
            bed, zones=packed.zones, laws=laws, check=check, clearance=clearance, threads=threads,
            jamming=packed.jamming,
        )  # fmt: skip


def _write(bed: AnyBed, plan: Plan, folder: ResultFolder, watch: Stopwatch) -> tuple[str, ...]:
    """Write bed and decks; return a line for each deck that could not be written."""
    from packgen.bed import Bed
    from packgen.bedfile import save_bed

    if isinstance(bed, Bed):  # pieces are written already
        with watch.stage("write"):
            save_bed(bed, folder.path / "bed.npz")
    with watch.stage("export"):
        return write_decks(bed, folder.path, plan.formats)


def _validate(
    outcome: Outcome, plan: Plan, folder: ResultFolder, watch: Stopwatch, *, quiet: bool
) -> Verdict | None:
    """Let solvers confirm the decks; None where none is asked, or the bed is not settled as it was to be."""
    from packgen.bed import Bed

    if not plan.solvers or outcome.interrupted or not isinstance(outcome.bed, Bed):
        return None
    from packgen.validation import validate_decks

    with watch.stage("validate"), unhurried():
        verdict = validate_decks(
            outcome.bed, folder.path, plan.solvers, limits=limits_of(plan.scene, outcome),
            progress=partial(_solver_progress, quiet),
        )  # fmt: skip
        if verdict.interrupted:
            folder.keep_beside(UNVALIDATED)
    return verdict


@contextmanager
def _solver_progress(quiet: bool, solver: str) -> Iterator[OnProgress]:
    with show_progress(sys.stderr, quiet=quiet) as listener:
        yield lambda stage, share: listener(Share(f"{solver}, {stage}", share))


def conclude(report: Report, folder: ResultFolder, *, verdict: Verdict | None = None, quiet: bool) -> None:
    """Say what was reached, and last what was not."""
    if not quiet:
        say(table(report.rows()), sys.stdout)
        if verdict is not None and verdict.reports:
            say(f"\n{table(verdict.rows())}\n", sys.stdout)
        say(f"written to {folder.target}", sys.stdout)
    for line in folder.notes:
        say(f"packgen: {line}", sys.stderr)
    for line in report.warnings:
        warn(line)
    for line in report.missed:
        say(f"packgen: missed: {line}", sys.stderr)
    if folder.beside:
        what = "judged, it" if folder.beside == UNVALIDATED else "settled, what was reached"
        say(f"packgen: interrupted before the bed was {what} is in {folder.target}", sys.stderr)
