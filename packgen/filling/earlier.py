"""The bed that a scene goes on from: read, judged, and made part of the scene.

Its spheres have zone numbers after those of the scene's zones, and batch numbers before those of new spheres.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrange.spheres import Spheres
from packgen.bed import Bed, EarlierBed
from packgen.bedfile import plain
from packgen.check import check_bed, wall_clearance
from packgen.distributions import Free
from packgen.errors import PackingError, ReadError
from packgen.filling.earlier_sets import SAME_DENSITY, set_index_in, with_earlier_sets
from packgen.geometry import Container, floor_direction
from packgen.reading import SphereFile, complete_bed, read_spheres
from packgen.reading.known import known_by_provenance
from packgen.settlement import DEM_TOLERANCE
from packgen.units import LENGTHS

if TYPE_CHECKING:
    from packgen.scene import Scene

SIZES_APART = 30.0
"""Ratio of the mean radius of a bed to the nearest of the scene's from which a wrong unit is likely."""


@dataclass(frozen=True, eq=False, slots=True)
class Earlier:
    """What a scene goes on from.

    Attributes:
        scene: The scene with the sets and materials of that bed.
        spheres: Its spheres.
        loose: Whether those near its surface may move again.
        mark: What tells them apart in the new bed.
        told: What the new bed's provenance says of it.
    """

    scene: Scene
    spheres: Spheres
    loose: bool
    mark: EarlierBed
    told: dict[str, Any]

    def joined(self, scene: Scene) -> Scene:
        """Return a scene of the same sets, whose zones differ, with the sets and materials of the bed."""
        zones = tuple(
            zone.model_copy(update={"set_proportions": own.set_proportions})
            for zone, own in zip(scene.zones, self.scene.zones, strict=True)
        )
        return replace(self.scene, zones=zones)


def earlier_bed(scene: Scene, container: Container, warn: Callable[[str], None]) -> Earlier | None:
    """Return the bed that a scene goes on from; None where it does not.

    Args:
        scene: The scene.
        container: Its container.
        warn: Called with a line for each thing that looks wrong.

    Raises:
        ReadError: The file is not what it claims, or its lengths do not fit the scene.
        SceneError: Its sets do not go together with the scene's.
        PackingError: Spheres lie outside the container, or overlap more than a solver leaves them; or nothing
            near its surface can move again.
    """
    start = scene.start_from
    if start is None:
        return None
    loose = _loose(scene, container)
    spheres, bed = _read(scene, container, warn)
    _warn_of_sizes(scene, bed, warn)
    tolerance = None if scene.soft_materials else DEM_TOLERANCE
    overlap_max = _judge(scene, bed, tolerance, warn)
    whole = with_earlier_sets(scene, bed, warn)
    first = len(scene.zones)
    rows = Spheres(
        bed.position, bed.radius, set_index_in(whole, bed), bed.zone_index + np.int32(first),
        bed.batch_index, bed.body_index,
    )  # fmt: skip
    told = {
        "path": _named(start.path),
        "format": spheres.format,
        "sphere_count": bed.count,
        "hold": "surface" if loose else "fixed",
        "first_zone": first,
        "tolerance": tolerance,
        "overlap_max": overlap_max,
        "bed": plain(spheres.provenance),
    }
    return Earlier(whole, rows, loose, EarlierBed(first, tolerance), told)


def _named(path: Path) -> str:
    """Return a file's name; of a result folder, with the folder's."""
    return f"{path.resolve().parent.name}/{path.name}" if path.name == "bed.npz" else path.name


def _loose(scene: Scene, container: Container) -> bool:
    """Return whether spheres near the surface may move again.

    Raises:
        PackingError: The scene says so, and there is no surface.
    """
    start = scene.start_from
    if start is None or start.hold != "surface":
        return False
    down = floor_direction(np.asarray(scene.gravity_direction, float), container.periodic)
    if down is None and scene.marked.states(("start_from", "hold")):
        raise PackingError(
            f"{scene.named('start_from.hold')}: found surface in a box that wraps around along gravity, "
            "expected fixed: a bed there has no surface"
        )
    return down is not None


def _read(scene: Scene, container: Container, warn: Callable[[str], None]) -> tuple[SphereFile, Bed]:
    """Return what the file says, and its bed in the scene's container.

    Raises:
        ReadError: The file is not what it claims, or does not go together with the scene.
    """
    start, place = scene.start_from, scene.named("start_from")
    assert start is not None
    try:
        spheres = read_spheres(start.path, step=start.step, units=start.units)
        # A bed of packgen's says itself which sets it has; of others the scene must.
        own = bool(known_by_provenance(spheres.provenance).particle_sets)
        bed = complete_bed(
            spheres, container, scene=None if own else scene, units=start.units,
            warn=lambda line: warn(f"{place}: {_in_keys(line)}"),
        )  # fmt: skip
    except ReadError as error:
        lines = str(error).splitlines()
        raise ReadError("\n".join(f"{place}: {_in_keys(line)}" for line in lines)) from error
    _refuse_other_densities(place, spheres, bed)
    if not own and spheres.groups is None and spheres.density is None:
        name = bed.particle_sets[int(bed.set_index[0])].name
        warn(f"{place}: sets are not in the file: its spheres are taken for {name} of the scene")
    return spheres, bed


def _in_keys(line: str) -> str:
    """Return a reader's line with keys of the scene in place of options of the command line."""
    line = re.sub(r"\(--container-units (\w+)\)", r"(`units: \1` in container)", line)
    line = re.sub(r"--units (\w+)", r"`units: \1` beside the path", line)
    return line.replace("--step N", "`step`").replace("--step", "`step`").replace("--scene", "the scene")


