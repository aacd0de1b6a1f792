"""``packgen contest SCENE --algorithms A,B``: a scene by several algorithms, in one table and one page."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.ending import Ending
from packgen.cli.options import command_parser, names_in, whole
from packgen.cli.runs import RunsOptions, add_runs, make_runs, runs_options, solvers_of
from packgen.cli.screen import say, say_json, table

if TYPE_CHECKING:
    from packgen.contest import Standing
    from packgen.scene import Scene
    from packgen.sweep.over import Run

DESCRIPTION = (
    "Run a scene by several algorithms: a folder each, one table, contest.csv, and one page, contest.html."
)
EPILOG = """the scene's own algorithm keeps its params, another one has its defaults and the scene's tolerance

one that cannot do the scene says why; the others go on. A run whose folder is complete is not run again

exit codes: 0 each algorithm made its beds, or said why it cannot do the scene; 1 a bed misses something, or
a run failed; 2 wrong input, or no algorithm can do the scene, nothing written; 130 interrupted, what is
complete stays"""


def build_contest_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen contest``."""
    parser = command_parser("contest", DESCRIPTION, EPILOG)
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (YAML)")
    parser.add_argument(
        "--algorithms",
        metavar="NAME",
        action="append",
        default=[],
        help="algorithm to run; may be repeated, or a comma list (default: all)",
    )
    parser.add_argument(
        "--seeds",
        metavar="N",
        type=whole(1),
        default=1,
        help="seeds of each, from the scene's on (default: 1)",
    )
    add_runs(parser, "contest")
    return parser


def run_contest_command(command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run ``packgen contest``.

    Args:
        command: Its name; there is but one.
        arguments: What follows it.
        ending: Told what is true of the runs.

    Returns:
        The exit code.

    Raises:
        PackgenError: An option is wrong, or the scene for every algorithm alike.
    """
    options, given = runs_options(build_contest_parser(), command, arguments)
    from packgen.contest import entries, known_algorithms, standings
    from packgen.page.contest import write_contest_page
    from packgen.scene import load_scene
    from packgen.scene.changes import parse_change

    algorithms = known_algorithms(names_in(given["algorithms"]))
    solvers = solvers_of(options)
    scene = load_scene(options.scene, [parse_change(each) for each in options.changes])
    runs = entries(scene, algorithms, given["seeds"])
    lines = make_runs(options, runs, solvers, ending)
    found = standings(lines, options.target, _may_change(options, runs), {scene.algorithm: _settings(scene)})
    page = write_contest_page(options.target, scene.path.stem, found)
    code = int(any(each.exit_code not in (0, 2) for each in lines))
    ending.done(code, f"the page is {page}")
    _conclude(options, found, page)
    return code


def _may_change(options: RunsOptions, runs: Sequence[Run]) -> dict[str, str]:
    """Return what each algorithm that takes the scene may change with its settings, where it says so."""
    from packgen.arrange.traits import traits_of
    from packgen.errors import SceneError
    from packgen.scene import load_scene

    said: dict[str, str] = {}
    for run in runs:
        if run.values["algorithm"] in said:
            continue
        try:
            scene: Scene = load_scene(options.scene, [*options.changes, *run.changes()])
        except SceneError:
            continue
        said[run.values["algorithm"]] = traits_of(scene.params).may_change
    return said


def _settings(scene: Scene) -> str:
    """Return the settings that a scene gives its own algorithm, in words."""
    params = scene.params
    given = () if params is None else sorted(params.model_fields_set - {"tolerance"})
    return ", ".join(f"{name}: {getattr(params, name)}" for name in given)


def _conclude(options: RunsOptions, found: Sequence[Standing], page: Path) -> None:
    from packgen.contest import standing_rows

    if options.json:
        content = {"folder": str(options.target.resolve()), "algorithms": [each.as_dict() for each in found]}
        say_json(content)
    elif not options.quiet:
        say(table(standing_rows(found)), sys.stdout)
        for each in found:
            for line in each.reasons:
                say(f"{each.algorithm}: {line}", sys.stdout)
        say(f"written: {page}", sys.stdout)
