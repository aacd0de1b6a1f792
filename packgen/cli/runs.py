"""Many runs of a scene, a folder each: what ``packgen sweep`` and ``packgen contest`` have in common."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from packgen.cli.ending import Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import add_changes, add_formats, names_in, whole
from packgen.cli.plan import check_solvers, find_formats
from packgen.cli.screen import say
from packgen.errors import PackgenError, SceneError

if TYPE_CHECKING:
    from packgen.sweep.over import Run
    from packgen.sweep.table import Line


@dataclass(frozen=True, slots=True)
class RunsOptions:
    """What the command line asks of many runs.

    Attributes:
        command: The command: its table has its name, and the folder by default too.
        scene: The scene file.
        target: The folder of the runs.
        changes: Values in place of the scene's in every run, each ``KEY=VALUE``.
        jobs: How many runs at once.
        passed: Options that every run gets.
        export: Names of the formats that every run writes.
        export_option: Options of these.
        templates: Folder whose deck templates replace packgen's own; None: none does.
        validate: Whether solvers confirm the beds.
        solver: Names of these solvers.
        threads: Threads of a run; None: the free cores shared among the jobs.
        quiet: Whether to leave out progress.
        json: Whether to show the table as JSON.
    """

    command: str
    scene: Path
    target: Path
    changes: tuple[str, ...] = ()
    jobs: int = 1
    passed: tuple[str, ...] = ()
    export: tuple[str, ...] = ()
    export_option: tuple[str, ...] = ()
    templates: Path | None = None
    validate: bool = False
    solver: tuple[str, ...] = ()
    threads: int | None = None
    quiet: bool = False
    json: bool = False

    @property
    def table(self) -> str:
        """Name of the table in the folder."""
        return f"{self.command}.csv"


def add_runs(parser: argparse.ArgumentParser, command: str) -> None:
    """Add what many runs have in common but the scene."""
    add_changes(parser)
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help=f"folder of the runs (default: SCENE.{command})"
    )
    parser.add_argument("--jobs", metavar="N", type=whole(1), default=1, help="runs at once (default: 1)")
    add_formats(parser, "deck")
    parser.add_argument("--validate", action="store_true", help="confirm each bed in a solver")
    parser.add_argument(
        "--solver",
        metavar="NAME",
        action="append",
        default=[],
        help="solver for --validate (default: liggghts)",
    )
    parser.add_argument(
        "--threads", metavar="N", type=whole(1), help="threads of each run (default: free cores over jobs)"
    )
    parser.add_argument("--picture", action="store_true", help="draw each bed")
    parser.add_argument("--no-report", action="store_true", help="make no report.html")
    parser.add_argument("--quiet", action="store_true", help="show what failed alone")
    parser.add_argument("--json", action="store_true", help="show the table as JSON")


def runs_options(
    parser: argparse.ArgumentParser, command: str, arguments: Sequence[str]
) -> tuple[RunsOptions, dict[str, Any]]:
    """Return what is asked of the runs, and all that the parser has been given, by its names."""
    given = vars(parser.parse_args(arguments))
    flags = {"--picture": given["picture"], "--no-report": given["no_report"]}
    scene: Path = given["scene"]
    return RunsOptions(
        command=command,
        scene=scene,
        target=given["output"] or Path(f"{scene.stem}.{command}"),
        changes=tuple(given["set"]),
        passed=tuple(name for name, is_given in flags.items() if is_given),
        export=names_in(given["export"]),
        export_option=tuple(given["export_option"]),
        solver=names_in(given["solver"]),
        **{name: given[name] for name in ("jobs", "templates", "validate", "threads", "quiet", "json")},
    ), given


def solvers_of(options: RunsOptions) -> tuple[str, ...]:
    """Return the solvers that are to judge the beds.

    Raises:
        PackgenError: One, or a format, is not there.
    """
    solvers = check_solvers(options.solver, validate=options.validate)
    find_formats((*options.export, *solvers), options.export_option, options.templates)
    return tuple(solvers)


def make_runs(
    options: RunsOptions, runs: Sequence[Run], solvers: Sequence[str], ending: Ending
) -> list[Line]:
    """Make the runs whose folders are not complete, and the table of all.

    Args:
        options: What is asked of them.
        runs: The runs, in the order in which they are made.
        solvers: Solvers that judge the beds.
        ending: Told what is true of the runs.

    Returns:
        A line a run, in their order.

    Raises:
        PackgenError: The folder is something else, or the scene is wrong in every run.
    """
    refuse_unreadable([options.target.resolve().name])
    _check_target(options)
    done, failed, commands = _sorted(options, runs, solvers)
    ending.claim = f"what is complete is in {options.target}; the same command goes on with the rest"
    lines = {each.run.name: each for each in (*done, *failed)}
    _tell_start(options, len(runs), len(done))
    for place, each in enumerate(failed, len(done) + 1):
        _tell(options, each, place, len(runs))
    _work(options, runs, lines, commands)
    return [lines[each.name] for each in runs]


def _check_target(options: RunsOptions) -> None:
    """Refuse a folder that is none of such runs.

    Raises:
        PackgenError: It is one.
    """
    from packgen.resultfolder import MANIFEST

    target = options.target
    if target.exists() and not target.is_dir():
        raise PackgenError(f"{target}: is a file, expected a folder; choose another with -o")
    if (target / MANIFEST).exists():
        raise PackgenError(
            f"{target}: is the result of one run, expected a folder for many; choose another with -o"
        )
    table = target / options.table
    if table.exists() and not table.read_bytes().startswith(b"folder,"):
        raise PackgenError(f"{table}: is no table of this command; choose another folder with -o")


def _sorted(
    options: RunsOptions, runs: Sequence[Run], solvers: Sequence[str]
) -> tuple[list[Line], list[Line], list[tuple[Run, list[str]]]]:
    """Return the lines of complete runs, those of runs whose scene is wrong, and the commands of the others.

    Raises:
        SceneError: The scene is wrong in every run.
    """
    from packgen.scene import load_scene
    from packgen.sweep.table import Line, is_done, line_of_folder

    done, failed, commands = [], [], []
    first: SceneError | None = None
    for run in runs:
        folder = options.target / run.name
        try:
            scene = load_scene(options.scene, [*options.changes, *run.changes()])
        except SceneError as error:
            first = first or error
            failed.append(Line(run, error.exit_code, {}, "; ".join(error.problems)))
            continue
        if is_done(folder, scene, options.export, solvers):
            done.append(line_of_folder(run, folder))
        else:
            commands.append((run, _command(options, run, folder)))
    if first is not None and len(failed) == len(runs):
        raise first
    return done, failed, commands


def _command(options: RunsOptions, run: Run, folder: Path) -> list[str]:
    """Return the arguments of a run."""
    from packgen.cores import free_cores

    threads = options.threads or max(1, free_cores() // options.jobs)
    # As a path, so that a scene called `report` is no command.
    scene = str(options.scene) if options.scene.is_absolute() else f"./{options.scene}"
    arguments = [scene, "-o", str(folder), "--threads", str(threads), "--quiet", *options.passed]
    for text in (*options.changes, *run.settings()):
        arguments += ["--set", text]
    for name in options.export:
        arguments += ["--export", name]
    for text in options.export_option:
        arguments += ["--export-option", text]
    if options.templates is not None:
        arguments += ["--templates", str(options.templates)]
    if options.validate:
        arguments += ["--validate"]
    for name in options.solver:
        arguments += ["--solver", name]
    return arguments


def _work(
    options: RunsOptions,
    runs: Sequence[Run],
    lines: dict[str, Line],
    commands: Sequence[tuple[Run, list[str]]],
) -> None:
    """Make what is to be made; the table always has what is known so far."""
    from packgen.sweep import processes
    from packgen.sweep.table import Line, line_of_folder, write_table

    options.target.mkdir(parents=True, exist_ok=True)

    def write() -> None:
        known = [lines[each.name] for each in runs if each.name in lines]
        write_table(options.target / options.table, runs, known)

    write()
    for ended in processes.run_all(commands, options.jobs):
        run = ended.key
        if ended.code in (0, 1) and (options.target / run.name).is_dir():
            line = line_of_folder(run, options.target / run.name)
        else:
            line = Line(run, ended.code, {}, _reason(ended.said, ended.code))
        lines[run.name] = line
        write()
        _tell(options, line, len(lines), len(runs))


def _reason(said: str, code: int) -> str:
    """Return why a run has no bed, from what it wrote on standard error."""
    texts = [each.removeprefix("packgen: ") for each in said.splitlines() if each.startswith("packgen: ")]
    reasons = [each for each in texts if not each.startswith("warning: ")]
    return "; ".join(reasons) or (said.strip().splitlines() or [f"ended with exit code {code}"])[-1]


def _tell_start(options: RunsOptions, count: int, done: int) -> None:
    if not options.quiet:
        before = f", {done:,} of them complete already" if done else ""
        say(f"packgen: {count:,} runs{before}", sys.stderr)


def _tell(options: RunsOptions, line: Line, place: int, count: int) -> None:
    """Say how a run ended; of those that are complete only where progress is wanted."""
    where = f"packgen: {place} of {count}: {line.run.label()}"
    if line.exit_code == 0:
        solid = line.figures["solid_fraction_core"] or line.figures["solid_fraction_filled"]
        if not options.quiet:
            say(f"{where}: complete, solid fraction {solid:.4f}, {line.figures['seconds']:.1f} s", sys.stderr)
    else:
        verdict = "missed" if line.exit_code == 1 and line.figures else "failed"
        say(f"{where}: {verdict}: {line.message}", sys.stderr)
