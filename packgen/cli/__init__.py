"""The command line: parser, errors, exit codes. What a run does is in ``packgen.cli.run``.

This package alone knows both packgen and the exporters. Imports here slow down ``--help``.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

from packgen.cli.ending import Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import add_changes, add_formats, add_results, add_solvers, run_options, whole
from packgen.cli.screen import DEBUG_VARIABLE, open_streams, show
from packgen.errors import PackgenError
from packgen.resultfolder import DISK_FULL
from packgen.stopping import close, stop_seen, stoppable
from packgen.version import __version__

COMMANDS = {
    "report": ("packgen.cli.pages", "run_page_command"),
    "compare": ("packgen.cli.pages", "run_page_command"),
    "measure": ("packgen.cli.judge", "run_file_command"),
    "convert": ("packgen.cli.judge", "run_file_command"),
    "carve": ("packgen.cli.reshape", "run_reshape_command"),
    "repeat": ("packgen.cli.reshape", "run_reshape_command"),
    "clump": ("packgen.cli.clump", "run_clump_command"),
    "plan": ("packgen.cli.forecast", "run_plan_command"),
    "sweep": ("packgen.cli.sweep", "run_sweep_command"),
    "contest": ("packgen.cli.contest", "run_contest_command"),
    "init": ("packgen.cli.start", "run_start_command"),
    "schema": ("packgen.cli.start", "run_start_command"),
}
"""Commands beside ``packgen SCENE``: the module of each, imported where it is given, and its function.

A function takes the command, what follows it, and how it ends."""

DESCRIPTION = (
    "Arrange the spheres of a scene as gravity would have, and write decks that DEM solvers run unedited."
)
EPILOG = """other commands:
  packgen report DIR         make the report of a result folder again
  packgen compare DIR ...    put result folders side by side
  packgen measure FILE       check and measure a bed from a file of any format
  packgen convert FILE       write a bed from a file in other formats
  packgen carve FILE         keep the part of a bed inside or outside a closed mesh
  packgen repeat FILE N N N  put copies of a bed that wraps around side by side
  packgen clump MESH         fill a stone, or a shape such as ring, with the spheres of a rigid clump
  packgen plan SCENE         tell what the bed will be like, and what will be missed
  packgen sweep SCENE        run a scene with all combinations of some values
  packgen contest SCENE      run a scene by several algorithms, in one table and one page
  packgen init KIND          write a scene to start from: box, tube, or the path of a mesh
  packgen schema             show the JSON Schema of scenes, for editors

exit codes: 0 complete and within tolerance; 1 written, but something asked for was not reached;
2 wrong input, nothing written;
130 interrupted, nothing written, but a bed whose validation was interrupted is in DIR.unvalidated,
one that was interrupted while it settled is in DIR.unsettled,
and what processes that share a bed have done in DIR.parts"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Arguments without the program's name; None: those of the process.

    Returns:
        The exit code.
    """
    open_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    ending = Ending()
    try:
        with stoppable(ending.interrupted, for_good=arguments is None):
            return _run(given, ending)
    finally:
        show("", sys.stdout)  # what argparse has left there
        if ending.was_interrupted and arguments is None:
            # Python would wait for threads, or end by SIGINT where one has come while C code ran some Python.
            os._exit(ending.interrupted())


def _run(arguments: list[str], ending: Ending) -> int:
    """Run a command and say what ended it; what is said of its results is true at that moment."""
    try:
        return _dispatch(arguments, ending)
    except KeyboardInterrupt:
        close()
        return ending.interrupted()
    except Exception as error:
        close()
        if stop_seen():  # compiled code makes another error of it
            return ending.interrupted()
        return ending.fail(_reason(error, ending.claim), getattr(error, "exit_code", 2))


def _reason(error: Exception, claim: str) -> str:
    """Return a line that says what ended a run, with what is true of its results."""
    if isinstance(error, PackgenError):
        return str(error)
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        remedy = "; make room, or choose another disk with -o" if error.errno in DISK_FULL else ""
        return f"{place}{error.strerror or error}; {claim}{remedy}"
    if isinstance(error, MemoryError):
        return f"not enough memory for this scene; {claim}"
    # The last line of defence: a traceback helps nobody but us.
    if os.environ.get(DEBUG_VARIABLE):
        traceback.print_exception(error)
    return (
        f"sorry, this is a fault of packgen, not of your scene: {type(error).__name__}: {error}; "
        f"{claim}; {DEBUG_VARIABLE}=1 shows where it happened"
    )


def _dispatch(arguments: list[str], ending: Ending) -> int:
    refuse_unreadable(arguments)
    if arguments and arguments[0] in COMMANDS:
        module, function = COMMANDS[arguments[0]]
        run: Callable[[str, list[str], Ending], int] = getattr(import_module(module), function)
        return run(arguments[0], arguments[1:], ending)
    options = run_options(build_parser().parse_args(arguments))
    from packgen.cli.run import run_scene

    return run_scene(options, ending)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen SCENE``."""
    parser = argparse.ArgumentParser(
        prog="packgen",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (YAML)")
    add_changes(parser)
    add_formats(parser, "deck")
    add_solvers(parser)
    parser.add_argument("--seed", metavar="N", type=whole(0), help="seed, in place of the scene's")
    _add_crews(parser)
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cpu", help="where to compute")
    add_results(
        parser,
        "scene",
        "threads of the arrangement and of the measures; the bed is the same for any number (default: "
        "as many as cores are free to packgen; one for the optimizer adam)",
    )
    parser.add_argument(
        "--json", action="store_true", help="show the summary as a JSON object, and progress on stderr alone"
    )
    parser.add_argument("--version", action="version", version=f"packgen {__version__}")
    return parser


def _add_crews(parser: argparse.ArgumentParser) -> None:
    """Add the options by which processes share the work."""
    parser.add_argument(
        "--workers",
        metavar="N",
        type=whole(1),
        help="make the bed in tiles by so many processes of this machine; it is the same for any number",
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="make the bed in tiles by the workers of a Dask scheduler"
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="go on with a run by --workers or --scheduler that did not end, from DIR.parts",
    )
    parser.add_argument(
        "--pieces",
        action="store_true",
        help="leave the bed of --workers or --scheduler in pieces, manifest.json and a file each, in place "
        "of bed.npz: no process holds all of it",
    )
