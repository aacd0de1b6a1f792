"""The command line: parser, errors, exit codes. What a run does is in ``packgen.cli.run``.

This package alone knows both packgen and the exporters. What is imported here is paid for by ``--help``.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NoReturn

from packgen import __version__
from packgen.cli.screen import DEBUG_VARIABLE, say
from packgen.errors import PackgenError
from packgen.results import DISK_FULL

COMMANDS = ("report", "compare")
EXIT_INTERRUPTED = 130

DESCRIPTION = (
    "Arrange the spheres of a scene as gravity would have, and write decks that DEM solvers run unedited."
)
EPILOG = """other commands:
  packgen report DIR        make the report of a result folder again
  packgen compare DIR ...   put result folders side by side

exit codes: 0 complete and within tolerance; 1 written, but something asked for was not reached;
2 wrong input, nothing written; 130 interrupted, nothing written"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Arguments without the program's name; None: those of the process.

    Returns:
        The exit code.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with _stopped_by("SIGTERM", "SIGHUP"):
            return _dispatch(given)
    except PackgenError as error:
        return _fail(str(error), error.exit_code)
    except KeyboardInterrupt:
        return _fail("interrupted, nothing was written", EXIT_INTERRUPTED)
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        remedy = "; make room, or choose another disk with -o" if error.errno in DISK_FULL else ""
        return _fail(f"{place}{error.strerror or error}; nothing was written{remedy}", 2)
    except MemoryError:
        return _fail("not enough memory for this scene; nothing was written", 2)
    except Exception as error:  # the last line of defence: a traceback helps nobody but us
        if os.environ.get(DEBUG_VARIABLE):
            traceback.print_exc()
        return _fail(
            f"sorry, this is a fault of packgen, not of your scene: {type(error).__name__}: {error}; "
            f"nothing was written; {DEBUG_VARIABLE}=1 shows where it happened",
            2,
        )


@contextmanager
def _stopped_by(*names: str) -> Iterator[None]:
    """Let signals stop the run as Ctrl-C does, so that it tidies up."""

    def stop(_number: int, _frame: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt

    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]  # Windows has no SIGHUP
    if threading.current_thread() is not threading.main_thread():
        numbers = []  # Python handles signals in the main thread only
    # What is ignored stays so: nohup means it.
    former = {number: signal.getsignal(number) for number in numbers}
    former = {number: handler for number, handler in former.items() if handler not in (signal.SIG_IGN, None)}
    for number in former:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)


def _fail(message: str, code: int) -> int:
    for line in message.splitlines() or [""]:
        say(f"packgen: {line}", sys.stderr)
    return code


def _dispatch(arguments: list[str]) -> int:
    if arguments and arguments[0] in COMMANDS:
        from packgen.cli.pages import run_page_command

        return run_page_command(arguments[0], arguments[1:])
    options = build_parser().parse_args(arguments)
    from packgen.cli.run import run_scene

    return run_scene(options)


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
    parser.add_argument(
        "--export",
        metavar="NAME",
        action="append",
        default=[],
        help="deck to write, such as liggghts; may be repeated, or a comma list",
    )
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help="result folder (default: named after the scene)"
    )
    parser.add_argument("--validate", action="store_true", help="confirm the bed in a solver")
    parser.add_argument(
        "--solver",
        metavar="NAME",
        action="append",
        default=[],
        help="solver for --validate (default: liggghts); may be repeated, or a comma list",
    )
    parser.add_argument("--seed", metavar="N", type=_whole(0), help="seed, in place of the scene's")
    parser.add_argument("--threads", metavar="N", type=_whole(1), help="threads (default: chosen by packgen)")
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cpu", help="where to compute")
    parser.add_argument(
        "--templates", metavar="DIR", type=Path, help="folder whose deck templates replace packgen's own"
    )
    parser.add_argument(
        "--export-option",
        metavar="NAME.KEY=VALUE",
        action="append",
        default=[],
        help="option of an exporter, such as fraction.cell_size=0.2; may be repeated",
    )
    parser.add_argument(
        "--force", action="store_true", help="set a folder with foreign files aside, as DIR.old"
    )
    parser.add_argument(
        "--picture", action="store_true", help="draw the bed, whole and cut in half: bed.png, bed_half.png"
    )
    parser.add_argument("--no-report", action="store_true", help="make no report.html")
    parser.add_argument(
        "--quiet", action="store_true", help="no progress, no summary; what was missed is said"
    )
    parser.add_argument("--version", action="version", version=f"packgen {__version__}")
    return parser


def _whole(least: int) -> Callable[[str], int]:
    """Return a reader of whole numbers of at least ``least``."""

    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number, at least {least}")
        return value

    return read
