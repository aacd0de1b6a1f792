"""How loops are compiled: once a machine, alike on all machines, and free of the interpreter's lock.

Importing it loads numba. A compiled loop that Python calls takes longer to compile than one that only other
compiled loops call: it has to take Python's objects apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

from numba import njit

Loop = TypeVar("Loop", bound=Callable[..., Any])

# Division by zero as in numpy; no reordering of sums, so that all machines agree to the last bit. No loop is
# called from C.
_compile: Callable[..., Any] = partial(
    njit, cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True
)


def loop(function: Loop) -> Loop:
    """Compile a loop that Python calls; it frees the interpreter's lock while it runs.

    It must not return named tuples. Numba makes them by Python code, in which a signal that has come raises
    its error, and the process ends by a segmentation fault.
    """
    compiled: Loop = _compile()(function)
    return compiled


def inner_loop(function: Loop) -> Loop:
    """Compile a loop that only compiled ones call."""
    compiled: Loop = _compile(no_cpython_wrapper=True)(function)
    return compiled


def inlined(function: Loop) -> Loop:
    """Have a few lines written out wherever a compiled loop calls them."""
    compiled: Loop = _compile(inline="always")(function)
    return compiled


@contextmanager
def signals_heard() -> Iterator[None]:
    """Raise a signal's own error where it came up inside the call of a compiled loop.

    Python finds a result and an error at once, which makes a ``SystemError`` of it.
    """
    try:
        yield
    except SystemError as error:
        first: BaseException = error
        while isinstance(first, SystemError) and first.__cause__ is not None:
            first = first.__cause__
        raise first from None