def _refuse_other_densities(place: str, spheres: SphereFile, bed: Bed) -> None:
    """Refuse spheres that would take another density than the file says.

    Raises:
        ReadError: There are some.
    """
    if spheres.density is None:
        return
    density = bed.density
    other = np.flatnonzero(np.abs(spheres.density - density) > SAME_DENSITY * density)
    if len(other):
        sets = ", ".join(f"{each.name} ({each.density:g})" for each in bed.particle_sets)
        raise ReadError(
            f"{place}: found {len(other):,} spheres of other densities than the sets have, such as "
            f"{spheres.density[other[0]]:g} kg/m3, expected one of {sets}; add a set of that density"
        )


def _warn_of_sizes(scene: Scene, bed: Bed, warn: Callable[[str], None]) -> None:
    """Warn of spheres so much larger or smaller than the scene's that a unit is likely to be wrong."""
    if any(isinstance(each.distribution, Free) for each in scene.particle_sets):
        return  # voids may be of any size
    mean = float(bed.radius.mean())
    bounds = [each.distribution.radius_bounds for each in scene.particle_sets]
    apart = min(max(low / mean, mean / high, 1.0) for low, high in bounds)
    if apart > SIZES_APART:
        low, high = min(each[0] for each in bounds), max(each[1] for each in bounds)
        warn(
            f"{scene.named('start_from')}: radii of {bed.radius.min():.4g} to {bed.radius.max():.4g} m, "
            f"those of the scene are {low:.4g} to {high:.4g} m; check `units` beside the path, and the units "
            "of the radii"
        )


def _judge(scene: Scene, bed: Bed, tolerance: float | None, warn: Callable[[str], None]) -> float:
    """Refuse spheres outside the container and overlaps that no solver leaves; warn of those that it does.

    Args:
        scene: The scene.
        bed: The bed that it goes on from.
        tolerance: Largest overlap, as a fraction of the smaller radius; None: any.
        warn: Called with a line for each kind of overlaps.

    Returns:
        The largest overlap of two of its spheres, or of one with a wall, as a fraction of the smaller radius.

    Raises:
        PackingError: There are some; a line each kind.
    """
    place = scene.named("start_from")
    clearance = wall_clearance(bed.container, bed.position, bed.radius)
    faults = _outside(place, bed, clearance, scene)
    depth = 1.0 - clearance / bed.radius
    limit = np.inf if tolerance is None else tolerance
    within = clearance >= 0.0
    slight = 0.0 if scene.tolerance is None else scene.tolerance
    found = check_bed(replace(bed, tolerance=slight, earlier=None), clearance)
    deep = int(np.count_nonzero(within & (depth > limit)))
    if deep:
        faults.append(
            f"{place}: found {deep:,} of {bed.count:,} spheres in walls by up to {depth[within].max():.3g} "
            f"of the radius, expected at most {limit:g}, as solvers leave them; are container and `units` "
            "those of this bed? `allow_soft: true` takes any"
        )
    if found.overlap_max > limit:
        pairs = check_bed(replace(bed, tolerance=limit, earlier=None), clearance).excess_count
        faults.append(
            f"{place}: found {_pairs(pairs)} with overlaps of up to {found.overlap_max:.3g} of the smaller "
            f"radius, expected at most {limit:g}, as solvers leave them; settle the bed first. "
            "`allow_soft: true` takes any"
        )
    if faults:
        raise PackingError("\n".join(faults))
    in_wall = int(np.count_nonzero(depth > slight))
    if found.excess_count:
        warn(
            f"{place}: {_pairs(found.excess_count)} with overlaps of up to {found.overlap_max:.3g} of the "
            "smaller radius, as solvers leave them; new spheres overlap nothing"
        )
    if in_wall:
        warn(
            f"{place}: {in_wall:,} spheres are in walls by up to {depth.max():.3g} of the radius, as solvers "
            "leave them; new spheres are not"
        )
    return max(found.overlap_max, found.wall_overlap_max)


def _pairs(count: int) -> str:
    return "1 pair of its spheres" if count == 1 else f"{count:,} pairs of its spheres"


def _outside(place: str, bed: Bed, clearance: np.ndarray, scene: Scene) -> list[str]:
    """Return a line where spheres have their centres outside the container."""
    outside = np.flatnonzero(clearance < 0.0)
    if len(outside) == 0:
        return []
    worst = int(clearance.argmin())
    x, y, z = bed.position[worst]
    remedy = _other_units(bed, scene) or "give the container of that bed, or cut it by packgen carve"
    return [
        f"{place}: found {len(outside):,} of {bed.count:,} spheres outside the container, sphere {worst} at "
        f"({x:.6g}, {y:.6g}, {z:.6g}) farthest, expected all inside; {remedy}"
    ]


def _other_units(bed: Bed, scene: Scene) -> str:
    """Return the question for the unit in which a bed would be inside the container; empty: there is none."""
    assert scene.start_from is not None
    now = LENGTHS[scene.start_from.units or "m"]
    low, high = bed.container.bounds
    mean = float(bed.radius.mean())
    bounds = [each.distribution.radius_bounds for each in scene.particle_sets]
    for unit, length in LENGTHS.items():
        scale = length / now
        inside = (scale * bed.position >= low) & (scale * bed.position <= high)
        alike = any(low / 3.0 < scale * mean < 3.0 * high for low, high in bounds)
        if scale != 1.0 and alike and inside.all():
            return f"is the file in {unit}? Say `units: {unit}` beside the path"
    return ""
