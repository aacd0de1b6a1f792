"""Runs random scenes: ``python -m tests.fuzz --scenes 200``; a line a fault, and exit code 1."""

from __future__ import annotations

import argparse
import collections
import multiprocessing
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from tests.fuzz.decks import PROGRAMS, installed
from tests.fuzz.run import SOLVED_EACH, Outcome, run_number

TELL_EACH = 250
FAILED = -2  # stands for the exit code of a scene at which the fuzzer itself failed


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the scenes that the command line names; return 1 where one has a fault."""
    options = _parser().parse_args(arguments)
    numbers = range(options.first, options.first + options.scenes)
    numbers = numbers if options.scene is None else range(options.scene, options.scene + 1)
    solvers = [each for each in installed() if each in options.solvers]
    work = partial(_run, solvers=solvers, every=options.solve_every, keep=options.keep)
    start, outcomes = time.perf_counter(), []
    for outcome in _outcomes(work, numbers, options.processes):
        outcomes.append(outcome)
        for fault in outcome.faults:
            broken = f" [{outcome.broken}]" if outcome.broken else ""
            print(f"scene {outcome.number}: {fault}{broken}; python -m tests.fuzz --scene {outcome.number}"
                  f" --keep DIR", flush=True)  # fmt: skip
        if len(outcomes) % TELL_EACH == 0:
            print(_summary(outcomes, time.perf_counter() - start), file=sys.stderr, flush=True)
        if options.slow and outcome.seconds > options.slow:
            print(f"scene {outcome.number}: took {outcome.seconds:.1f} s", flush=True)
    print(_summary(outcomes, time.perf_counter() - start))
    return 1 if any(each.faults for each in outcomes) else 0


def _outcomes(work: partial[Outcome], numbers: range, processes: int) -> Iterator[Outcome]:
    if processes == 1:
        yield from map(work, numbers)
        return
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        yield from pool.imap_unordered(work, numbers, chunksize=5)


def _run(number: int, *, solvers: Sequence[str], every: int, keep: Path | None) -> Outcome:
    folder = Path(tempfile.mkdtemp(prefix="packgen_fuzz_"))
    try:
        outcome = _judged(number, folder, solvers, every)
        if keep is not None and outcome.faults:
            shutil.copytree(folder, keep / f"scene_{number}", dirs_exist_ok=True)
        return outcome
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _judged(number: int, folder: Path, solvers: Sequence[str], every: int) -> Outcome:
    """Run a scene; a fault of the fuzzer itself is told as one of the scene, and the next scenes follow."""
    try:
        return run_number(number, folder, solvers, every=every)
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(frame.filename).name}:{frame.lineno}"
        fault = f"the fuzzer fails at {place}: {type(error).__name__}: {error}"
        return Outcome(number, FAILED, 0, 0.0, (fault,))


def _summary(outcomes: Sequence[Outcome], seconds: float) -> str:
    codes = collections.Counter(each.code for each in outcomes)
    refused = sum(each.code == 2 and not each.broken for each in outcomes)
    return (
        f"{len(outcomes)} scenes in {seconds:.0f} s, {sum(each.spheres for each in outcomes):,} spheres; "
        "exit codes "
        + ", ".join(f"{code}: {count}" for code, count in sorted(codes.items()))
        + f"; {sum(bool(each.broken) for each in outcomes)} broken on purpose, {refused} others refused; "
        f"{sum(bool(each.loaded) for each in outcomes)} decks loaded; "
        f"{sum(bool(each.faults) for each in outcomes)} with faults"
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--scenes", type=int, default=200, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--scene", type=int, help="this one alone")
    parser.add_argument("--processes", type=int, default=1, help="how many at a time")
    parser.add_argument(
        "--solvers", nargs="*", default=[], choices=[*PROGRAMS], help="solvers that load decks"
    )
    parser.add_argument("--solve-every", type=int, default=SOLVED_EACH, help="one deck of so many scenes")
    parser.add_argument("--keep", type=Path, help="folder for the faulty scenes and their results")
    parser.add_argument("--slow", type=float, help="tell the scenes that take longer [s]")
    return parser


if __name__ == "__main__":
    sys.exit(main())
