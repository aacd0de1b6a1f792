"""What will be missed, and what will not be held: a line each, with its place in the scene and a remedy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from packgen.filling.room import Locations
from packgen.forecast.cells import Cells, Taken
from packgen.forecast.support import hanging, standing_free
from packgen.geometry import Slice

if TYPE_CHECKING:
    from packgen.scene import Scene

__all__ = ["SURE", "loose_zones", "misfit", "no_room"]

SURE, LIKELY = 1.03, 0.98
"""Volume needed over the volume there is: from the first on an amount will not fit, from the second on it may
not; the prediction is as exact as that."""


FEW = 10
"""Number of spheres up to which a solid fraction says little."""


def misfit(place: str, count: int, need: float, taken: Taken, *, level: bool) -> tuple[list[str], list[str]]:
    """Return lines where the amount of a zone will not fit, and where it may not.

    Args:
        place: Where the scene names it.
        count: Number of spheres asked for.
        need: Volume that they need [m3].
        taken: What the zone takes.
        level: Whether it is filled up to a level.
    """
    if need <= LIKELY * taken.room:
        return [], []
    if count <= FEW:
        return [], [f"{place}: {count} spheres may not fit; of so few it cannot be told"]
    more = f", or make it {need / taken.area:.3g} m high" if level and taken.area > 0.0 else ""
    if need > SURE * taken.room:
        fits = int(taken.room / need * count)
        return [f"{place}: about {fits:,} of {count:,} spheres will fit; ask for fewer{more}"], []
    return [], [
        f"{place}: {count:,} spheres will fill it to the brim, a few may not fit; ask for 5 % less{more}"
    ]


def no_room(place: str) -> str:
    """Return the line of a zone that is full before its turn."""
    return f"{place}: earlier zones leave it no room; enlarge the zone, or leave it out if others fill it"


def loose_zones(scene: Scene, locations: Sequence[Locations], cells: Cells, diameter: float) -> list[str]:
    """Return a line for each zone that nothing will hold.

    Args:
        scene: The scene.
        locations: What bounds each zone beside the container.
        cells: The cells, all zones filled.
        diameter: Largest diameter [m].
    """
    lines = []
    for index, own in enumerate(locations):
        place = scene.named(f"zones[{index}]")
        if own and (found := hanging(cells, index, diameter)) is not None:
            lines.append(
                f"{place}: nothing will hold it up: {found.share:.0%} of its lower end is above free space, "
                f"and will fall by about {found.fall:.2g} m; lower the zone onto what is below it, or fill "
                "the space in between first"
            )
        sliced = any(isinstance(each, Slice) and each.centers_only for each in own)
        if own and not sliced and (found := standing_free(cells, index, diameter)) is not None:
            lines.append(
                f"{place}: nothing will hold {found.share:.0%} of its side, which will fall by about "
                f"{found.fall:.2g} m; fill what is beside the zone, or add a wall there"
            )
    return lines
