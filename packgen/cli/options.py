"""What the command line asks of a run, as typed values."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
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
