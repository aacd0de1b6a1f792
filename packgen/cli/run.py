"""One run: a function a stage, from the scene file to the folder of results."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from packgen.cli.looks import write_looks
from packgen.cli.progress import Listener, Share, show_progress
from packgen.cli.screen import say, table
from packgen.errors import ExportError, PackgenError, SceneError, SolverError
from packgen.results import DISK_FULL, ResultFolder

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from packgen.arrange.pack import PackResult
    from packgen.bed import Bed, Container
    from packgen.report import Report
    from packgen.scene import Scene

DEFAULT_SOLVER = "liggghts"
FEW = 200  # spheres of a zone, by whose shares nothing is said
SHARE_ERROR = 0.005  # of a set in a zone, from which it is said


class Stopwatch:
    """Wall time of each stage [s], in the order of the stages."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what is done inside."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


def peak_memory() -> int | None:
    """Return the largest memory that this process held so far [bytes]; None where it is not told."""
    try:
        import resource
    except ImportError:  # not on Windows
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak


@dataclass(frozen=True)
class _Plan:
    """All that is decided before the first sphere is placed."""

    scene: Scene
    exporters: Mapping[str, Any]
    settings: Mapping[str, Any]
    solvers: tuple[str, ...]
    target: Path


def run_scene(options: argparse.Namespace) -> int:
    """Make a bed, write its results, and say how it went."""
    watch = Stopwatch()
    with watch.stage("scene"):
        plan = _plan(options)
    folder = ResultFolder(plan.target, force=options.force, keep=(plan.scene.path,))
    with folder:
        bed, report = _make(plan, options, watch)
        warnings = list(report.warnings)
        unreached, verdict = _write(bed, plan, folder.path, options, watch, warnings)
        missed, warned = (*report.missed, *unreached), tuple(warnings)
        report = replace(report, missed=missed, warnings=warned, peak_memory=peak_memory())
        name, page = folder.target.name, not options.no_report
        report = write_looks(bed, report, folder.path, name, watch, page=page, picture=options.picture)
        folder.commit()
    return _conclude(report, verdict, folder, quiet=options.quiet)


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
    return _Plan(scene, chosen, settings, solvers if options.validate else (), target)


def _names(given: Sequence[str]) -> list[str]:
    """Return names from repeated options and comma lists."""
    return [name.strip() for each in given for name in each.split(",") if name.strip()]


def _make(plan: _Plan, options: argparse.Namespace, watch: Stopwatch) -> tuple[Bed, Report]:
    """Pack the scene and measure the bed."""
    from packgen.arrange.pack import pack
    from packgen.check import check_bed, wall_clearance
    from packgen.container import load_container
    from packgen.measure.order import WALL_REACH
    from packgen.report import build_report

    scene = plan.scene
    warnings: list[str] = []
    with watch.stage("container"):
        container = load_container(scene, warnings.append)
        _check_softness(plan, container, warnings)
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
        warnings += _unsupported(result, scene) + _off_shares(result, scene)
    with watch.stage("measure"):
        laws = [each.distribution for each in scene.particle_sets]
        report = build_report(
            bed, zones=result.zones, laws=laws, check=check, clearance=clearance, threads=options.threads
        )
    return bed, replace(report, warnings=tuple(warnings))


def _warn(warnings: list[str], line: str) -> None:
    """Say what looks wrong while there is time to stop the run, and keep it for the last lines."""
    say(f"packgen: warning: {line}", sys.stderr)
    warnings.append(line)


def _check_softness(plan: _Plan, container: Container, warnings: list[str]) -> None:
    """Say before the run what the bed's weight does to its spheres.

    Raises:
        PackgenError: It squeezes them through each other, or the scene's amounts make no sense.
    """
    from packgen.container.amounts import checked_locations
    from packgen.softness import check_softness

    solver = any(hasattr(exporter, "check_materials") for exporter in plan.exporters.values())
    try:
        for line in check_softness(plan.scene, container, for_solver=solver):
            _warn(warnings, line)
    except SceneError:
        checked_locations(plan.scene, container)  # a wrong unit is the nearer cause, and is said first
        raise


def _unsupported(result: PackResult, scene: Scene) -> list[str]:
    """Return a line for each zone that nothing holds up."""
    from packgen.check.support import hanging_zones

    lines = []
    for each in hanging_zones(result.bed, [zone.locations for zone in result.zones]):
        path = f"zones[{each.zone}]"
        lines.append(
            f"{scene.mark(path)}: {path}: nothing holds it up: of {each.looked_at} spheres at its lower end "
            f"{each.hanging} have neither sphere nor wall below, and will fall by about {each.fall:.3g} m; "
            "lower the zone onto what is below it, or fill the space in between first"
        )
    return lines


