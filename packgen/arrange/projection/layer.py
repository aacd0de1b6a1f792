"""What a layer under arrangement offers, and the choice between its two forms."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.recipe import Schedule, Step
from packgen.arrange.space.walls import WallTable
from packgen.arrays import Float64Array, Int32Array, Int64Array


class Layer(Protocol):
    """A layer of spheres under arrangement: what the fused CPU loops and the plain torch form both offer.

    Attributes:
        moving: How many spheres move; those taken out count until the next rebuild.
        identity: Place of each moving sphere in the order given, shape (moving,).
    """

    moving: int
    identity: Int64Array

    def rebuild(self, skin: float) -> None:
        """List neighbours and walls anew, valid until a sphere moves by its margin; see ``list_reach``."""

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Sink, extrapolate, push apart, put back; return (largest overlap, spheres that outran the list)."""

    def sweeps(self, down: Float64Array, schedule: Schedule) -> tuple[int, float, int]:
        """Run sweeps until the lists are void, the layer is to be looked at, or the schedule ends.

        Returns:
            (sweeps done; largest overlap and spheres that outran the list, of the last sweep).
        """

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""

    def take_out(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of all contacts."""

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3).

        Spheres taken out since the last rebuild are NaN.
        """

    def radii(self) -> Float64Array:
        """Return the arranged radii of the moving spheres, in the layer's own order [m], shape (moving,)."""


def run_sweeps(layer: Layer, down: Float64Array, schedule: Schedule) -> tuple[int, float, int]:
    """Run the sweeps of a schedule one by one; see ``Layer.sweeps``."""
    count = len(schedule.fall)
    for number in range(count):
        step = Step(
            float(schedule.momentum[number]),
            schedule.relaxation,
            schedule.stride,
            float(schedule.roughness[number]),
            float(schedule.far[number]),
        )
        worst, strays = layer.sweep(down * schedule.fall[number], step)
        calm = not schedule.sinking[number] and not worst > schedule.calm
        if calm or schedule.judged[number] or number + 1 == count:
            break
        if strays > schedule.strays[number + 1] * layer.moving:
            break
    return number + 1, worst, strays


def make_layer(
    ball: Float64Array, moving: int, walls: WallTable, device: str, body_index: Int32Array | None = None
) -> Layer:
    """Return the layer's loops: fused on a CPU, plain torch elsewhere. The one place that decides.

    Args:
        ball: Centres and arranged radii [m], shape (N, 4); the first ``moving`` move.
        moving: How many move.
        walls: What bounds the moving ones.
        device: ``cpu``, or a device of torch.
        body_index: Body of each moving sphere, shape (moving,); the layer leaves pairs of one body out of its
            lists, so that they neither part nor are blamed. None: each sphere is a body.
    """
    if device == "cpu":
        from packgen.arrange.projection.numba_layer import FusedLayer

        return FusedLayer(ball, moving, walls, body_index)
    from packgen.arrange.projection.torch_layer import PlainLayer

    return PlainLayer(ball, moving, walls, device, body_index)
