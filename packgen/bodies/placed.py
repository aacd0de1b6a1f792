"""Bodies at their places: which template, how large, where, and how turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrays import Float64Array, Int32Array, Int64Array, read_only
from packgen.bodies.columns import body_starts
from packgen.bodies.template import Template

__all__ = ["SINGLE", "Bodies", "has_members", "joined_rows", "members_of", "rotations"]

SINGLE = -1
"""Number in ``template_index`` of a body that is one sphere: its scale is its radius."""


@dataclass(frozen=True, eq=False, slots=True)
class Bodies:
    """Rigid bodies in a row; ``body_index`` of a sphere is the row of its body.

    Attributes:
        templates: The shapes.
        template_index: Index into ``templates`` of each body, shape (M,), int32; `SINGLE`: one sphere.
        scale: Factor on all lengths of the template, shape (M,), float64; of one sphere its radius [m].
        position: Centre of mass of each body [m], shape (M, 3), float64.
        orientation: Unit quaternion w, x, y, z that turns the template's frame into the bed's, shape (M, 4),
            float64.
    """

    templates: tuple[Template, ...]
    template_index: Int32Array
    scale: Float64Array
    position: Float64Array
    orientation: Float64Array

    def __post_init__(self) -> None:
        count = len(self.template_index)
        for name, dtype, shape in (
            ("template_index", np.int32, (count,)),
            ("scale", np.float64, (count,)),
            ("position", np.float64, (count, 3)),
            ("orientation", np.float64, (count, 4)),
        ):
            value = read_only(getattr(self, name), dtype, shape, f"bodies.{name}")
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.template_index)

    def __getitem__(self, chosen: NDArray[np.bool_] | Int64Array | slice) -> Bodies:
        return Bodies(
            self.templates,
            self.template_index[chosen],
            self.scale[chosen],
            self.position[chosen],
            self.orientation[chosen],
        )

    def scaled(self, factor: float) -> Bodies:
        """Return the bodies with all lengths multiplied by a factor, places included."""
        return Bodies(
            self.templates,
            self.template_index,
            factor * self.scale,
            factor * self.position,
            self.orientation,
        )

    @property
    def sphere_count(self) -> Int64Array:
        """Number of spheres of each body, shape (M,), int64."""
        return np.array([*(each.count for each in self.templates), 1], np.int64)[self.template_index]

    @property
    def volume(self) -> Float64Array:
        """Volume of each body, overlaps of its spheres counted once [m3], shape (M,), float64."""
        units = np.array([*(each.volume for each in self.templates), 4.0 / 3.0 * np.pi])
        return np.asarray(units[self.template_index] * self.scale**3)

    @property
    def equivalent_radius(self) -> Float64Array:
        """Radius of the sphere of each body's volume [m], shape (M,), float64."""
        return np.cbrt(0.75 / np.pi * self.volume)

    @property
    def size(self) -> Float64Array:
        """The same, alike on all machines, by ``Template.equivalent_radius`` [m], shape (M,), float64."""
        units = np.array([*(each.equivalent_radius for each in self.templates), 1.0])
        return np.asarray(units[self.template_index] * self.scale)

    @property
    def reach(self) -> Float64Array:
        """Radius of the sphere about each centre of mass that holds the body [m], shape (M,), float64."""
        units = np.array([*(each.reach for each in self.templates), 1.0])
        return np.asarray(units[self.template_index] * self.scale)

    @property
    def inertia(self) -> Float64Array:
        """Inertia about each centre of mass in the bed's axes, a unit of density [m5], shape (M, 3, 3)."""
        ball = 8.0 / 15.0 * np.pi * np.eye(3)
        units = np.array([*(each.inertia for each in self.templates), ball])[self.template_index]
        turn = rotations(self.orientation)
        return np.asarray(turn @ units @ turn.transpose(0, 2, 1) * self.scale[:, None, None] ** 5)


def has_members(bodies: Bodies, body_index: Int32Array) -> bool:
    """Return whether each body has as many spheres as its template, by the row of each sphere's body (N,)."""
    if len(body_index) and not (body_index.min() >= 0 and body_index.max() < len(bodies)):
        return False
    found = np.bincount(body_index, minlength=len(bodies))
    return bool((found == bodies.sphere_count).all()) and len(body_starts(body_index)) == len(bodies)


def rotations(orientation: Float64Array) -> Float64Array:
    """Return the rotation matrices of unit quaternions w, x, y, z, shape (M, 4), as (M, 3, 3), float64.

    Of (w, v) the matrix is (2 w2 - 1) 1 + 2 v vT + 2 w [v]x.
    """
    w, v = orientation[:, 0], orientation[:, 1:]
    matrix = 2.0 * v[:, :, None] * v[:, None, :]
    matrix[:, [0, 1, 2], [0, 1, 2]] += (2.0 * w * w - 1.0)[:, None]
    turn = 2.0 * w[:, None] * v
    for row, column, axis, sign in (
        (0, 1, 2, -1), (1, 0, 2, 1), (0, 2, 1, 1), (2, 0, 1, -1), (1, 2, 0, -1), (2, 1, 0, 1)
    ):  # fmt: skip
        matrix[:, row, column] += sign * turn[:, axis]
    return matrix


def members_of(bodies: Bodies) -> tuple[Float64Array, Float64Array, Int32Array]:
    """Return the spheres of bodies, those of a body in consecutive rows, in the template's order.

    Returns:
        Centres [m], shape (N, 3), float64; radii [m], shape (N,), float64; row of each sphere's body, shape
        (N,), int32.
    """
    count = bodies.sphere_count
    owner = np.repeat(np.arange(len(bodies)), count)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    table = np.concatenate([*(each.spheres for each in bodies.templates), [[0.0, 0.0, 0.0, 1.0]]])
    starts = np.cumsum([0, *(each.count for each in bodies.templates)])[bodies.template_index]
    unit = table[starts[owner] + place]
    turned = np.einsum("nij,nj->ni", rotations(bodies.orientation)[owner], unit[:, :3])
    scale = bodies.scale[owner]
    centre = bodies.position[owner] + scale[:, None] * turned
    return centre, scale * unit[:, 3], owner.astype(np.int32)


def joined_rows(parts: Sequence[Bodies]) -> Bodies:
    """Return several lists of bodies as one; a template that several have comes once."""
    templates: list[Template] = []
    index = []
    for part in parts:
        place = {}
        for number, template in enumerate(part.templates):
            found = next((k for k, each in enumerate(templates) if each is template), len(templates))
            if found == len(templates):
                templates.append(template)
            place[number] = found
        table = np.array([*(place[number] for number in range(len(place))), SINGLE], np.int32)
        index.append(table[part.template_index])
    return Bodies(
        tuple(templates),
        np.concatenate(index),
        np.concatenate([part.scale for part in parts]),
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.orientation for part in parts]),
    )
