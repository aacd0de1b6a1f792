"""Shares of a body's mass for its spheres: a solver that sums members then has the body's mass and centre.

Overlaps make the spheres' own masses add up to more than the body's, and put their centre elsewhere; gravity
on them would pull too hard, and turn the body. The shares are the spheres' volumes times exp(l x), x the
place in the body's frame, with the l that puts the centre where the body has it: of all shares with that
centre those nearest to the volumes, by relative entropy. They are positive.
"""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.bodies.placed import Bodies
from packgen.bodies.template import Template
from packgen.portable import exp

__all__ = ["UnbalancedError", "member_shares", "sphere_shares"]

STEPS_MAX = 200
BALANCED = 1.0e-13  # largest distance of the shares' centre from the body's, in reaches of the template
EXPONENT_MAX = 50.0  # beyond it the body's centre is not among those of its spheres


class UnbalancedError(ValueError):
    """No shares of the spheres have the body's centre of mass."""


def member_shares(template: Template) -> Float64Array:
    """Return the share of the body's mass that each sphere of a template stands for.

    Returns:
        Shares, positive, whose sum is 1 and whose centre is the origin, shape (N,), float64.

    Raises:
        UnbalancedError: The origin is outside the hull of the spheres' centres: no shares have it.
    """
    place = template.spheres[:, :3] / template.reach
    start = template.spheres[:, 3] ** 3 / (template.spheres[:, 3] ** 3).sum()
    slope = np.zeros(3)
    shares = start
    for _ in range(STEPS_MAX):
        centre = shares @ place
        if float(np.abs(centre).max()) <= BALANCED:
            return np.asarray(shares)
        spread = (place - centre).T @ (shares[:, None] * (place - centre))
        step = np.linalg.lstsq(spread, -centre, rcond=1e-12)[0]
        slope += step * min(1.0, 2.0 / max(float(np.abs(place @ step).max()), 1e-300))
        exponent = place @ slope
        if float(np.abs(exponent).max()) > EXPONENT_MAX:
            break
        weight = start * exp(exponent - exponent.max())
        shares = weight / weight.sum()
    raise UnbalancedError(
        f"template {template.name}: no masses of its {template.count} spheres have the body's centre of "
        "mass; give it more spheres"
    )


def sphere_shares(bodies: Bodies) -> Float64Array:
    """Return the share of its body's mass that each sphere stands for, in the order of `members_of`.

    Returns:
        Shares, 1 of single spheres, shape (N,), float64.

    Raises:
        UnbalancedError: A template that a body has is without such shares.
    """
    used = np.unique(bodies.template_index)
    empty = np.zeros(0)
    tables = [
        member_shares(each) if number in used else empty for number, each in enumerate(bodies.templates)
    ]
    tables.append(np.ones(1))
    return np.concatenate([empty, *(tables[number] for number in bodies.template_index.tolist())])
