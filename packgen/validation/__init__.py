"""Does a solver agree that this is a bed at rest? Runs it on the written deck and measures.

Step 0 tells whether anything overlaps: every contact force is compared with Hertz' law and with a sphere's
weight. A gravity run tells whether the bed stands: what is lost, how far spheres move, how much the bed
sinks. The deck is copied to a scratch folder and included there unedited.

Example::

    report = validate(bed, Path("furnace/liggghts"), solver="liggghts", limits=Limits())
    print(report.passed, report.missed)

`validate_decks` lets several solvers judge a result folder, and writes its ``validation.json``.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path

from packgen.bed import Bed
from packgen.errors import SolverError
from packgen.leftovers import SCRATCH, owner
from packgen.measure.forces import PredictedForces, predicted_forces
from packgen.stopping import answer, held, stop_seen
from packgen.validation import lammps, liggghts, yade
from packgen.validation.process import SOLVERS, find_solver
from packgen.validation.results import (
    GravityRun,
    Limits,
    Row,
    SolverReport,
    StepZero,
    comparison,
    validation_dict,
)
from packgen.validation.verdict import Verdict

__all__ = [
    "GravityRun",
    "Limits",
    "PredictedForces",
    "Row",
    "SolverReport",
    "StepZero",
    "Verdict",
    "comparison",
    "find_solver",
    "predicted_forces",
    "validate",
    "validate_decks",
    "validation_dict",
]

VALIDATION = "validation.json"

OnProgress = Callable[[str, float], None]

_Measure = Callable[[Bed, Path, Limits, Callable[[str, float], None] | None], SolverReport]
_MEASURES: Mapping[str, _Measure] = {
    "liggghts": liggghts.measure,
    "lammps": lammps.measure,
    "yade": yade.measure,
}


def validate(
    bed: Bed,
    deck_folder: Path,
    *,
    solver: str = "liggghts",
    limits: Limits | None = None,
    on_progress: OnProgress | None = None,
) -> SolverReport:
    """Let a solver run a written deck, and measure.

    Args:
        bed: The bed that the deck was written from.
        deck_folder: The deck; nothing in it is changed.
        solver: Name of the solver.
        limits: What the bed has to keep to; None: the defaults.
        on_progress: Called with the name of the stage and the share of it that is done, 0 to 1.

    Returns:
        What was measured; a missed limit is no error, the report has it.

    Raises:
        SolverError: The solver is missing or unknown (exit code 2), or it crashed, hung, was killed or
            printed garbage (exit code 1); with the solver's own message.
    """
    find_solver(solver)
    if bed.count == 0:
        raise SolverError(f"{solver}: the bed holds no spheres: nothing to validate")
    with _scratch() as scratch:
        folder = scratch / "deck"
        try:
            shutil.copytree(deck_folder, folder, ignore=shutil.ignore_patterns("post", "log.*"))
        except (OSError, shutil.Error) as error:
            raise SolverError(f"{solver}: the deck cannot be copied: {error}") from error
        return _MEASURES[solver](bed, folder, limits or Limits(), on_progress)


def validate_decks(
    bed: Bed,
    folder: Path,
    solvers: Sequence[str],
    *,
    limits: Limits | None = None,
    progress: Callable[[str], AbstractContextManager[OnProgress | None]] = lambda _: nullcontext(),
) -> Verdict:
    """Let solvers run the decks of a result folder one after another, and write ``validation.json`` there.

    A solver that fails says so in the verdict; the others have their turn all the same. A stop ends the
    solver that runs and leaves out the rest: the verdict says so, and the stop is answered.

    Args:
        bed: The bed that the decks were written from.
        folder: The result folder, with a deck in a folder of each solver's name.
        solvers: Names of the solvers.
        limits: What the bed has to keep to; None: the defaults.
        progress: Gives for a solver's name the context in which it runs, which gives what is told of its
            progress; see `validate`.

    Returns:
        What each solver found.
    """
    reports: dict[str, SolverReport] = {}
    errors: dict[str, str] = {}
    interrupted = False
    for solver in solvers:
        if not (folder / solver).is_dir():
            errors[solver] = f"{solver}: has no deck to run"
            continue
        try:
            with progress(solver) as tell:
                reports[solver] = validate(
                    bed, folder / solver, solver=solver, limits=limits, on_progress=tell
                )
        except (Exception, KeyboardInterrupt) as error:
            if isinstance(error, KeyboardInterrupt) or stop_seen():
                answer()
                interrupted = True
                errors[solver] = f"{solver}: interrupted before it was done"
                break
            if not isinstance(error, SolverError):
                raise
            errors[solver] = str(error)
    verdict = Verdict(reports, errors, interrupted)
    verdict.write(folder / VALIDATION)
    return verdict


@contextmanager
def _scratch() -> Iterator[Path]:
    """Make a temporary folder; it is named after this process, so that a later one removes it if need be."""
    with held():
        path = Path(tempfile.mkdtemp(prefix=f"{SCRATCH}{owner()}-"))
    try:
        yield path
    finally:
        with held():
            shutil.rmtree(path, ignore_errors=True)


assert set(_MEASURES) == set(SOLVERS)
