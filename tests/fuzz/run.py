"""One scene from its number to the verdict on its run, in this process."""

from __future__ import annotations

import contextlib
import io
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import NoReturn

import numpy as np

from packgen.cli import main
from tests.fuzz.decks import is_loadable, judge_deck
from tests.fuzz.generator import Case, has_lammps_walls, make_case
from tests.fuzz.judge import judge_folder, judge_lines, judge_refusal, read_bed
from tests.fuzz.mutations import break_case

SECONDS_MAX = 60.0
INTERRUPTED = 130
BROKEN_EACH = 10  # every so many scenes one is broken,
AGAIN_EACH = 50  # one is run twice,
SOLVED_EACH = 100  # and one is loaded by a solver where solvers are asked for


@dataclass(frozen=True)
class Outcome:
    """What became of a scene: exit code, spheres, the processor's seconds, faults, solver that loaded it."""

    number: int
    code: int
    spheres: int
    seconds: float
    faults: tuple[str, ...]
    broken: str = ""
    loaded: str = ""


def run_number(
    number: int, folder: Path, solvers: Sequence[str] = (), *, every: int = SOLVED_EACH
) -> Outcome:
    """Make a scene, run it and judge the result.

    Args:
        number: Which scene.
        folder: An existing, empty folder; scene and result stay in it.
        solvers: Solvers that load a deck.
        every: One of so many scenes is loaded by the next one of the solvers.
    """
    case = make_case(number, folder)
    solver = solvers[number // every % len(solvers)] if solvers and number % every == every // 2 else ""
    broken = number % BROKEN_EACH == BROKEN_EACH // 2 + 1
    solver = "" if broken or (solver == "lammps" and not has_lammps_walls(case.container)) else solver
    if solver and solver not in case.exports:
        case.exports.append(solver)
    if broken:
        break_case(case, np.random.default_rng([number, 23]))
    start = time.process_time()
    code, said = run_command([str(case.path), "-o", str(folder / "out"), *case.arguments])
    seconds = time.process_time() - start
    if code == INTERRUPTED:  # a broken scene may ask for a bed without end
        faults = [] if case.broken else [f"not done after {SECONDS_MAX:g} s"]
        return Outcome(number, code, 0, seconds, tuple(faults), case.broken)
    faults = judge(case, code, said)
    # A bed without spheres has no deck; nor has one whose refusal the judge has seen.
    has_deck = code in (0, 1) and not faults and (folder / "out" / solver).is_dir()
    loaded = solver if solver and has_deck and is_loadable(case) else ""
    if loaded:
        faults = judge_deck(case, loaded)
    if not faults and code in (0, 1) and number % AGAIN_EACH == AGAIN_EACH // 2:
        faults = _again(case)
    return Outcome(number, code, _count(folder), seconds, tuple(faults), case.broken, loaded)


def judge(case: Case, code: int, said: str) -> list[str]:
    """Return what is wrong with a run by its exit code, its error stream and its folder ``out``."""
    output = case.folder / "out"
    if code == 2:
        return judge_refusal(said, output, case.exports)
    if "lammps" in case.exports and not case.broken and not has_lammps_walls(case.container):
        return [f"exit code {code}, but LAMMPS has no walls for such a container"]
    if code not in (0, 1):
        return [f"exit code {code}"]
    return judge_lines(said) + judge_folder(case, output, code)


def run_command(arguments: list[str], seconds_max: float = SECONDS_MAX) -> tuple[int, str]:
    """Run packgen in this process; return the exit code and what it said on the error stream."""
    errors, late = io.StringIO(), threading.Event()
    streams = contextlib.ExitStack()
    streams.enter_context(contextlib.redirect_stdout(io.StringIO()))
    streams.enter_context(contextlib.redirect_stderr(errors))
    with streams, _stopped(seconds_max, late):
        try:
            code = main(arguments)
        except KeyboardInterrupt:
            code = INTERRUPTED
        except BaseException as error:
            errors.write(f"Traceback: {type(error).__name__}: {error}\n")
            code = -1
    if code == INTERRUPTED and not late.is_set():  # somebody wants the fuzzer to end, not the scene
        raise KeyboardInterrupt
    return code, errors.getvalue()


@contextlib.contextmanager
def _stopped(seconds: float, late: threading.Event) -> Iterator[None]:
    """Interrupt what takes more of the processor's time, as Ctrl-C does; only in a main thread."""

    def stop(_number: int, _frame: FrameType | None) -> NoReturn:
        late.set()
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    former = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, former)


def _count(folder: Path) -> int:
    path = folder / "out" / "bed.npz"
    return len(read_bed(path).radius) if path.exists() else 0


def _again(case: Case) -> list[str]:
    """Run the scene once more, with another number of threads; return what differs."""
    options = [each for each in case.arguments if each != "--quiet"]
    threads = "1" if "2" in options else "2"
    code, _ = run_command([str(case.path), "-o", str(case.folder / "again"), *options, "--threads", threads])
    first, second = (case.folder / name / "bed.npz" for name in ("out", "again"))
    if not second.exists() or first.read_bytes() != second.read_bytes():
        return [f"a second run ends with exit code {code} and another bed"]
    return []
