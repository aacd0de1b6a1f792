"""Zones that say how dense they are: the amounts that follow, or why no such zone can be.

A fraction of the core becomes one of the whole by the layer at the walls that lacks spheres: of a fluid of
hard spheres of solid fraction n it is (1 - n) / (1 + 2 n) radii thick (scaled particle theory: Reiss, Frisch,
Helfand and Lebowitz, J. Chem. Phys. 32 (1960) 119).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrange.task import Gap
from packgen.distributions import Listed
from packgen.errors import PackingError
from packgen.filling.room import Locations, volume_inside, volume_of
from packgen.geometry import Container
from packgen.scene.models import FRACTIONS
from packgen.supply.shares import expected_count, number_shares
from packgen.supply.supply import Supply

if TYPE_CHECKING:
    from packgen.scene import Scene, ZoneSpec
    from packgen.scene.models import FractionSpec

__all__ = ["Density", "densities", "gap_of"]

RANDOM_CLOSE = 0.64
"""Solid fraction that random packings of equal spheres do not exceed."""


@dataclass(frozen=True, slots=True)
class Density:
    """How dense a zone is to be.

    Attributes:
        room: Its volume, walls included [m3].
        fraction: Solid fraction of that.
    """

    room: float
    fraction: float


def gap_of(zone: ZoneSpec) -> Gap:
    """Return the least distance between surfaces that a zone asks for."""
    return Gap() if zone.gap is None else Gap(zone.gap.radii, zone.gap.length)


def densities(
    scene: Scene, container: Container, locations: Sequence[Locations]
) -> tuple[Scene, tuple[Density | None, ...]]:
    """Turn the fractions that zones ask for into solid volumes.

    Args:
        scene: The scene.
        container: Its container.
        locations: What bounds each zone beside it.

    Returns:
        (the scene with these volumes in place of the fractions, what was asked of each zone; None: nothing).

    Raises:
        PackingError: No random packing of such spheres is as dense, or so few fit that there is none; one
            line a fault, all of them at once.
    """
    zones: list[ZoneSpec] = []
    found: list[Density | None] = []
    faults: list[str] = []
    for index, (zone, own) in enumerate(zip(scene.zones, locations, strict=True)):
        asked = zone.fraction
        if asked is None:
            zones.append(zone)
            found.append(None)
            continue
        try:
            density = _density(scene, container, own, index, asked)
        except PackingError as error:
            faults.append(str(error))
            continue
        amount = {"volume": density.fraction * density.room} | dict.fromkeys(FRACTIONS)
        zones.append(zone.model_copy(update=amount))
        found.append(density)
        faults += _amount_faults(scene, index, zones[-1], density)
    if faults:
        raise PackingError("\n".join(faults))
    return replace(scene, zones=tuple(zones)), tuple(found)


def _density(scene: Scene, container: Container, own: Locations, index: int, asked: FractionSpec) -> Density:
    """Return the fraction of a whole zone.

    Raises:
        PackingError: It is more than any random packing has, or that of a core in a part of the container.
    """
    place, zone = _place(scene, index), scene.zones[index]
    supply = Supply(zone, scene.particle_sets, np.random.default_rng(0))
    radius = np.array([supply.radius_by_volume])
    half, wall = (float(each[0]) for each in (gap_of(zone).half(radius), gap_of(zone).wall(radius)))
    larger = (half / float(radius[0])) ** 3
    most = supply.solid_fraction(RANDOM_CLOSE) / larger
    if asked.value > most:
        raise PackingError(f"{place}: {_too_dense(zone, most)}")
    room = volume_of(container, own)
    if asked.of == "filled" or all(container.periodic):
        return Density(room, asked.value)
    if own:
        raise PackingError(
            f"{place}.of: found core, expected filled: only a whole container has a core; leave it out"
        )
    layer = wall - half + half * (1.0 - asked.value * larger) / (1.0 + 2.0 * asked.value * larger)
    return Density(room, asked.value * volume_inside(container, layer) / room)


def _too_dense(zone: ZoneSpec, most: float) -> str:
    """Return what is wrong with a zone denser than any random packing, in the terms of its own key."""
    key = zone.density_key or ""
    said = getattr(zone, key).value
    limit = {
        "solid_fraction": f"at most {most:.3f}",
        "porosity": f"at least {1.0 - most:.3f}",
        "void_ratio": f"at least {(1.0 - most) / most:.3f}",
    }[key]
    apart = "" if zone.gap is None else " that keep this gap"
    return (
        f"found {said:g}, expected {limit}: random packings of such spheres{apart} are no denser; ask for a "
        "looser zone"
    )


def _amount_faults(scene: Scene, index: int, zone: ZoneSpec, density: Density) -> list[str]:
    """Return what is wrong with the number of spheres that makes a fraction."""
    sets, place = scene.particle_sets, _place(scene, index)
    count = expected_count(zone, sets) or 0.0
    solid = density.fraction * density.room
    if count < 0.5:
        mean = solid / max(count, 1e-300)
        return [
            f"{place}: found {density.room:.4g} m3 to fill, expected at least {mean / density.fraction:.4g} "
            "m3, room for one sphere of mean size; enlarge the zone, or make the spheres smaller"
        ]
    return [
        f"{place}: found {share * count:.0f} spheres to draw from a file of radii, expected at most "
        f"{each.distribution.count}; ask for {density.fraction * each.distribution.count / share / count:.4g}"
        " or less"
        for share, each in zip(number_shares(zone, sets), sets, strict=True)
        if isinstance(each.distribution, Listed) and share * count > each.distribution.count + 0.5
    ]


def _place(scene: Scene, index: int) -> str:
    path = f"zones[{index}].{scene.zones[index].density_key}"
    return scene.named(path)
