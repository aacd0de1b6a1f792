"""What a layer under arrangement offers, and the choice between its two forms."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.recipe import Schedule, Step, Tally
from packgen.arrange.space.walls import WallTable
from packgen.arrays import Float64Array, Int64Array


class Layer(Protocol):
    """A layer of spheres under arrangement: what the fused CPU loops and the plain torch form both offer."""

    @property
    def moving(self) -> int:
        """How many spheres move; those taken out count until the next rebuild."""

    @property
    def identity(self) -> Int64Array:
        """Place of each moving sphere in the order given, shape (moving,)."""

    def rebuild(self, skin: float) -> None:
        """List neighbours and walls anew, valid until a sphere moves by its margin; see ``list_reach``."""

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Sink, extrapolate, push apart, put back; return (largest overlap, spheres that outran the list)."""

    def run(self, down: Float64Array, schedule: Schedule, strays: int) -> Tally:
        """Run the sweeps of a schedule with all that comes between them, as ``run_by_steps`` does.

        Args:
            down: Unit vector along which things fall, shape (3,).
            schedule: What each sweep takes.
            strays: Spheres that have outrun the lists so far; all of them where there are no lists yet.
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


def make_layer(
    ball: Float64Array,
    moving: int,
    walls: WallTable,
    device: str,
    body: Int64Array,
    threads: int,
    *,
    rubs: bool = False,
) -> Layer:
    """Return the layer's loops: fused on a CPU, plain torch elsewhere. The one place that decides.

    Args:
        ball: Centres and arranged radii [m], shape (N, 4); the first ``moving`` move.
        moving: How many move.
        walls: What bounds the moving ones.
        device: ``cpu``, or a device of torch.
        body: Body of each moving sphere, shape (moving,), numbered from 0; the layer leaves pairs of one body
            out of its lists, so that they neither part nor are blamed. Empty: each sphere is a body.
        threads: Threads that arrange it on a CPU. The outcome does not depend on it.
        rubs: Whether there is friction between the spheres.
    """
    if device == "cpu":
        from packgen.arrange.projection.numba_layer import FusedLayer

        return FusedLayer(ball, moving, walls, body, threads, rubs=rubs)
    from packgen.arrange.projection.torch_layer import PlainLayer

    return PlainLayer(ball, moving, walls, device, body)
