"""Is a bed the same everywhere? The imprint of the layers along the height, and crystals at the walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.special import lpmv

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.geometry import Box

SLICES_A_RADIUS = 20
MARGIN_FLOOR = 5.0  # diameters above the floor that its order reaches into
MARGIN_TOP = 3.0  # diameters below the top
NEIGHBOR_DISTANCE = 1.3  # diameters: between the first shell and the second of a dense crystal, sqrt(2)
BOND = 0.5
BONDS = 8
AT_WALL = 2.0  # diameters


@dataclass(frozen=True, eq=False, slots=True)
class Imprint:
    """What the layers left in the solid fraction along the height.

    Attributes:
        period: Rise of the bed with each layer [m].
        amplitude: Amplitude of the solid fraction at this period.
        noise: Mean amplitude at neighbouring periods.
        noise_high: Amplitude that one in twenty of them exceeds.
        periods: Neighbouring periods and this one [m], shape (P,).
        amplitudes: Amplitudes there, shape (P,).
        height: Heights of the slices [m], shape (S,).
        fraction: Solid fraction of each slice, shape (S,).
    """

    period: float
    amplitude: float
    noise: float
    noise_high: float
    periods: Float64Array
    amplitudes: Float64Array
    height: Float64Array
    fraction: Float64Array


def layer_period(bed: Bed) -> float:
    """Return how much the bed rises with each layer [m]: the slope of the layers' mean heights.

    The first and the last tenth of the layers are left out: they meet floor and surface.
    """
    layer = np.unique(bed.batch_index)
    height = np.array([bed.position[bed.batch_index == each, 2].mean() for each in layer])
    edge = len(layer) // 10
    inner = slice(edge, len(layer) - edge)
    return float(np.polyfit(layer[inner], height[inner], 1)[0]) if len(layer) > 1 else float("nan")


def slice_fractions(bed: Bed, height: Float64Array) -> Float64Array:
    """Return the solid fraction of horizontal slices of a box: exact areas of the circles cut, shape (S,).

    Args:
        bed: A bed in an upright box.
        height: Equidistant heights of the slices [m], shape (S,).
    """
    shape = bed.container.shape
    assert isinstance(shape, Box)
    area = float(np.prod((shape.max - shape.min)[:2]))
    step = height[1] - height[0]
    solid = np.zeros(len(height))
    reach = int(np.ceil(float(bed.radius.max()) / step)) + 1
    nearest = np.rint((bed.position[:, 2] - height[0]) / step).astype(np.int64)
    for offset in range(-reach, reach + 1):
        place = nearest + offset
        within = (place >= 0) & (place < len(height))
        away = height[place[within]] - bed.position[within, 2]
        circle = np.pi * np.maximum(bed.radius[within] ** 2 - away**2, 0.0)
        solid += np.bincount(place[within], circle, minlength=len(height))
    return solid / area


def amplitude_at(height: Float64Array, fraction: Float64Array, period: Float64Array) -> Float64Array:
    """Return the amplitude of a profile at some periods, shape (P,): Fourier sums with a Hann window.

    The profile's straight trend is taken off first: fractions fall or rise slightly along a bed.

    Args:
        height: Equidistant heights [m], shape (S,).
        fraction: Values there, shape (S,).
        period: Periods [m], shape (P,).
    """
    window = np.hanning(len(height) + 2)[1:-1]
    middle = height - height.mean()
    rest = fraction - np.polyval(np.polyfit(middle, fraction, 1, w=np.sqrt(window)), middle)
    turns = np.exp(-2j * np.pi * middle / np.asarray(period)[:, None])
    result: Float64Array = 2.0 * np.abs(turns @ (window * rest)) / window.sum()
    return result


def imprint(bed: Bed, period: float) -> Imprint | None:
    """Return what layers of a period [m] left in a bed; None where it is too low to tell."""
    diameter = 2.0 * float(bed.radius.mean())
    low = MARGIN_FLOOR * diameter
    high = float(np.quantile(bed.position[:, 2], 0.99)) - MARGIN_TOP * diameter
    if not high - low > 4.0 * period:  # nor where the period is unknown
        return None
    step = float(bed.radius.min()) / SLICES_A_RADIUS
    height = np.linspace(low, high, int((high - low) / step))
    fraction = slice_fractions(bed, height)
    # A window of this length tells frequencies apart that differ by two steps; twelve to either side.
    steps = np.arange(-12, 13) / (high - low)
    frequency = 1.0 / period + steps
    # Nearer to the spheres' own diameter, half a layer, walls and floor order any bed.
    frequency = frequency[(frequency > 0.5 / period) & (frequency < 1.5 / period)]
    amplitudes = amplitude_at(height, fraction, 1.0 / frequency)
    own = int(np.argmin(np.abs(frequency - 1.0 / period)))
    others = amplitudes[np.abs(np.arange(len(frequency)) - own) > 2]
    return Imprint(
        period=period,
        amplitude=float(amplitudes[own]),
        noise=float(others.mean()),
        noise_high=float(np.quantile(others, 0.95)),
        periods=1.0 / frequency,
        amplitudes=amplitudes,
        height=height,
        fraction=fraction,
    )


def crystal_fractions(bed: Bed) -> tuple[float, float]:
    """Return the share of crystalline spheres near the side walls of a box and away from them.

    Floor and surface are left out of both. Near: within two diameters of a wall; away: farther than five.
    """
    shape = bed.container.shape
    assert isinstance(shape, Box)
    diameter = 2.0 * float(bed.radius.mean())
    crystal = crystalline(bed.position, diameter)
    height = bed.position[:, 2]
    top = float(np.quantile(height, 0.99)) - MARGIN_TOP * diameter
    inner = (height > shape.min[2] + MARGIN_FLOOR * diameter) & (height < top)
    wall = np.minimum(bed.position - shape.min, shape.max - bed.position)[:, :2].min(axis=1)
    near, away = inner & (wall < AT_WALL * diameter), inner & (wall > 5.0 * diameter)
    return _share(crystal, near), _share(crystal, away)


def crystalline(position: Float64Array, diameter: float) -> NDArray[np.bool_]:
    """Tell which spheres have a crystal's neighbourhood, shape (N,).

    Neighbours are bonded when the directions of their own neighbours agree: the normalised product of their
    vectors q_6m exceeds 0.5 (ten Wolde, Ruiz-Montero and Frenkel, J. Chem. Phys. 104, 1996, 9932). A sphere
    with eight or more such bonds is crystalline (Gasser et al., Science 292, 2001, 258); a sphere of a dense
    crystal has twelve, one at a wall nine.

    Args:
        position: Centres [m], shape (N, 3).
        diameter: Diameter of a sphere [m].
    """
    pairs = cKDTree(position).query_pairs(NEIGHBOR_DISTANCE * diameter, output_type="ndarray")
    if len(pairs) == 0:
        return np.zeros(len(position), bool)
    first, second = pairs[:, 0], pairs[:, 1]
    harmonics = _harmonics(position[second] - position[first])  # of degree 6: the same both ways
    moment = np.zeros((7, len(position)), complex)
    for order in range(7):
        for end in (first, second):
            moment[order].real += np.bincount(end, harmonics[order].real, minlength=len(position))
            moment[order].imag += np.bincount(end, harmonics[order].imag, minlength=len(position))
    weight = np.array([1.0, 2, 2, 2, 2, 2, 2])[:, None]  # negative orders are the conjugates
    length = np.sqrt((weight * np.abs(moment) ** 2).sum(axis=0))
    product = (weight * (moment[:, first] * moment[:, second].conj()).real).sum(axis=0)
    bonded = product > BOND * length[first] * length[second]
    bonds = np.bincount(pairs[bonded].ravel(), minlength=len(position))
    return np.asarray(bonds >= BONDS)


def _harmonics(direction: Float64Array) -> NDArray[np.complex128]:
    """Return the spherical harmonics of degree 6 and orders 0 to 6 of directions (P, 3), shape (7, P)."""
    from math import factorial, pi, sqrt

    x, y, z = direction.T
    cosine = z / np.linalg.norm(direction, axis=1)
    around = np.arctan2(y, x)
    rows = []
    for order in range(7):
        norm = sqrt(13.0 / (4.0 * pi) * factorial(6 - order) / factorial(6 + order))
        rows.append(norm * lpmv(order, 6, cosine) * np.exp(1j * order * around))
    return np.stack(rows)


def _share(chosen: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
    return float(chosen[among].mean()) if among.any() else float("nan")
