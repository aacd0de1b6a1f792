"""Elementary functions with the same digits on every machine, for all that a bed depends on.

IEEE 754 fixes sums, products, quotients and square roots to the last bit. It does not fix exponentials,
logarithms and powers: libraries compute them with what the processor offers, and the last bit differs. A bed
amplifies that: after a few layers its spheres are elsewhere. Matrix products differ too, in the order of
their sums. Here all of them are made of what is fixed.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cache

import numpy as np

from packgen.arrays import Float64Array, Int64Array

__all__ = [
    "components", "cube", "cube_root", "exp", "expm1", "length", "log", "log1p", "normal_integral",
    "normal_quantile", "octaves", "power", "whole_power",
]  # fmt: skip

LOG_2_HIGH = 6.93147180369123816490e-01
"""The first 33 bits of ln 2: products with whole numbers below 2^20 are exact."""

LOG_2_LOW = 1.90821492927058770002e-10
"""What is left of ln 2."""

SPLITTER = 134217729.0
"""2^27 + 1: splits a number into halves with exact products (Dekker, Numer. Math. 18 (1971) 224)."""

AT_ONCE = 2**16
"""Numbers whose powers are found at once."""

SCORE_MAX = 8.5
"""Above it the normal integral is 1 to rounding; below its negative the power series loses its digits."""

FRACTION_TERMS = 60
"""Of the continued fraction of the normal integral's tail; from 8.5 on the rest is less than 1e-43 of it."""

OCTAVE_SLACK = 1.0e-9
"""Ratios this close below a power of two count as the power."""

# Wichura, Algorithm AS 241 (PPND16), Appl. Stat. 37 (1988) 477: numerator, denominator; highest power first.
_CENTRAL = (
    (2509.0809287301226727, 33430.575583588128105, 67265.770927008700853, 45921.953931549871457,
     13731.693765509461125, 1971.5909503065514427, 133.14166789178437745, 3.387132872796366608),
    (5226.495278852854561, 28729.085735721942674, 39307.89580009271061, 21213.794301586595867,
     5394.1960214247511077, 687.1870074920579083, 42.313330701600911252, 1.0),
)  # fmt: skip
_TAIL = (
    (7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177, 1.27045825245236838258,
     3.64784832476320460504, 5.7694972214606914055, 4.6303378461565452959, 1.42343711074968357734),
    (1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966, 0.14810397642748007459,
     0.68976733498510000455, 1.6763848301838038494, 2.05319162663775882187, 1.0),
)  # fmt: skip
_FAR_TAIL = (
    (2.01033439929228813265e-7, 2.71155556874348757815e-5, 1.2426609473880784386e-3, 0.026532189526576123093,
     0.29656057182850489123, 1.7848265399172913358, 5.4637849111641143699, 6.6579046435011037772),
    (2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5, 7.868691311456132591e-4,
     0.0148753612908506148525, 0.13692988092273580531, 0.59983220655588793769, 1.0),
)  # fmt: skip


def exp(value: Float64Array) -> Float64Array:
    """Return e to the power of each value, to two units in the last place; same shape."""
    value = np.clip(np.asarray(value, np.float64), -800.0, 800.0)
    doublings = np.rint(value / (LOG_2_HIGH + LOG_2_LOW))
    rest = (value - doublings * LOG_2_HIGH) - doublings * LOG_2_LOW
    total = np.ones_like(rest)
    for number in range(13, 0, -1):  # the power series, from its last term that counts
        total = 1.0 + total * rest / number
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(np.ldexp(total, doublings.astype(np.int64)))


def log(value: Float64Array) -> Float64Array:
    """Return the natural logarithm of each value, to two units in the last place; -inf of 0; same shape."""
    value = np.asarray(value, np.float64)
    fraction, doublings = np.frexp(value)
    small = fraction < math.sqrt(0.5)
    fraction, doublings = np.where(small, 2.0 * fraction, fraction), doublings - small
    # ln x = 2 artanh((x - 1) / (x + 1)), a series in odd powers.
    slope = (fraction - 1.0) / (fraction + 1.0)
    square = slope * slope
    series = np.zeros_like(slope)
    for number in range(21, 1, -2):
        series = (series + 1.0 / number) * square
    # The first term apart: it carries the digits.
    rest = 2.0 * slope * series + doublings * LOG_2_LOW
    return np.asarray(np.where(value > 0.0, doublings * LOG_2_HIGH + (2.0 * slope + rest), -np.inf))


