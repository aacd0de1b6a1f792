"""The settings of COLLECTIVE_ARRANGEMENT."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator

from packgen.arrange.paper_params import PaperParams
from packgen.geometry import Container
from packgen.values import number

TILE_MIN = 20.0
"""Least width of a tile, in largest diameters."""


def _tile(value: Any) -> float | str:
    if value == "auto":
        return "auto"
    expected = f"auto, or a number of at least {TILE_MIN:g} diameters"
    try:
        width = number(value)
    except ValueError as error:
        raise ValueError(expected) from error
    if width < TILE_MIN:
        raise ValueError(expected)
    return width


Tile = Annotated[float | Literal["auto"], BeforeValidator(_tile)]


class Params(PaperParams):
    """Settings of COLLECTIVE_ARRANGEMENT; the paper's names keep the paper's meaning.

    Attributes:
        optimizer: ``projection`` (fast), or ``adam`` (the paper's Algorithm 1, see the algorithm ADAM).
        tile: Divide the bed into tiles at least so wide, in largest diameters, which several processes can
            work on; ``auto``: a quarter of the vessel's width, from 30 to 60 diameters. None: the bed is one
            piece.
    """

    holds: ClassVar[tuple[str, ...]] = ("surface", "fixed")

    optimizer: Literal["projection", "adam"] = "projection"
    tile: Tile | None = None
    zone_keys: ClassVar[frozenset[str]] = frozenset({"solid_fraction", "porosity", "void_ratio"})
    compacts: ClassVar[bool] = True
    takes_clumps: ClassVar[bool] = True

    @property
    def instead(self) -> str | None:
        """Name of the algorithm that arranges in place of this one; None: this one does."""
        return "ADAM" if self.optimizer == "adam" else None

    def unsupported(self, container: Container) -> list[tuple[str, str]]:
        """Return the settings that cannot fill a container, as (place in the scene, found and expected)."""
        if self.optimizer != "adam" or not any(container.periodic):
            return []
        expected = "expected projection in a periodic box; adam knows walls only"
        return [("params.optimizer", f"found adam, {expected}")]
