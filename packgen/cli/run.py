"""One run: a function a stage, from the scene file to the folder of results."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from packgen.cli.ending import EXIT_INTERRUPTED, Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.progress import Listener, Share, show_progress
from packgen.cli.screen import say, table
from packgen.cli.stopwatch import Stopwatch, peak_memory
from packgen.cli.visuals import write_looks
from packgen.errors import ExportError, PackgenError, SceneError, SolverError
from packgen.resultfolder import DISK_FULL, ResultFolder
from packgen.stopping import answer, held, stop_seen, unhurried

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from packgen.bed import Bed, Container
    from packgen.report import Report
    from packgen.scene import Scene

DEFAULT_SOLVER = "liggghts"


@dataclass(frozen=True)
class _Plan:
    """All that is decided before the first sphere is placed."""

    scene: Scene
    exporters: Mapping[str, Any]
    settings: Mapping[str, Any]
    solvers: tuple[str, ...]
    target: Path


def run_scene(options: argparse.Namespace, ending: Ending) -> int:
    """Make a bed, write its results, and say how it went; ``ending`` is told when they are in place."""
    watch = Stopwatch()
    with watch.stage("scene"):
        plan = _plan(options)
    folder = ResultFolder(plan.target, force=options.force, keep=(plan.scene.path,))
    with folder:
        bed, report = _make(plan, options, watch)
        warnings = list(report.warnings)
        unreached, verdict = _write(bed, plan, folder, options, watch, warnings)
        missed, warned = (*report.missed, *unreached), tuple(warnings)
        report = replace(report, missed=missed, warnings=warned, peak_memory=peak_memory())
        name, hurry = folder.target.name, folder.unvalidated
        page, picture = not (options.no_report or hurry), options.picture and not hurry
        report = write_looks(bed, report, folder.path, name, watch, page=page, picture=picture)
        code = EXIT_INTERRUPTED if hurry else int(bool(report.missed))
        with held():
            folder.commit()
            ending.done(code, f"the bed is in {folder.target}")
    _conclude(report, verdict, folder, quiet=options.quiet)
    return code


def _plan(options: argparse.Namespace) -> _Plan:
    """Read the scene and find exporters and solvers, so that nothing is missing after a long run.

    Raises:
        PackgenError: The scene is wrong, or a name is unknown, or a solver is missing.
    """
    import exporters
    from packgen.cli.exports import export_settings
    from packgen.scene import load_scene

    solvers = tuple(dict.fromkeys(_names(options.solver))) or (DEFAULT_SOLVER,)
    wanted = _names(options.export) + (list(solvers) if options.validate else [])
    if options.solver and not options.validate:
        raise PackgenError("--solver: found without --validate; add --validate, or leave --solver out")
    if options.validate:
        from packgen.validation import find_solver

        for solver in solvers:
            find_solver(solver)
    chosen = {name: exporters.get(name) for name in dict.fromkeys(wanted)}
    settings = export_settings(chosen, options.export_option, options.templates)
    if options.templates is not None and not options.templates.is_dir():
        raise PackgenError(f"--templates: found {options.templates}, expected an existing folder")
    scene = load_scene(options.scene)
    if options.seed is not None:
        scene = replace(scene, seed=options.seed)
    for exporter in chosen.values():
        # A format that refuses a material or a periodic box says so now, not when the bed is made.
        for name, value in (
            ("check_materials", scene.materials),
            ("check_periodic", scene.container.periodic),
        ):
            check = getattr(exporter, name, None)
            if check is not None:
                check(value)
    target = options.output or Path(options.scene.stem)
    refuse_unreadable([target.resolve().name])
    return _Plan(scene, chosen, settings, solvers if options.validate else (), target)


def _names(given: Sequence[str]) -> list[str]:
    """Return names from repeated options and comma lists."""
    return [name.strip() for each in given for name in each.split(",") if name.strip()]


def _make(plan: _Plan, options: argparse.Namespace, watch: Stopwatch) -> tuple[Bed, Report]:
    """Pack the scene and measure the bed."""
    from packgen.check import check_bed, wall_clearance
    from packgen.container import load_container
    from packgen.filling.pack import pack
    from packgen.measure.order import WALL_REACH
    from packgen.report import build_report

    scene = plan.scene
    warnings: list[str] = []
    with watch.stage("container"):
        container = load_container(scene, warnings.append)
        _check_softness(plan, container, warnings)
    of_container = tuple(warnings)
    with watch.stage("arrange"), show_progress(sys.stderr, quiet=options.quiet) as listener:
        try:
            result = pack(
                scene,
                container,
                on_progress=listener,
                threads=options.threads,
                device=options.device,
                warn=partial(_warn, warnings),
            )
        except PackgenError:
            for line in warnings:  # what was mended or looks odd may well be why
                say(f"packgen: warning: {line}", sys.stderr)
            raise
    with watch.stage("check"):
        bed = result.bed
        clearance = wall_clearance(bed.container, bed.position, WALL_REACH * bed.radius)
        check = check_bed(bed, clearance)
    with watch.stage("measure"):
        laws = [each.distribution for each in scene.particle_sets]
        report = build_report(
            bed, zones=result.zones, laws=laws, check=check, clearance=clearance, threads=options.threads
        )
    return bed, replace(report, warnings=(*of_container, *result.warnings))


def _warn(warnings: list[str], line: str) -> None:
    """Say what looks wrong while there is time to stop the run, and keep it for the last lines."""
    say(f"packgen: warning: {line}", sys.stderr)
    warnings.append(line)


def _check_softness(plan: _Plan, container: Container, warnings: list[str]) -> None:
    """Say before the run what the bed's weight does to its spheres.

    Raises:
        PackgenError: It squeezes them through each other, or the scene's amounts make no sense.
    """
    from packgen.filling.fit import checked_locations
    from packgen.filling.softness import check_softness

    solver = any(hasattr(exporter, "check_materials") for exporter in plan.exporters.values())
    try:
        for line in check_softness(plan.scene, container, for_solver=solver):
            _warn(warnings, line)
    except SceneError:
        checked_locations(plan.scene, container)  # a wrong unit is the nearer cause, and is said first
        raise


def _write(
    bed: Bed,
    plan: _Plan,
    results: ResultFolder,
    options: argparse.Namespace,
    watch: Stopwatch,
    warnings: list[str],
) -> tuple[list[str], str]:
    """Write bed and decks, and let solvers confirm them; return what was not reached, and the verdicts."""
    from packgen.bedfile import save_bed

    folder = results.path
    with watch.stage("write"):
        save_bed(bed, folder / "bed.npz")
    missed = []
    with watch.stage("export"):
        for name, exporter in plan.exporters.items():
            (folder / name).mkdir()
            try:
                exporter.write(bed, folder / name, plan.settings[name])
            except (Exception, SystemExit) as error:
                if getattr(error, "errno", None) in DISK_FULL or stop_seen():
                    raise
                # The bed is worth keeping, a deck that is not whole is not.
                shutil.rmtree(folder / name)
                known = isinstance(error, ExportError)
                why = (
                    str(error)
                    if known
                    else f"its exporter or a template failed, {type(error).__name__}: {error}"
                )
                missed.append(f"no {name} deck: {why}")
    if not plan.solvers:
        return missed, ""
    with watch.stage("validate"), unhurried():
        unconfirmed, verdict = _validate(bed, plan, results, options, warnings)
    return missed + unconfirmed, verdict


def _validate(
    bed: Bed, plan: _Plan, results: ResultFolder, options: argparse.Namespace, warnings: list[str]
) -> tuple[list[str], str]:
    """Let each solver confirm its deck; return what it did not confirm, and the verdicts as one table."""
    from packgen.validation import Limits, comparison, validate, validation_dict

    folder = results.path
    limits = Limits(**plan.scene.validation.model_dump())
    reports, errors = {}, {}
    for solver in plan.solvers:
        if not (folder / solver).is_dir():
            errors[solver] = f"{solver}: has no deck to run"
            continue
        try:
            with show_progress(sys.stderr, quiet=options.quiet) as listener:
                tell = partial(_tell, listener, solver)
                reports[solver] = validate(
                    bed, folder / solver, solver=solver, limits=limits, on_progress=tell
                )
        except (Exception, KeyboardInterrupt) as error:
            if isinstance(error, KeyboardInterrupt) or stop_seen():
                answer()
                results.keep_unvalidated()
                errors[solver] = f"{solver}: interrupted before it was done"
                break
            if not isinstance(error, SolverError):
                raise
            errors[solver] = str(error)  # the bed is made and stays
        if solver in reports and reports[solver].unjudged:
            warnings.append(reports[solver].unjudged)
    content = validation_dict(reports)
    if errors:
        content |= {"passed": False, "errors": errors, "interrupted": results.unvalidated}
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "validation.json").write_text(text + "\n", encoding="utf-8")
    missed = [line for report in reports.values() for line in report.missed] + list(errors.values())
    return missed, table(comparison(list(reports.values()))) if reports else ""


def _tell(listener: Listener, solver: str, stage: str, share: float) -> None:
    listener(Share(f"{solver}, {stage}", share))


def _conclude(report: Report, verdict: str, folder: ResultFolder, *, quiet: bool) -> None:
    """Say what was reached, and last what was not."""
    if not quiet:
        say(table(report.rows()), sys.stdout)
        if verdict:
            say(f"\n{verdict}\n", sys.stdout)
        say(f"written to {folder.target}", sys.stdout)
    for line in folder.notes:
        say(f"packgen: {line}", sys.stderr)
    for line in report.warnings:
        say(f"packgen: warning: {line}", sys.stderr)
    for line in report.missed:
        say(f"packgen: missed: {line}", sys.stderr)
    if folder.unvalidated:
        say(f"packgen: interrupted before the bed was judged, it is in {folder.target}", sys.stderr)
