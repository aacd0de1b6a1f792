"""Running a solver that may be missing, crash, hang, be killed or print garbage."""

from __future__ import annotations

import contextlib
import os
import queue
import re
import shutil
import signal
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import IO

from packgen.errors import SolverError
from packgen.stopping import held

# The executable and Debian's package of each solver that validation can run.
SOLVERS = MappingProxyType(
    {"liggghts": ("liggghts", "liggghts"), "lammps": ("lmp", "lammps"), "yade": ("yade", "yade")}
)
TAIL_LINES = 200
LINE_BYTES_MAX = 65536
ERROR_LINES = 5


def find_solver(name: str, option: str = "--validate") -> Path:
    """Return the path of a solver's executable.

    Args:
        name: The solver.
        option: The option that asks for it, for messages.

    Raises:
        SolverError: It is not installed, or validation does not know it (exit code 2).
    """
    if name not in SOLVERS:
        named = "--solver" if option == "--validate" else option
        raise SolverError(f"{named}: found {name!r}, expected one of {', '.join(SOLVERS)}", exit_code=2)
    executable, package = SOLVERS[name]
    found = shutil.which(executable)
    if found is None:
        raise SolverError(
            f"{name}: the program {executable!r} is not on the PATH; install it with"
            f" `apt-get install {package}`, or leave {option} out",
            exit_code=2,
        )
    return Path(found)


def run_solver(
    name: str,
    command: Sequence[str],
    folder: Path,
    *,
    silence_max: float,
    seconds_max: float,
    on_line: Callable[[str], None] | None = None,
) -> tuple[str, ...]:
    """Run a solver to its end and return the last lines of what it printed.

    Args:
        name: What messages call it.
        command: Its executable and arguments.
        folder: Where it runs.
        silence_max: Longest silence before it counts as hung [s].
        seconds_max: Longest run before it counts as hung [s].
        on_line: Called with every line as it comes.

    Raises:
        SolverError: It does not start, reports an error, crashes, is killed or hangs (exit code 1).
    """
    # Through a pipe LIGGGHTS loses the message of a fatal error, unless lines are sent at once.
    unbuffer = [found, "-oL"] if (found := shutil.which("stdbuf")) else []
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "LC_ALL": "C"}
    tail: deque[str] = deque(maxlen=TAIL_LINES)
    with contextlib.ExitStack() as ends:
        try:
            with held():  # no stop between its start and the care for its end
                process = subprocess.Popen(
                    [*unbuffer, *command], cwd=folder, env=environment, start_new_session=True,
                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                )  # fmt: skip
                ends.callback(_end, process)
        except OSError as error:
            raise SolverError(f"{name}: does not start: {error}") from error
        try:
            for line in _lines(process, name, tail, silence_max, seconds_max):
                if on_line is not None:
                    on_line(line)
            code = process.wait(timeout=silence_max)
        except subprocess.TimeoutExpired:
            what = f"hangs: it closed its output and did not end in {silence_max:g} s"
            raise SolverError(_message(name, what, tail)) from None
    if code < 0:
        killed = signal.Signals(-code).name
        hint = "; was there enough memory?" if -code == signal.SIGKILL else ""
        raise SolverError(_message(name, f"was ended by signal {killed}{hint}", tail))
    if code > 0:
        raise SolverError(_message(name, f"stopped with exit code {code}", tail))
    return tuple(tail)


def describe_output(lines: Sequence[str]) -> str:
    """Return what a user should see of a solver's output: its error message, else its last lines."""
    shown = [text for line in lines if (text := re.sub(r"[^\x20-\x7e]", "?", line).strip())]
    for index, line in enumerate(shown):
        if "ERROR" in line:
            return "\n".join(shown[index : index + ERROR_LINES])
    return "\n".join(shown[-ERROR_LINES:]) or "(it printed nothing)"


def _lines(
    process: subprocess.Popen[bytes], name: str, tail: deque[str], silence_max: float, seconds_max: float
) -> Iterator[str]:
    """Yield the lines that a process prints, as they come; a silence that lasts ends it."""
    assert process.stdout is not None
    lines: queue.Queue[bytes | None] = queue.Queue(maxsize=10_000)
    stopped = threading.Event()
    threading.Thread(target=_read, args=(process.stdout, lines, stopped), daemon=True).start()
    end = time.monotonic() + seconds_max
    try:
        while True:
            wait = min(silence_max, end - time.monotonic())
            try:
                raw = lines.get(timeout=max(wait, 0.0))
            except queue.Empty:
                silent = wait >= silence_max
                why = (
                    f"said nothing for {silence_max:g} s" if silent else f"was not done in {seconds_max:g} s"
                )
                raise SolverError(_message(name, f"hangs: it {why} and was ended", tail)) from None
            if raw is None:
                return
            if time.monotonic() > end:
                raise SolverError(
                    _message(name, f"hangs: it was not done in {seconds_max:g} s and was ended", tail)
                )
            line = raw.decode(errors="replace").rstrip("\r\n")
            tail.append(line)
            yield line
    finally:
        stopped.set()


def _read(stream: IO[bytes], lines: queue.Queue[bytes | None], stopped: threading.Event) -> None:
    while not stopped.is_set():
        line = stream.readline(LINE_BYTES_MAX)
        while not stopped.is_set():
            try:
                lines.put(line or None, timeout=0.5)
                break
            except queue.Full:
                continue
        if not line:
            return


def _end(process: subprocess.Popen[bytes]) -> None:
    """Leave nothing of the solver running, whatever happened: Ctrl-C, a time limit, an error."""
    with held():
        if process.poll() is not None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _message(name: str, what: str, tail: Sequence[str]) -> str:
    return f"{name}: {what}; it said:\n{describe_output(tail)}"