def expm1(value: Float64Array) -> Float64Array:
    """Return exp(value) - 1 without loss of digits near 0 (Kahan's correction); same shape."""
    value = np.asarray(value, np.float64)
    power_of_e = exp(value)
    less_one = power_of_e - 1.0
    with np.errstate(all="ignore"):
        corrected = less_one * value / log(power_of_e)
    near = (np.abs(value) < 1.0) & (less_one != 0.0)
    return np.asarray(np.where(near, corrected, np.where(power_of_e == 1.0, value, less_one)))


def log1p(value: Float64Array) -> Float64Array:
    """Return log(1 + value) without loss of digits near 0 (Kahan's correction); same shape."""
    value = np.asarray(value, np.float64)
    total = 1.0 + value
    with np.errstate(all="ignore"):
        corrected = log(total) * value / (total - 1.0)
    return np.asarray(np.where(total == 1.0, value, np.where(total > 0.0, corrected, -np.inf)))


def power(base: Float64Array, exponent: float) -> Float64Array:
    """Return each base, at least 0, to the power of an exponent greater than 0; same shape."""
    return exp(exponent * log(base))


def whole_power(base: Float64Array, exponent: int) -> Float64Array:
    """Return each base to the power of a whole number from 1 on, correctly rounded but for rarest cases.

    Products are carried along with their rounding errors (Dekker, Numer. Math. 18 (1971) 224), of so many
    numbers at a time that these take no memory worth speaking of.
    """
    base = np.asarray(base, np.float64)
    if base.size > AT_ONCE:
        found = np.empty(base.size)
        for start in range(0, base.size, AT_ONCE):
            part = base.ravel()[start : start + AT_ONCE]
            found[start : start + AT_ONCE] = whole_power(part, exponent)
        return found.reshape(base.shape)
    high, low = base, np.zeros_like(base)
    for _ in range(exponent - 1):
        product, error = _product(high, base)
        error = error + low * base
        high = product + error
        low = error - (high - product)
    return np.asarray(high)


def cube(base: Float64Array) -> Float64Array:
    """Return the third power of each base; see ``whole_power``."""
    return whole_power(base, 3)


