"""What the command line asks of a run, as typed values."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from packgen.units import to_si


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The options of ``packgen SCENE``.

    Attributes:
        scene: The scene file.
        changes: Values in place of the scene's, each ``KEY=VALUE``.
        export: Names of the decks to write, each once.
        output: The result folder; None: named after the scene.
        validate: Whether solvers confirm the bed.
        solver: Names of these solvers, each once; empty: the default one.
        settle: The solver that settles the bed; None: none does.
        until: How long it does [s]; infinite: until the bed is still; None: not said, which means the same.
        seed: Seed in place of the scene's; None: the scene's.
        threads: Threads of the arrangement and of the measures; None: as many as cores are free.
        device: Where to compute, ``cpu`` or ``cuda``.
        workers: Processes of this machine that share the work; None: this one does all of it.
        scheduler: Address of a Dask scheduler whose workers share it; None: none does.
        resume: Whether to go on with the parts of a run that did not end.
        pieces: Whether the bed is left in pieces, and never held as a whole.
        templates: Folder whose deck templates replace packgen's own; None: none does.
        export_option: Options of exporters, each ``NAME.KEY=VALUE``.
        force: Whether a folder with foreign files is set aside.
        picture: Whether to draw the bed.
        page: Whether to make ``report.html``.
        quiet: Whether to leave out progress and summary.
        json: Whether the summary is a JSON object.
    """

    scene: Path
    changes: tuple[str, ...] = ()
    export: tuple[str, ...] = ()
    output: Path | None = None
    validate: bool = False
    solver: tuple[str, ...] = ()
    settle: str | None = None
    until: float | None = None
    seed: int | None = None
    threads: int | None = None
    device: str = "cpu"
    workers: int | None = None
    scheduler: str | None = None
    resume: bool = False
    pieces: bool = False
    templates: Path | None = None
    export_option: tuple[str, ...] = ()
    force: bool = False
    picture: bool = False
    page: bool = True
    quiet: bool = False
    json: bool = False

    @property
    def shared(self) -> bool:
        """Whether several processes share the work."""
        return self.workers is not None or self.scheduler is not None

    @property
    def target(self) -> Path:
        """The result folder."""
        return self.output or Path(self.scene.stem)


def run_options(parsed: argparse.Namespace) -> RunOptions:
    """Return what the parser of ``packgen SCENE`` has read."""
    return RunOptions(
        scene=parsed.scene,
        changes=tuple(parsed.set),
        export=names_in(parsed.export),
        output=parsed.output,
        validate=parsed.validate,
        solver=names_in(parsed.solver),
        settle=parsed.settle,
        until=parsed.until,
        seed=parsed.seed,
        threads=parsed.threads,
        device=parsed.device,
        workers=parsed.workers,
        scheduler=parsed.scheduler,
        resume=parsed.resume,
        pieces=parsed.pieces,
        templates=parsed.templates,
        export_option=tuple(parsed.export_option),
        force=parsed.force,
        picture=parsed.picture,
        page=not parsed.no_report,
        quiet=parsed.quiet,
        json=parsed.json,
    )


def names_in(given: Sequence[str]) -> tuple[str, ...]:
    """Return names from repeated options and comma lists, each once."""
    return tuple(dict.fromkeys(name.strip() for each in given for name in each.split(",") if name.strip()))


def command_parser(command: str, description: str, epilog: str | None = None) -> argparse.ArgumentParser:
    """Return a parser of a command that has no arguments yet.

    Args:
        command: Its name.
        description: What it does.
        epilog: What follows the arguments, as it stands; None: nothing.
    """
    return argparse.ArgumentParser(
        prog=f"packgen {command}",
        description=f"{description} A scene of that name is ./{command}.",
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )


def add_changes(parser: argparse.ArgumentParser) -> None:
    """Add the option that gives values in place of a scene's."""
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="value in place of the scene's, as YAML, such as zones[0].n_particles=500; may be repeated",
    )


def add_formats(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the options that say which formats are written, and how.

    Args:
        parser: Gets them.
        what: What is written: ``deck`` or ``format``.
    """
    parser.add_argument(
        "--export",
        metavar="NAME",
        action="append",
        default=[],
        help=f"{what} to write, such as liggghts; may be repeated, or a comma list",
    )
    parser.add_argument(
        "--export-option",
        metavar="NAME.KEY=VALUE",
        action="append",
        default=[],
        help="option of an exporter, such as fraction.cell_size=0.2; may be repeated",
    )
    parser.add_argument(
        "--templates", metavar="DIR", type=Path, help="folder whose deck templates replace packgen's own"
    )


def add_results(parser: argparse.ArgumentParser, source: str, threads: str) -> None:
    """Add the options that say where results go, what is drawn and what is said.

    Args:
        parser: Gets them.
        source: What the result folder is named after.
        threads: What ``--threads`` is for.
    """
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help=f"result folder (default: named after the {source})"
    )
    parser.add_argument("--threads", metavar="N", type=whole(1), help=threads)
    parser.add_argument(
        "--force", action="store_true", help="set a folder with foreign files aside, as DIR.old"
    )
    parser.add_argument(
        "--picture", action="store_true", help="draw the bed, whole and cut in half: bed.png, bed_half.png"
    )
    parser.add_argument("--no-report", action="store_true", help="make no report.html")
    parser.add_argument("--quiet", action="store_true", help="show warnings and what was missed alone")


def add_solvers(parser: argparse.ArgumentParser) -> None:
    """Add the options by which solvers settle the bed and confirm it."""
    parser.add_argument(
        "--settle",
        metavar="SOLVER",
        help="let a solver settle the bed under its own friction: liggghts, lammps or yade",
    )
    parser.add_argument(
        "--until",
        metavar="still|TIME",
        type=_until,
        help="how long: until it is still (default), or a time, such as 0.5s; Ctrl-C keeps what is reached",
    )
    parser.add_argument("--validate", action="store_true", help="confirm the bed in a solver")
    parser.add_argument(
        "--solver",
        metavar="NAME",
        action="append",
        default=[],
        help="solver for --validate (default: liggghts); may be repeated, or a comma list",
    )


def _until(text: str) -> float:
    """Return a time [s], infinite for ``still``."""
    if text == "still":
        return math.inf
    try:
        time = to_si(text, "time")
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected still, or {error}") from error
    if not 0.0 < time < math.inf:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected still, or a time greater than 0")
    return time


def length(text: str) -> float:
    """Read a length [m] above 0, such as ``5mm``."""
    try:
        value = to_si(text, "length")
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected {error}") from error
    if not 0.0 < value < 1.0e6:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a length greater than 0")
    return value


def share(text: str) -> float:
    """Read a share between 0 and 1."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a share between 0 and 1, such as 0.01")
    return value


def whole(least: int) -> Callable[[str], int]:
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
