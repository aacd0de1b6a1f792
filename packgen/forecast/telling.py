"""A forecast in words and as plain data: what ``packgen plan`` shows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from packgen.forecast.costs import RULE
from packgen.forecast.result import Forecast, ZoneForecast
from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.scene import Scene

__all__ = ["as_data", "rows"]


def rows(found: Forecast) -> list[tuple[str, str]]:
    """Return a forecast as rows of a label and a value."""
    size = found.container.bounds[1] - found.container.bounds[0]
    lengths = " x ".join(f"{each:.4g}" for each in size)
    free = found.container.cell is not None
    room = f"{found.container.name}, {lengths} m, {found.container.volume:.4g} m3"
    lines = [
        ("container", "a periodic cell, whose size and shape are found" if free else room),
        ("spheres", f"{found.sphere_count:,}{_wanted(found)}"),
        ("mass", f"{found.mass:,.6g} kg"),
        ("solid fraction, expected", f"{found.solid_fraction:.3f} of what is filled, walls included"),
        ("random close packing", f"{found.close_packing:.3f}"),
    ]
    if found.height is not None and found.highest is not None:
        lines.append(
            ("height, expected", f"{found.height:.4g} m; the highest spheres reach {found.highest:.4g} m")
        )
    if found.factor is not None and not free:
        scaled = " x ".join(f"{each:.4g}" for each in size * found.factor)
        lines.append(("container, expected", f"{found.factor:.4f} times that asked for, {scaled} m"))
    if len(found.sets) > 1:
        lines += [(f"set {each.name}", f"{each.sphere_count:,}, {each.mass:,.6g} kg") for each in found.sets]
    if len(found.zones) > 1:
        lines += [(f"zones[{place}]", _zone(each)) for place, each in enumerate(found.zones)]
    lines += _needs(found)
    lines.append(("time, about", _time(found.cost.seconds)))
    lines.append(("memory, about", f"{found.cost.memory / 1e6:,.0f} MB"))
    return lines


def _wanted(found: Forecast) -> str:
    asked = [each.asked for each in found.zones]
    known = [each for each in asked if each is not None]
    if len(known) < len(asked):
        return ", until full" if not known else ""
    return f" of {sum(known):,}"


def _zone(zone: ZoneForecast) -> str:
    wanted = "" if zone.asked is None else f" of {zone.asked:,}"
    text = f"{zone.sphere_count:,}{wanted}, {zone.mass:,.4g} kg, solid fraction {zone.solid_fraction:.3f}"
    return text if zone.top is None else f"{text}, from {zone.bottom:.4g} to {zone.top:.4g} m"


def _needs(found: Forecast) -> list[tuple[str, str]]:
    """Return what the amounts need: a height each, and a cube for all."""
    heights = [
        (
            f"zones[{place}] needs" if len(found.zones) > 1 else "needs",
            f"{each.height_needed:.4g} m of height",
        )
        for place, each in enumerate(found.zones)
        if each.asked is not None and each.height_needed is not None
    ]
    if any(each.asked is None for each in found.zones):
        return heights
    label = "all need" if len(found.zones) > 1 else "or needs" if heights else "needs"
    if found.container.cell is not None:
        return heights
    return [*heights, (label, f"a cube of {found.cube_needed:.4g} m, filled to its brim")]


def _time(seconds: float | None) -> str:
    if seconds is None:
        return "not known of a plug-in's algorithm"
    if seconds < 120.0:
        return f"{seconds:.0f} s, once the loops are compiled"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


def as_data(found: Forecast, scene: Scene) -> dict[str, Any]:
    """Return a forecast as plain data: metres, cubic metres, kilograms, seconds, bytes.

    Args:
        found: The forecast.
        scene: Its scene.
    """
    low, high = found.container.bounds
    return {
        "scene": scene.path.name,
        "packgen": __version__,
        "algorithm": scene.algorithm,
        "seed": scene.seed,
        "container": {
            "name": found.container.name,
            "size": (high - low).tolist(),
            "volume": found.container.volume,
            "factor": found.factor,
        },
        "sphere_count": found.sphere_count,
        "mass": found.mass,
        "solid_fraction": found.solid_fraction,
        "close_packing": found.close_packing,
        "height": found.height,
        "highest": found.highest,
        "cube_needed": found.cube_needed,
        "sets": [
            {"name": each.name, "sphere_count": each.sphere_count, "mass": each.mass} for each in found.sets
        ],
        "zones": [_zone_data(each) for each in found.zones],
        "seconds": found.cost.seconds,
        "memory": found.cost.memory,
        "rule": RULE,
        "missed": list(found.missed),
        "warnings": list(found.warnings),
    }


def _zone_data(zone: ZoneForecast) -> dict[str, Any]:
    names = (
        "asked", "sphere_count", "solid_volume", "mass", "solid_fraction", "room", "bottom", "top",
        "height_needed",
    )  # fmt: skip
    return {name: getattr(zone, name) for name in names}
