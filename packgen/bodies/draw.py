"""Bodies drawn: of which shape, how large, and how turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from packgen.arrays import Float64Array, Int32Array
from packgen.bodies.placed import SINGLE, Bodies
from packgen.bodies.template import Template

__all__ = ["Form", "drawn_bodies", "random_turns"]


@dataclass(frozen=True, eq=False)
class Form:
    """The shape of the particles of a set, and how they are turned when they come.

    Attributes:
        template: Its spheres.
        orientation: ``random``, ``aligned`` (the template's axes are the bed's), or a unit vector that the
            longest axis of the body lies along.
    """

    template: Template
    orientation: str | tuple[float, float, float] = "random"

    @cached_property
    def _long_axis(self) -> Float64Array:
        """The axis of least inertia in the template's frame, shape (3,)."""
        return np.asarray(self.template.properties.principal()[1][:, 0])

    def turns(self, rng: np.random.Generator, count: int) -> Float64Array:
        """Draw orientations as unit quaternions w, x, y, z, shape (count, 4)."""
        if self.orientation == "random":
            return random_turns(rng, count)
        if isinstance(self.orientation, str):
            return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        onto = _shortest(self._long_axis, np.array(self.orientation))
        about = np.concatenate([[0.0], self._long_axis])
        # About the axis at random: a point of the circle is a random turn's share in the plane of 1 and it.
        point = _disc(rng, count)
        length = np.sqrt((point * point).sum(axis=1))[:, None]
        spin = point[:, :1] / length * [1.0, 0.0, 0.0, 0.0] + point[:, 1:] / length * about
        return _product(onto, spin)


def random_turns(rng: np.random.Generator, count: int) -> Float64Array:
    """Draw rotations, each as likely as any other, as unit quaternions w, x, y, z, shape (count, 4).

    Marsaglia, Ann. Math. Stat. 43 (1972) 645: two points of a disc make one of the sphere in four dimensions,
    by square roots alone, which all machines round alike.
    """
    one, other = _disc(rng, count), _disc(rng, count)
    square, rest = (one * one).sum(axis=1), (other * other).sum(axis=1)
    turn = np.concatenate([one, other * np.sqrt((1.0 - square) / rest)[:, None]], axis=1)
    return np.asarray(turn / np.sqrt((turn * turn).sum(axis=1))[:, None])


def _disc(rng: np.random.Generator, count: int) -> Float64Array:
    """Draw points of the unit disc without its middle, shape (count, 2)."""
    point = np.empty((0, 2))
    while len(point) < count:
        tried = 2.0 * rng.random((2 * (count - len(point)) + 16, 2)) - 1.0
        square = (tried * tried).sum(axis=1)
        point = np.concatenate([point, tried[(square < 1.0) & (square > 1e-12)]])
    return point[:count]


def _shortest(start: Float64Array, end: Float64Array) -> Float64Array:
    """Return the quaternion of the shortest turn of one unit vector onto another, shape (1, 4)."""
    turn = np.concatenate([[1.0 + float((start * end).sum())], np.cross(start, end)])
    if turn[0] < 1e-9:
        # Half a turn, about any axis across.
        across = np.eye(3)[int(np.argmin(np.abs(start)))]
        turn = np.concatenate([[0.0], np.cross(start, across)])
    return np.asarray(turn / np.sqrt((turn * turn).sum()))[None]


def _product(one: Float64Array, other: Float64Array) -> Float64Array:
    """Return the products of quaternions, shapes (1 or N, 4) and (N, 4): first the other, then the one."""
    w, x, y, z = one.T
    a, b, c, d = other.T
    return np.stack(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ],
        axis=1,
    )


def drawn_bodies(
    size: Float64Array, set_index: Int32Array, forms: Sequence[Form | None], rng: np.random.Generator
) -> Bodies:
    """Draw the orientations of bodies; they are placed at the origin.

    Args:
        size: Radius of the sphere of each body's volume [m], shape (B,).
        set_index: Set of each, shape (B,).
        forms: Shape of each set's particles; None: spheres.
        rng: Source of randomness.
    """
    shaped = [number for number, form in enumerate(forms) if form is not None]
    templates = tuple(form.template for form in forms if form is not None)
    index, scale = np.full(len(size), SINGLE, np.int32), np.array(size)
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (len(size), 1))
    for place, number in enumerate(shaped):
        own, form = set_index == number, forms[number]
        assert form is not None
        index[own] = place
        scale[own] = size[own] / form.template.equivalent_radius
        turn[own] = form.turns(rng, int(own.sum()))
    return Bodies(templates, index, scale, np.zeros((len(size), 3)), turn)
