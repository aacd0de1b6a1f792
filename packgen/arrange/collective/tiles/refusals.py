"""What cannot be divided into tiles yet: told before the first sphere is placed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from packgen.arrange.collective.tiles.layout import TileLayout
from packgen.arrange.space.region import Region
from packgen.arrange.task import Task
from packgen.errors import PackingError
from packgen.geometry import floor_direction
from packgen.portable import components

NOT_YET = "not supported yet with --workers, --scheduler or params.tile"

AXIS_ROUNDING = 1.0e-12  # of the component of a unit vector along its axis


def check_divisible(task: Task) -> None:
    """Refuse what no unit can arrange, as far as the task tells.

    Raises:
        PackingError: Something of it cannot be divided; a line each.
    """
    settings, container = task.settings, task.container
    faults = []
    if len(task.zones) > 1:
        faults.append(f"{task.zones[1].place}: found {len(task.zones)} zones, expected one")
    if len(task.earlier):
        faults.append("start_from: found a bed to go on from, expected none")
    if any(container.periodic):
        faults.append("container.periodic: found a box that wraps around, expected walls on all sides")
    elif floor_direction(task.down, container.periodic) is None:
        faults.append("gravity: found none, expected a bed that lies on something")
    elif float(np.abs(task.down).max()) < 1.0 - AXIS_ROUNDING:
        faults.append("gravity_axis: found a direction askew to x, y and z, expected one of these")
    if settings.batch_size is not None:
        faults.append(
            f"params.batch_size: found {settings.batch_size}, expected none: layers are as thick as they are"
        )
    if settings.tolerance is None:
        faults.append("params.tolerance: found null, expected a number")
    supply = task.zones[0].supply
    if task.sink is not None and supply.asked is None and np.count_nonzero(supply.shares) > 1:
        faults.append(
            f"--pieces: {task.zones[0].place}: found several sets and no amount, expected n_particles, "
            "volume or mass: sets that have too many are taken out of the whole bed"
        )
    if task.device != "cpu":
        faults.append(f"--device: found {task.device}, expected cpu")
    _raise(faults)


def check_tiles(region: Region, layout: TileLayout, radius: float) -> None:
    """Refuse a region that has too few tiles, or rooms above each other.

    Args:
        region: The zone's space.
        layout: Its tiles.
        radius: Radius of a sphere of mean volume [m].

    Raises:
        PackingError: It cannot be divided.
    """
    faults = []
    if len(layout.tiles) < 2:
        least, most = region.rectangle()
        faults.append(
            f"container: found a width of {float((most - least).max()):.4g} m, expected at least "
            f"{2.0 * layout.width_min:.4g} m for two tiles; give a smaller params.tile, from 20 diameters on"
        )
    elif region.sides is not None and _has_chambers(region, layout, radius):
        faults.append(
            "container: found room above a roof or a shelf, expected walls that nothing stands out of"
        )
    _raise(faults)


def _has_chambers(region: Region, layout: TileLayout, radius: float) -> bool:
    """Tell whether some column has room for a sphere, none above that, and room again."""
    columns = layout.columns
    middle = columns.points(np.zeros(columns.count))
    below, closed = np.zeros(columns.count, bool), np.zeros(columns.count, bool)
    for altitude in np.arange(region.floor + 0.5 * radius, region.ceiling, radius):
        points = middle + components(np.array([[0.0, 0.0, altitude]]), region.frame.T)
        room = region.clearance(points, radius) >= 0.0
        if (closed & room).any():
            return True
        below |= room
        # A sphere's centre is far in the wall: a facet that a column grazes is no roof.
        closed |= below & (region.clearance(points, 0.5 * radius) < 0.0)
    return False


def _raise(faults: Sequence[str]) -> None:
    if faults:
        raise PackingError(
            "\n".join(f"{NOT_YET}: {each}; leave these out to have the bed in one piece" for each in faults)
        )
