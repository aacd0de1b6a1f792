"""``packgen sweep SCENE --over KEY=VALUES ...``: a folder a combination of values, and one table of all."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.ending import Ending
from packgen.cli.options import command_parser
from packgen.cli.runs import RunsOptions, add_runs, make_runs, runs_options, solvers_of
from packgen.cli.screen import say, say_json
from packgen.errors import PackgenError

if TYPE_CHECKING:
    from packgen.sweep.over import Run
    from packgen.sweep.table import Line

DESCRIPTION = "Run a scene with all combinations of some values: a folder each, and one table, sweep.csv."
EPILOG = """values: YAML with commas between, or a range FIRST:LAST or FIRST:LAST:STEP, both ends included

a combination whose folder is complete is not run again; the same command goes on with a sweep that
was interrupted, and runs again what failed

exit codes: 0 all beds are complete; 1 the table has lines of beds that are not, or failed;
2 wrong input, nothing written; 130 interrupted, what is complete stays"""


def build_sweep_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen sweep``."""
    parser = command_parser("sweep", DESCRIPTION, EPILOG)
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (YAML)")
    parser.add_argument(
        "--over",
        metavar="KEY=VALUES",
        action="append",
        default=[],
        help="key of the scene and its values, such as seed=0:9 or materials.glass.friction=0.1,0.3; "
        "may be repeated",
    )
    add_runs(parser, "sweep")
    return parser


def run_sweep_command(command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run ``packgen sweep``.

    Args:
        command: Its name; there is but one.
        arguments: What follows it.
        ending: Told what is true of the runs.

    Returns:
        The exit code.

    Raises:
        PackgenError: An option or the scene is wrong, for every run alike.
    """
    options, given = runs_options(build_sweep_parser(), command, arguments)
    solvers = solvers_of(options)
    table = make_runs(options, _runs(given["over"], options.changes), solvers, ending)
    code = int(any(each.exit_code != 0 for each in table))
    ending.done(code, f"the table is in {options.target}")
    _conclude(options, table)
    return code


def _runs(texts: Sequence[str], changes: Sequence[str]) -> list[Run]:
    from packgen.sweep.over import parse_over, runs_over

    if not texts:
        raise PackgenError("--over: found none, expected a key and its values, such as --over seed=0:9")
    faults, overs = [], []
    for text in texts:
        try:
            overs.append(parse_over(text))
        except PackgenError as error:
            faults.append(str(error))
    if faults:
        raise PackgenError("\n".join(faults))
    fixed = {text.partition("=")[0].strip() for text in changes}
    both = [each.key for each in overs if each.key in fixed]
    if both:
        raise PackgenError(f"--set {both[0]}: found beside --over {both[0]}; leave one of them out")
    return runs_over(overs)


def _conclude(options: RunsOptions, table: Sequence[Line]) -> None:
    counts = {
        "complete": sum(each.exit_code == 0 for each in table),
        "missed something": sum(each.exit_code == 1 and bool(each.figures) for each in table),
        "failed": sum(not each.figures for each in table),
    }
    if options.json:
        say_json({"folder": str(options.target.resolve()), "runs": [each.row() for each in table]})
    elif not options.quiet:
        said = ", ".join(f"{count:,} {name}" for name, count in counts.items() if count)
        say(f"{said}; written to {options.target / options.table}", sys.stdout)