def _off_shares(result: PackResult, scene: Scene) -> list[str]:
    """Return a line for each zone whose sets are not in the proportions asked for: some found less room."""
    from packgen.shares import reached_shares

    lines = []
    for index, (zone, outcome) in enumerate(zip(scene.zones, result.zones, strict=True)):
        if outcome.placed < FEW or outcome.placed == outcome.asked:
            continue  # single spheres make shares, or these are exact
        reached = reached_shares(result.bed, index, zone.proportions_by)
        pairs = list(zip(reached, zone.set_proportions, strict=True))
        if max(abs(found - asked) for found, asked in pairs) > SHARE_ERROR:
            found, asked = (
                ", ".join(f"{share:.3f}" for share in shares) for shares in zip(*pairs, strict=True)
            )
            path = f"zones[{index}]"
            lines.append(
                f"{scene.mark(path)}: {path}: found shares {found} by {zone.proportions_by}, expected "
                f"{asked}: some sizes found less room; ask for an amount that fits, or give more room"
            )
    return lines


def _write(
    bed: Bed,
    plan: _Plan,
    folder: Path,
    options: argparse.Namespace,
    watch: Stopwatch,
    warnings: list[str],
) -> tuple[list[str], str]:
    """Write bed and decks, and let solvers confirm them; return what was not reached, and the verdicts."""
    from packgen.bedfile import save_bed

    with watch.stage("write"):
        save_bed(bed, folder / "bed.npz")
    missed = []
    with watch.stage("export"):
        for name, exporter in plan.exporters.items():
            (folder / name).mkdir()
            try:
                exporter.write(bed, folder / name, plan.settings[name])
            except (Exception, SystemExit) as error:
                if getattr(error, "errno", None) in DISK_FULL:
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
    with watch.stage("validate"):
        unconfirmed, verdict = _validate(bed, plan, folder, options, warnings)
    return missed + unconfirmed, verdict


def _validate(
    bed: Bed, plan: _Plan, folder: Path, options: argparse.Namespace, warnings: list[str]
) -> tuple[list[str], str]:
    """Let each solver confirm its deck; return what it did not confirm, and the verdicts as one table."""
    from packgen.validation import Limits, comparison, validate, validation_dict

    limits = Limits(**plan.scene.validation.model_dump())
    reports, errors = {}, {}
    for solver in plan.solvers:
        if not (folder / solver).is_dir():
            errors[solver] = f"{solver}: has no deck to run"
            continue
        with show_progress(sys.stderr, quiet=options.quiet) as listener:
            tell = partial(_tell, listener, solver)
            try:
                reports[solver] = validate(
                    bed, folder / solver, solver=solver, limits=limits, on_progress=tell
                )
            except SolverError as error:  # the bed is made and stays
                errors[solver] = str(error)
            except KeyboardInterrupt:
                errors[solver] = f"{solver}: interrupted before it was done"
                break
        if solver in reports and reports[solver].unjudged:
            warnings.append(reports[solver].unjudged)
    content = validation_dict(reports)
    if errors:
        content |= {"passed": False, "errors": errors}
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "validation.json").write_text(text + "\n", encoding="utf-8")
    missed = [line for report in reports.values() for line in report.missed] + list(errors.values())
    return missed, table(comparison(list(reports.values()))) if reports else ""


def _tell(listener: Listener, solver: str, stage: str, share: float) -> None:
    listener(Share(f"{solver}, {stage}", share))


def _conclude(report: Report, verdict: str, folder: ResultFolder, *, quiet: bool) -> int:
    """Say what was reached, and last what was not; return the exit code."""
    if not quiet:
        say(table(report.rows()), sys.stdout)
        if verdict:
            say(f"\n{verdict}\n", sys.stdout)
        say(f"written to {folder.target}", sys.stdout)
    if folder.set_aside is not None:
        say(f"packgen: the former folder, which had other files, is now {folder.set_aside}", sys.stderr)
    for line in report.warnings:
        say(f"packgen: warning: {line}", sys.stderr)
    for line in report.missed:
        say(f"packgen: missed: {line}", sys.stderr)
    return 1 if report.missed else 0
