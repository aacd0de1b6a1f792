"""Do the spheres of rigid bodies stand where their bodies have them? By quaternions, without matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed

PLACE_ERROR_MAX = 1.0e-9  # of a sphere's radius: rounding, of thousands of small turns as well
DIGITS = 1.0e-14  # of a coordinate: what is left of it far from the origin


@dataclass(frozen=True, slots=True)
class BodyCheck:
    """What the check of rigid bodies found.

    Attributes:
        body_count: Number of bodies, single spheres among them.
        clump_count: Number of those with more than one sphere.
        place_error_max: Largest distance of a sphere from where its body has it, or difference of its radius,
            as a fraction of its radius.
        worst_body: The body of that sphere; None where all are exact.
        misplaced_count: Number of bodies with spheres further off than rounding, or whose orientation is no
            unit quaternion.
    """

    body_count: int
    clump_count: int
    place_error_max: float
    worst_body: int | None
    misplaced_count: int

    def faults(self) -> list[str]:
        """Return a line where bodies are not what their spheres are."""
        if self.misplaced_count == 0:
            return []
        bodies = "1 body has" if self.misplaced_count == 1 else f"{self.misplaced_count:,} bodies have"
        return [
            f"{bodies} spheres that stand elsewhere, worst body {self.worst_body}, by "
            f"{self.place_error_max:.3g} of the radius"
        ]


def check_bodies(bed: Bed) -> BodyCheck | None:
    """Return whether the spheres of bodies stand where their bodies have them; None of a bed without bodies.

    A sphere's place is q v q* for the quaternion q and the place v in the template, and where the container
    wraps around any of its images.
    """
    bodies = bed.bodies
    if bodies is None or bed.body_index is None:
        return None
    index = bed.body_index.astype(np.int64)
    first = np.searchsorted(np.sort(index), np.arange(len(bodies)))
    order = np.argsort(index, kind="stable")
    member = np.empty(bed.count, np.int64)
    member[order] = np.arange(bed.count) - first[index[order]]
    place, size = np.zeros((bed.count, 3)), np.ones(bed.count)
    for number, template in enumerate(bodies.templates):
        own = bodies.template_index[index] == number
        place[own], size[own] = template.spheres[member[own], :3], template.spheres[member[own], 3]
    scale, turn = bodies.scale[index], bodies.orientation[index]
    expected = bodies.position[index] + scale[:, None] * _turned(turn, place)
    apart = bed.position - expected
    for axis, period in enumerate(bed.container.period):
        if period is not None:
            apart[:, axis] -= period * np.round(apart[:, axis] / period)
    error = np.maximum(np.linalg.norm(apart, axis=1), np.abs(bed.radius - scale * size)) / bed.radius
    length = np.abs(np.linalg.norm(turn, axis=1) - 1.0)
    error = np.where(np.isfinite(error), np.maximum(error, length), np.inf)
    reach = np.maximum(np.abs(bed.position), np.abs(expected)).max(axis=1, initial=0.0)
    off = ~(error <= PLACE_ERROR_MAX + DIGITS * reach / bed.radius)
    worst = int(error.argmax()) if bed.count else 0
    return BodyCheck(
        body_count=len(bodies),
        clump_count=int(np.count_nonzero(np.bincount(index, minlength=len(bodies)) > 1)),
        place_error_max=float(error[worst]) if bed.count else 0.0,
        worst_body=int(index[worst]) if bed.count and error[worst] > 0.0 else None,
        misplaced_count=len(np.unique(index[off])),
    )


def _turned(turn: Float64Array, place: Float64Array) -> Float64Array:
    """Return places (N, 3) turned by quaternions w, x, y, z (N, 4): v + 2 w (u x v) + 2 u x (u x v)."""
    across = 2.0 * np.cross(turn[:, 1:], place)
    return np.asarray(place + turn[:, :1] * across + np.cross(turn[:, 1:], across))
