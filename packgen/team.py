"""Teams: threads that run one compiled loop together, each on its share, and wait for each other in it.

A loop of a team is called by each of its threads with the same arguments, but for its rank. The threads take
the same decisions, write to arrays that they share, and meet where one needs what the others have written.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import llvmlite.ir
import numba.core.cgutils
import numba.extending
import numba.np.arrayobj
import numpy as np
from numba import types
from numba.np.numpy_support import carray

from packgen.arrays import Int32Array, Int64Array
from packgen.compiled import inlined, inner_loop

# Numba does not say their types.
cgutils: Any = numba.core.cgutils
intrinsic: Any = numba.extending.intrinsic
make_array: Any = numba.np.arrayobj.make_array
ir: Any = llvmlite.ir

ARRIVED, ROUND, BROKEN = 0, 8, 16
"""Places on a board, each in a cache line of its own: threads that have come, meetings so far, a failure."""

BOARD = 24

WATCH, YIELD = 10_000, 400
"""Looks at the board before a waiting thread lets others run, and times that it does before it sleeps."""

NAP = 50
"""Length of such a sleep [us]."""

if sys.platform == "win32":
    let_others_run = types.ExternalFunction("SwitchToThread", types.int32())
    sleep_for = types.ExternalFunction("Sleep", types.void(types.uint32))
    NAP_UNITS = 1  # ms
else:
    let_others_run = types.ExternalFunction("sched_yield", types.int32())
    sleep_for = types.ExternalFunction("usleep", types.int32(types.uint32))
    NAP_UNITS = NAP


def _entry(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    array = make_array(signature.args[0])(context, builder, args[0])
    return cgutils.get_item_pointer(context, builder, signature.args[0], array, [args[1]], wraparound=False)


@intrinsic
def add_at(_typing: Any, board: Any, _place: Any, _number: Any) -> Any:
    """Add to an entry of an int64 array in one step that no thread can divide; return what it was."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.atomic_rmw("add", _entry(context, builder, signature, args), args[2], "seq_cst")

    return types.int64(board, types.int64, types.int64), generate


@intrinsic
def look_at(_typing: Any, board: Any, _place: Any) -> Any:
    """Return an entry of an int64 array as the last thread has left it."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load_atomic(_entry(context, builder, signature, args), "seq_cst", 8)

    return types.int64(board, types.int64), generate


@intrinsic
def _pointer(_typing: Any, _address: Any) -> Any:
    def generate(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], cgutils.voidptr_t)

    return types.voidptr(types.int64), generate


@inlined
def lent(address: int, rows: int, columns: int) -> Int32Array:
    """Return the int32 array (rows, columns) of another thread, which must not let go of it before they meet.

    Args:
        address: Its ``ctypes.data``.
        rows: Its length.
        columns: Its width.
    """
    return carray(_pointer(address), (rows, columns), np.int32)


@intrinsic
def ticks(_typing: Any) -> Any:
    """Return the processor's time stamp, int64: 0 where there is none that every program may read."""

    def generate(_context: Any, builder: Any, _signature: Any, _args: Any) -> Any:
        if platform.machine() not in {"x86_64", "AMD64"}:
            return ir.IntType(64)(0)
        kind = ir.FunctionType(ir.IntType(64), [])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.readcyclecounter"), [])

    return types.int64(), generate


@inner_loop
def meet(board: Int64Array, size: int) -> None:
    """Wait until all threads of a team are here: what each has written the others now read.

    A thread watches for some microseconds, lets others run, and sleeps at last: where a core is busy, its
    work goes on.

    Args:
        board: Where the threads see each other; see ``new_board``.
        size: How many they are.

    Raises:
        RuntimeError: One of them has failed, and will not come.
    """
    if size == 1:
        return
    meeting = look_at(board, ROUND)
    if add_at(board, ARRIVED, 1) == size - 1:
        add_at(board, ARRIVED, -size)
        add_at(board, ROUND, 1)
        return
    looks = 0
    while look_at(board, ROUND) == meeting:
        looks += 1
        if looks > WATCH:
            if look_at(board, BROKEN) != 0:
                raise RuntimeError("another thread has failed")
            if looks > WATCH + YIELD:
                sleep_for(types.uint32(NAP_UNITS))  # type: ignore[call-overload]
            else:
                let_others_run()


@inlined
def share(count: int, rank: int, size: int) -> tuple[int, int]:
    """Return where the share of one of ``size`` threads in ``count`` things begins, and where it ends."""
    return count * rank // size, count * (rank + 1) // size


def new_board() -> Int64Array:
    """Return a board at which no thread has come yet, shape (BOARD,)."""
    return np.zeros(BOARD, np.int64)


def together(loop: Callable[..., Any], board: Int64Array, arguments: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Run a compiled loop in as many threads as there are arguments, the first of them in this one.

    Args:
        loop: The loop.
        board: Where its threads meet.
        arguments: What each thread calls it with.

    Returns:
        What each call returned.
    """

    def run(each: tuple[Any, ...]) -> Any:
        try:
            return loop(*each)
        except BaseException:
            board[BROKEN] = 1
            raise

    if len(arguments) == 1:
        return [loop(*arguments[0])]
    board[:] = 0
    with ThreadPoolExecutor(len(arguments) - 1) as pool:
        try:
            others = [pool.submit(run, each) for each in arguments[1:]]
            first = run(arguments[0])
        except BaseException:
            # Those that have begun wait for one that never comes.
            board[BROKEN] = 1
            raise
        return [first, *(each.result() for each in others)]