def _product(a: Float64Array, b: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the rounded product of two numbers and its rounding error."""
    product = a * b
    a_high, a_low = _halves(a)
    b_high, b_low = _halves(b)
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


def _halves(value: Float64Array) -> tuple[Float64Array, Float64Array]:
    scaled = SPLITTER * value
    high = scaled - (scaled - value)
    return high, value - high


@cache
def scalar_power(base: float, exponent: int) -> float:
    """Return a number to the power of a whole number, correctly rounded."""
    return float(Fraction(base) ** exponent)


@cache
def cube_root(value: float) -> float:
    """Return the cube root of a number, at least 0: the float whose cube is nearest."""
    guess = math.cbrt(value)
    near = [guess]
    for towards in (0.0, math.inf):
        step = guess
        for _ in range(3):
            step = math.nextafter(step, towards)
            near.append(step)
    return min(near, key=lambda root: abs(Fraction(root) ** 3 - Fraction(value)))


@cache
def normal_integral(score: float) -> float:
    """Return the standard normal integral up to a score, correctly rounded.

    By its power series, and in the lower tail by its continued fraction (Abramowitz and Stegun, 26.2.11 and
    26.2.14), in decimal numbers of fifty digits.
    """
    if score > SCORE_MAX:
        return 1.0
    with localcontext() as context:
        context.prec = 50
        x = Decimal(score)
        if score < -SCORE_MAX:
            return float(_density(x) / _tail_fraction(-x))
        term, total, number = x, x, 1
        while abs(term) > abs(total) * Decimal("1e-45"):
            number += 2
            term *= x * x / number
            total += term
        return float(Decimal("0.5") + _density(x) * total)


def _density(score: Decimal) -> Decimal:
    """Return the standard normal density at a score."""
    return (-score * score / 2).exp() / (2 * _pi()).sqrt()


def _tail_fraction(score: Decimal) -> Decimal:
    """Return the density at a positive score over the integral above it: x + 1/(x + 2/(x + 3/...))."""
    value = score
    for number in range(FRACTION_TERMS, 0, -1):
        value = score + number / value
    return value


def _pi() -> Decimal:
    return Decimal("3.14159265358979323846264338327950288419716939937510582")


def normal_quantile(share: Float64Array) -> Float64Array:
    """Return the standard normal score below which each share is: Wichura's algorithm AS 241; same shape."""
    share = np.asarray(share, np.float64)
    offset = share - 0.5
    central = np.abs(offset) <= 0.425
    inner = np.where(central, 0.180625 - offset * offset, 0.0)
    middle = offset * _ratio(inner, _CENTRAL)
    tail = np.where(central, 0.5, np.minimum(share, 1.0 - share))
    with np.errstate(all="ignore"):
        depth = np.sqrt(-log(tail))
        outer = np.where(depth <= 5.0, _ratio(depth - 1.6, _TAIL), _ratio(depth - 5.0, _FAR_TAIL))
    outer = np.where(tail > 0.0, outer, np.inf)
    return np.asarray(np.where(central, middle, np.copysign(outer, offset)))


def _ratio(value: Float64Array, terms: tuple[tuple[float, ...], tuple[float, ...]]) -> Float64Array:
    """Return the quotient of two polynomials."""
    upper, lower = np.zeros_like(value), np.zeros_like(value)
    for above, below in zip(*terms, strict=True):
        upper, lower = upper * value + above, lower * value + below
    return np.asarray(upper / lower)


def octaves(ratio: Float64Array, slack: float = OCTAVE_SLACK) -> Int64Array:
    """Return how often each ratio, at least 1, can be halved before it is below 1; same shape, int64.

    Args:
        ratio: Ratios.
        slack: Ratios that are below a power of two by no more than this fraction count as it.
    """
    return np.asarray(np.frexp(np.asarray(ratio, np.float64) * (1.0 + slack))[1].astype(np.int64) - 1)


def components(position: Float64Array, axes: Float64Array) -> Float64Array:
    """Return the components of vectors along one axis, or along several.

    Args:
        position: Vectors, shape (N, 3).
        axes: One axis, shape (3,), or several as rows, shape (K, 3).

    Returns:
        Shape (N,) or (N, K), float64.
    """
    if axes.ndim > 1:
        return np.stack([components(position, axis) for axis in axes], axis=1)
    # Most axes are those of the coordinates: nothing is added for a zero.
    parts = [position[:, k] * axes[k] for k in range(3) if axes[k] != 0.0]
    return np.asarray(sum(parts[1:], start=parts[0])) if parts else np.zeros(len(position))


def matrix_product(left: Float64Array | Int64Array, right: Float64Array) -> Float64Array:
    """Return a matrix product, summed in the order of the columns: that of BLAS depends on the machine.

    Args:
        left: Shape (K,) or (N, K).
        right: Shape (K,) or (K, M).
    """
    terms = [left[..., k, None] * right[k] for k in range(right.shape[0])]
    summed = np.asarray(sum(terms[1:], start=terms[0]))
    return np.asarray(summed[..., 0] if right.ndim == 1 else summed)


def inverse(matrix: Float64Array) -> Float64Array:
    """Return the inverse of a matrix, shape (3, 3), by Cramer's rule."""
    a, b, c = matrix
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    x, y, z = (float(each) for each in a * cofactors[:, 0])
    return np.asarray(cofactors / (x + y + z))


def length(vector: Float64Array) -> float:
    """Return the length of a vector, shape (3,)."""
    x, y, z = (float(each) for each in vector)
    return math.sqrt(x * x + y * y + z * z)
