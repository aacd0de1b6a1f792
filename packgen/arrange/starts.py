"""Many starts of a search, each a call of one function, by this process alone or by several.

What a call returns stands on its arguments alone, so that the number of processes changes no result. The
solver of linear programmes keeps the interpreter's lock: threads would wait for each other.
"""

from __future__ import annotations

import contextlib
import pickle
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from importlib import import_module
from typing import Any

from packgen.stopping import held, tidied

WORTH = 4.0
"""Seconds of work left from which further processes are worth their start."""

__all__ = ["results_in_order", "results_of"]


def results_of(
    function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], processes: int
) -> Iterator[tuple[int, Any]]:
    """Yield what a function returns, call by call, in the order in which they end.

    Args:
        function: A function of a module; arguments and results can be pickled.
        calls: The arguments of each call.
        processes: Processes at most.

    Yields:
        Number of the call, and what it returned.
    """
    done = 0
    while done < len(calls):
        began = time.monotonic()
        yield done, function(*calls[done])
        done += 1
        if processes > 1 and (len(calls) - done) * (time.monotonic() - began) > WORTH:
            yield from _shared(function, calls, done, processes)
            return


def results_in_order(
    function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], processes: int
) -> Iterator[Any]:
    """Yield what a function returns in the order of the calls; see ``results_of``."""
    early: dict[int, Any] = {}
    following = 0
    for number, result in results_of(function, calls, processes):
        early[number] = result
        while following in early:
            yield early.pop(following)
            following += 1


def _shared(
    function: Callable[..., Any], calls: Sequence[tuple[Any, ...]], done: int, processes: int
) -> Iterator[tuple[int, Any]]:
    """Yield the results of the calls that are left, made by several processes."""
    helpers: list[subprocess.Popen[bytes]] = []

    def end() -> None:
        for each in helpers:
            each.kill()

    name = f"{function.__module__}:{function.__name__}"
    left = list(range(done, len(calls)))[::-1]
    with tidied(end), ThreadPoolExecutor(processes) as pool:
        try:
            waiting: dict[Future[Any], tuple[int, subprocess.Popen[bytes]]] = {}
            for _ in range(min(processes, len(left))):
                with held():
                    helpers.append(_helper(name))
                number = left.pop()
                waiting[pool.submit(_ask, helpers[-1], calls[number])] = number, helpers[-1]
            while waiting:
                ready, _ = wait(waiting, return_when=FIRST_COMPLETED, timeout=0.5)
                for future in ready:
                    number, helper = waiting.pop(future)
                    yield number, future.result()
                    if left:
                        following = left.pop()
                        waiting[pool.submit(_ask, helper, calls[following])] = following, helper
        finally:
            end()
            for each in helpers:
                each.communicate()


def _helper(name: str) -> subprocess.Popen[bytes]:
    # -P: the current folder may hold one called packgen.
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "packgen.arrange.starts", name],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip


def _ask(helper: subprocess.Popen[bytes], arguments: tuple[Any, ...]) -> Any:
    assert helper.stdin is not None
    assert helper.stdout is not None
    pickle.dump(arguments, helper.stdin)
    helper.stdin.flush()
    return pickle.load(helper.stdout)


def _serve(name: str) -> None:
    """Answer calls until no more come."""
    module, _, function = name.partition(":")
    called = getattr(import_module(module), function)
    reply = sys.stdout.buffer
    sys.stdout = sys.stderr  # what a library prints is no answer
    with contextlib.suppress(EOFError, BrokenPipeError):
        while True:
            pickle.dump(called(*pickle.load(sys.stdin.buffer)), reply)
            reply.flush()


if __name__ == "__main__":
    _serve(sys.argv[1])
