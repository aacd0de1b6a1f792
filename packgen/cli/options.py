"""What the command line asks of a run, as typed values."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The options of ``packgen SCENE``.

    Attributes:
        scene: The scene file.
        export: Names of the decks to write, each once.
        output: The result folder; None: named after the scene.
        validate: Whether solvers confirm the bed.
        solver: Names of these solvers, each once; empty: the default one.
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
    """

    scene: Path
    export: tuple[str, ...] = ()
    output: Path | None = None
    validate: bool = False
    solver: tuple[str, ...] = ()
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
        export=names_in(parsed.export),
        output=parsed.output,
        validate=parsed.validate,
        solver=names_in(parsed.solver),
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
    )


def names_in(given: Sequence[str]) -> tuple[str, ...]:
    """Return names from repeated options and comma lists, each once."""
    return tuple(dict.fromkeys(name.strip() for each in given for name in each.split(",") if name.strip()))


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
