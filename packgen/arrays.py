"""Checked read-only arrays, and small array helpers."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
Float64Array = NDArray[np.float64]
Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]


def read_only(value: Any, dtype: type[np.generic], shape: tuple[int | None, ...], name: str) -> NDArray[Any]:
    """Return ``value`` as a read-only, C-contiguous array of the wanted dtype and shape.

    Args:
        value: Anything that numpy turns into an array; an array that already fits is not copied.
        dtype: Wanted dtype.
        shape: Wanted shape; None stands for any length.
        name: What to call the array in the error.

    Returns:
        A view (or a copy, where conversion was needed) that cannot be written to.

    Raises:
        ValueError: The shape differs; the message gives both.
    """
    array = np.ascontiguousarray(value, dtype=dtype)
    fits = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = tuple("any" if want is None else want for want in shape)
        raise ValueError(f"{name}: shape {array.shape}, expected {wanted}")
    view = array.view()
    view.flags.writeable = False
    return view


def unique_rows(rows: Float64Array | Int64Array) -> tuple[Int64Array, Int64Array]:
    """Return the first of each kind of rows, and the kind of each row; kinds in rising order.

    What ``numpy.unique(axis=0)`` returns, several times as fast: columns are sorted, not rows as bytes.

    Args:
        rows: Numbers, shape (N, K).

    Returns:
        (index of the first row of each kind, shape (U,); kind of each row, shape (N,)).
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    kind = np.empty(len(rows), dtype=np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new].astype(np.int64), kind


def distinct(values: Int64Array) -> Int64Array:
    """Return the distinct values of integers (N,), rising; sorting is faster than hashing."""
    ordered = np.sort(values)
    first = np.ones(len(ordered), dtype=bool)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    return ordered[first]


def add_at(total: NDArray[Any], index: NDArray[Any], values: Float64Array | None = None) -> None:
    """Add values, or ones, to an array at the places of an index; repeated places add up.

    Only the span of places between the lowest and the highest is touched: the cost of a few pairs does not
    grow with the bed.

    Args:
        total: What is added to, shape (N,); changes.
        index: Places, shape (K,).
        values: Values, shape (K,); None: one each.
    """
    if len(index) == 0:
        return
    low = int(index.min())
    sums = np.bincount(index - low, values)
    total[low : low + len(sums)] += sums.astype(total.dtype)


def tallied(tally: Int64Array, numbers: NDArray[Any]) -> Int64Array:
    """Return how often 0, 1, 2, ... came so far, shape (K,), and in more numbers, (N,), together."""
    more = np.bincount(numbers, minlength=len(tally))
    more[: len(tally)] += tally
    return more


SUMMED_AT_ONCE = 2**20  # numbers: halves of their mantissas then add up without rounding
HALF = 26  # bits of the lower half of a mantissa
MANTISSA = 53


class ExactSum:
    """The sum of numbers without any rounding: the same in each order, and in parts as in one piece.

    Mantissas are whole numbers; those of one exponent are summed as such.
    """

    def __init__(self) -> None:
        self._by_exponent: Counter[int] = Counter()

    def add(self, values: Float64Array) -> None:
        """Add numbers, shape (N,), which are finite."""
        for start in range(0, len(values), SUMMED_AT_ONCE):
            mantissa, exponent = np.frexp(values[start : start + SUMMED_AT_ONCE])
            whole = np.ldexp(mantissa, MANTISSA).astype(np.int64)
            least = int(exponent.min())
            for shift, part in ((HALF, whole >> HALF), (0, whole & (2**HALF - 1))):
                sums = np.bincount(exponent - least, part)
                for place in np.flatnonzero(sums).tolist():
                    self._by_exponent[least + place + shift] += int(sums[place])

    def join(self, other: ExactSum) -> None:
        """Add another sum."""
        for exponent, whole in other._by_exponent.items():
            self._by_exponent[exponent] += whole

    def exact(self) -> Fraction:
        """Return the sum as it is."""
        whole = (
            value * Fraction(2) ** (exponent - MANTISSA) for exponent, value in self._by_exponent.items()
        )
        return sum(whole, start=Fraction(0))

    def __float__(self) -> float:
        return float(self.exact())

    @classmethod
    def of(cls, exact: Fraction) -> ExactSum:
        """Return a sum that has a value already, whose denominator is a power of two."""
        found = cls()
        found._by_exponent[MANTISSA + 1 - exact.denominator.bit_length()] = exact.numerator
        return found
