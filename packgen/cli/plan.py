"""All that is decided before the first sphere is placed, so that nothing is missing after a long run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.exports import Format, export_settings
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import RunOptions
from packgen.errors import PackgenError

if TYPE_CHECKING:
    from packgen.scene import Scene

DEFAULT_SOLVER = "liggghts"


@dataclass(frozen=True, slots=True)
class Plan:
    """What a run is to do.

    Attributes:
        scene: The scene, with the seed that counts.
        formats: What to write, by name, in order.
        solvers: The solvers that have to confirm the bed.
        settle: The solver that settles it before; None: none does.
        settle_time: How long [s]; None: until it is still.
        target: The result folder.
    """

    scene: Scene
    formats: Mapping[str, Format]
    solvers: tuple[str, ...]
    target: Path
    settle: str | None = None
    settle_time: float | None = None


def make_plan(options: RunOptions) -> Plan:
    """Read the scene and find exporters and solvers.

    Raises:
        PackgenError: The scene is wrong, or a name is unknown, or a solver is missing.
    """
    from packgen.scene import load_scene

    solvers = check_solvers(options.solver, validate=options.validate)
    settle = _settle(options)
    named = (*options.export, *solvers, *(() if settle is None else (settle,)))
    formats = find_formats(named, options.export_option, options.templates)
    if options.templates is not None and not options.templates.is_dir():
        raise PackgenError(f"--templates: found {options.templates}, expected an existing folder")
    if options.workers is not None and options.scheduler is not None:
        raise PackgenError("--workers: found with --scheduler; leave one of them out")
    if options.resume and not options.shared:
        raise PackgenError("--resume: found without --workers or --scheduler; add the one of the first run")
    if options.pieces:
        _check_pieces(options)
    scene = load_scene(options.scene, options.changes)
    if options.seed is not None:
        if ("seed",) in scene.marked.given:
            raise PackgenError("--seed: found beside --set seed; leave one of them out")
        scene = replace(scene, seed=options.seed)
    if options.shared:
        from packgen.filling.tiles import in_tiles

        scene = in_tiles(scene, shared=True)
    refuse_unreadable([options.target.resolve().name])
    time = None if options.until in {None, math.inf} else options.until
    return Plan(scene, formats, solvers, options.target, settle, time)


def _settle(options: RunOptions) -> str | None:
    """Return the solver that settles the bed, which is there; None where none is to."""
    if options.settle is None:
        if options.until is not None:
            raise PackgenError("--until: found without --settle; add --settle SOLVER, or leave --until out")
        return None
    from packgen.validation import find_solver

    find_solver(options.settle, option="--settle")
    return options.settle


def _check_pieces(options: RunOptions) -> None:
    """Refuse what goes with no bed in pieces."""
    if not options.shared:
        raise PackgenError("--pieces: found without --workers or --scheduler; add one of them")
    for name, found in (
        ("--validate", options.validate),
        ("--picture", options.picture),
        ("--settle", options.settle is not None),
    ):
        if found:
            raise PackgenError(
                f"--pieces: found with {name}, which takes the whole bed; leave one of them out"
            )


def check_solvers(given: tuple[str, ...], *, validate: bool) -> tuple[str, ...]:
    """Return the solvers that have to confirm the bed, all of which are there."""
    if given and not validate:
        raise PackgenError("--solver: found without --validate; add --validate, or leave --solver out")
    if not validate:
        return ()
    from packgen.validation import find_solver

    solvers = given or (DEFAULT_SOLVER,)
    for solver in solvers:
        find_solver(solver)
    return solvers


def find_formats(names: tuple[str, ...], given: tuple[str, ...], templates: Path | None) -> dict[str, Format]:
    """Return exporters and their options by name.

    Args:
        names: Names of the formats.
        given: Options, each ``NAME.KEY=VALUE``.
        templates: Folder whose templates replace packgen's own; None: none does.

    Raises:
        ExportError: A name or an option is wrong.
    """
    import exporters

    chosen = {name: exporters.get(name) for name in dict.fromkeys(names)}
    settings = export_settings(chosen, given, templates)
    return {name: Format(exporter, settings[name]) for name, exporter in chosen.items()}
