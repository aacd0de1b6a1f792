"""A branch and bound over all arrangements, by SCIP: what it cannot exceed, nothing does.

The programme of Sutou and Dai, J. Optim. Theory Appl. 114 (2002) 671: quadratic constraints that keep centres
apart, planes that keep them inside, and a 0 or 1 for each sphere that may be chosen.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import Any

import numpy as np

from packgen.arrange.optimal.room import Room
from packgen.arrays import Float64Array
from packgen.portable import scalar_power

INSTALL = "pip install 'packgen[proof]'"
SPHERES_MAX = 7
"""Spheres up to which a proof comes to its end within minutes."""

RELATIVE = 1.0e-6
"""Share by which the bound may be above the value of what is proven best."""


@dataclass(frozen=True, slots=True)
class Proof:
    """What a branch and bound found.

    Attributes:
        bound: What no arrangement exceeds: a factor, or a sum of the cubes of radii [m3].
        finished: Whether it came to its end.
        nodes: Nodes of its tree.
    """

    bound: float
    finished: bool
    nodes: int


def is_installed() -> bool:
    """Return whether the optional package is there."""
    return importlib.util.find_spec("pyscipopt") is not None


def prove_scale(
    room: Room, radius: Float64Array, reached: float, most: float, seconds: float, *, is_box: bool
) -> Proof:
    """Return what the common factor of radii cannot exceed.

    Args:
        room: The room.
        radius: Radii [m], shape (N,).
        reached: The best factor known.
        most: A bound that is known.
        seconds: Time that it may take.
        is_box: Whether the room is its own mirror image along each axis.
    """
    model = _model(seconds)
    factor = model.addVar(lb=reached, ub=most, name="factor")
    square = model.addVar(lb=reached * reached, ub=most * most, name="square")
    model.addCons(square == factor * factor)
    place = _places(model, room, radius, [factor] * len(radius), reached, is_box=is_box)
    for one in range(len(radius)):
        for other in range(one):
            apart = float(radius[one] + radius[other]) ** 2
            model.addCons(_square(place[one], place[other]) >= apart * square)
    model.setObjective(factor, "maximize")
    return _solved(model)


def prove_volume(room: Room, radius: Float64Array, reached: float, seconds: float, *, is_box: bool) -> Proof:
    """Return what the sum of the cubes of chosen radii cannot exceed [m3].

    Args:
        room: The room.
        radius: Radii to choose from [m], shape (K,).
        reached: The largest sum known [m3].
        seconds: Time that it may take.
        is_box: Whether the room is its own mirror image along each axis.
    """
    model = _model(seconds)
    unit = float(radius.max())
    chosen = [model.addVar(vtype="B", name=f"chosen{number}") for number in range(len(radius))]
    place = _places(model, room, radius, [1.0] * len(radius), 1.0, is_box=is_box)
    for one in range(len(radius)):
        for other in range(one):
            apart = float(radius[one] + radius[other]) ** 2
            model.addCons(_square(place[one], place[other]) >= apart * (chosen[one] + chosen[other] - 1))
            if radius[one] == radius[other]:
                model.addCons(chosen[other] >= chosen[one])
    value = sum(
        scalar_power(float(each / unit), 3) * which for each, which in zip(radius, chosen, strict=True)
    )
    model.addCons(value >= reached / scalar_power(unit, 3) * (1.0 - 1.0e-6))
    model.setObjective(value, "maximize")
    proof = _solved(model)
    return Proof(proof.bound * scalar_power(unit, 3), proof.finished, proof.nodes)


def _model(seconds: float) -> Any:
    from pyscipopt import Model

    model = Model()
    model.hideOutput()
    model.setParam("limits/time", max(seconds, 1.0))
    model.setParam("limits/gap", RELATIVE)
    model.setParam("numerics/feastol", 1.0e-7)
    return model


def _places(
    model: Any,
    room: Room,
    radius: Float64Array,
    factor: list[Any],
    least: float,
    *,
    is_box: bool,
) -> list[list[Any]]:
    """Add the centres, inside the room, equal ones in the order of their first coordinate.

    Mirror images are looked at once: in a box the first centre is in the lower half along y and z, and along
    x where that order leaves it free.
    """
    place: list[list[Any]] = []
    for number, own in enumerate(radius.tolist()):
        low, high = room.bounds + np.array([[1.0], [-1.0]]) * least * own
        if (low > high).any():
            low, high = room.bounds
        point = [model.addVar(lb=float(low[k]), ub=float(high[k]), name=f"x{number}_{k}") for k in range(3)]
        away = sum((point[k] - float(room.center[k])) ** 2 for k in range(3)) if room.radius > 0.0 else None
        if away is not None:
            model.addCons(away <= (room.radius - factor[number] * own) * (room.radius - factor[number] * own))
        for normal, offset in zip(room.normal.tolist(), room.offset.tolist(), strict=True):
            along = sum(normal[k] * point[k] for k in range(3) if normal[k] != 0.0)
            model.addCons(along + factor[number] * own <= offset)
        if number and radius[number] == radius[number - 1]:
            model.addCons(place[-1][0] <= point[0])
        if number == 0 and is_box:
            middle = room.bounds.mean(axis=0)
            for k in (0, 1, 2) if len(radius) == 1 or radius[1] != own else (1, 2):
                model.addCons(point[k] <= float(middle[k]))
        place.append(point)
    return place


def _square(one: list[Any], other: list[Any]) -> Any:
    return sum((one[k] - other[k]) * (one[k] - other[k]) for k in range(3))


def _solved(model: Any) -> Proof:
    model.optimize()
    finished = model.getStatus() in {"optimal", "gaplimit"}
    return Proof(float(model.getDualbound()), finished, int(model.getNNodes()))
