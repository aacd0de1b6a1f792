"""The page of a plan: the forecast's figures, and container and zones as lines that turn."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.container.primitives import surface_of
from packgen.filling.room import within
from packgen.forecast import Forecast, ZoneForecast
from packgen.geometry import Shape, Slice, Surface
from packgen.page.html import environment, inside_script
from packgen.page.outline import CONTAINER, line_data, outline, section
from packgen.page.spheres import upright_frame
from packgen.version import __version__

__all__ = ["plan_html"]

COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#a08a00", "#777777")
RINGS = 30
"""Number of rings over the container's height that show what is filled."""


def plan_html(name: str, found: Forecast, rows: Sequence[tuple[str, str]], rule: str) -> str:
    """Return the page of a plan.

    Args:
        name: What the scene is called.
        found: The forecast.
        rows: The forecast as rows of a label and a value.
        rule: By what rule time and memory are told.
    """
    view = _view(found)
    return environment().get_template("plan.html.j2").render(
        name=name, rows=rows, missed=found.missed, warnings=found.warnings, rule=rule, version=__version__,
        view_data=inside_script(view),
    )  # fmt: skip


def _view(found: Forecast) -> dict[str, Any]:
    """Return what the view draws: no sphere, and the lines of container and zones."""
    container, up = found.container, found.up
    corners = np.array(list(product(*container.bounds.T))) @ upright_frame(up).T
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, base = 0.5 * (low + high), float(low[2])
    lines = [line_data("container", CONTAINER, outline(container.surface, up), up, middle)]
    for place, zone in enumerate(found.zones):
        drawn = [_filled(found, zone, base), *(_bounds(found, shape) for shape in zone.locations)]
        colour = COLOURS[place % len(COLOURS)]
        lines.append(line_data(f"zones[{place}]{_level(zone)}", colour, np.concatenate(drawn), up, middle))
    half = (0.5 * (high - low)).tolist()
    return {
        "count": 0, "shown": 0, "outer": 0, "half": half, "span": [0.0, 0.0, 0.0], "radius_min": 0.0,
        "radius_max": 0.0, "labels": [], "place": "", "size": "", "sets": [], "outlines": lines,
    }  # fmt: skip


def _level(zone: ZoneForecast) -> str:
    spheres = f", {zone.sphere_count:,} spheres"
    return spheres if zone.top is None else f"{spheres} up to {zone.top:.3g} m"


def _bounds(found: Forecast, shape: Any) -> Float64Array:
    """Return the outline of a zone's location; of a slice, its planes' cuts through the container."""
    if not isinstance(shape, Slice):
        return outline(surface_of(shape), found.up)
    surface = found.container.surface
    return np.concatenate([section(surface, shape.axis, level) for level in (shape.low, shape.high)])


def _filled(found: Forecast, zone: ZoneForecast, base: float) -> Float64Array:
    """Return rings around the filled part of a zone: where the container ends it, and where the zone does."""
    if zone.top is None or zone.bottom is None:
        return np.empty((0, 2, 3))
    container = found.container
    height = float(np.ptp(np.array(list(product(*container.bounds.T))) @ found.up))
    number = max(round(RINGS * (zone.top - zone.bottom) / height), 1)
    levels = base + np.linspace(zone.bottom, zone.top, number + 1)[1:]
    bodies = [each for each in zone.locations if not isinstance(each, Slice)]
    drawn = [_rings(container.surface, bodies, found.up, levels)]
    for place, body in enumerate(bodies):
        others = [container.shape, *bodies[:place], *bodies[place + 1 :]]
        drawn.append(_rings(surface_of(body), others, found.up, levels))
    return np.concatenate(drawn)


def _rings(surface: Surface, others: Sequence[Shape], up: Float64Array, levels: Float64Array) -> Float64Array:
    """Return the lines in which levels cut a surface, those within some other shapes, (L, 2, 3)."""
    lines = np.concatenate([section(surface, up, float(each)) for each in levels])
    middle = lines.mean(axis=1)
    kept = np.ones(len(lines), dtype=bool)
    for shape in others:
        kept &= np.asarray(within(shape, middle))
    return lines[kept]
