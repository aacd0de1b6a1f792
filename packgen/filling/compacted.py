"""A bed under gravity as dense as its scene says: packed, measured, and packed again until it is.

How loose or dense an arrangement makes a bed is known for equal spheres away from walls. Other sizes are
taken to be as far below their random close packing, and walls to cost what ``wall_loss`` expects. What that
leaves the second bed puts right: it aims as much higher as the first one fell short.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from packgen.arrange.collective.compaction import DENSEST, LOOSEST
from packgen.arrange.traits import traits_of
from packgen.bed import Bed
from packgen.errors import PackingError
from packgen.filling.room import Locations
from packgen.geometry import Container, floor_direction
from packgen.measure.fraction import solid_fraction
from packgen.measure.volumes import mean_diameter, wall_area_below
from packgen.scene.models import FRACTIONS
from packgen.supply.close_packing import wall_loss
from packgen.supply.supply import Supply

if TYPE_CHECKING:
    from packgen.scene import Scene, ZoneSpec
    from packgen.scene.models import FractionSpec

__all__ = ["SLACK", "Aim", "aim_of", "as_dense", "falls", "friction_of"]

SLACK = 0.003
"""Largest difference from the solid fraction asked for that is no miss."""

NEAR = 0.0015
"""Difference at which no further bed is tried."""

TRIES = 6
"""Beds packed at most: those of few spheres scatter by more than the slack."""

STANDING = ((0.05, 0.641), (0.1, 0.633), (0.2, 0.620), (0.5, 0.600), (0.9, 0.589))
"""Friction, and core solid fraction of the bed of equal spheres that LIGGGHTS pours at it.

Each is the mean of two pours of 15,000 spheres into a box 20 diameters wide, at a Young's modulus of 100 MPa;
the two differ by less than 0.001.
"""

FALLING = 0.008
"""By how much looser a bed is than the poured one of its friction when a line warns of it."""


class HasBed(Protocol):
    """Anything that has a bed."""

    @property
    def bed(self) -> Bed:
        """The bed."""
        ...


Made = TypeVar("Made", bound=HasBed)


@dataclass(frozen=True, slots=True)
class Aim:
    """How dense a bed is to be.

    Attributes:
        key: Key of the zone that says so, with its place.
        asked: The solid fraction.
        of_core: Whether it is the core's, or that of the filled volume.
        first: The core's fraction with equal spheres in place of the zone's, to begin with.
    """

    key: str
    asked: float
    of_core: bool
    first: float

    def found(self, bed: Bed) -> float | None:
        """Return the fraction that a bed has; None: it is too small for a core."""
        solid = solid_fraction(bed)
        return solid.core if self.of_core else solid.filled


def aim_of(scene: Scene, container: Container, locations: Sequence[Locations]) -> tuple[Scene, Aim | None]:
    """Return how dense the only zone of a scene is to be, and the scene without that key.

    Args:
        scene: The scene.
        container: Its container.
        locations: What bounds each zone beside it.

    Returns:
        (the scene, the aim); None: it does not say, or its algorithm knows the amount that makes a fraction.

    Raises:
        PackingError: No such bed can be made; one line a fault.
    """
    keyed = [index for index, zone in enumerate(scene.zones) if zone.fraction is not None]
    if not keyed or not traits_of(scene.params).compacts:
        return scene, None
    index = keyed[0]
    zone = scene.zones[index]
    path = f"zones[{index}].{zone.density_key}"
    place = f"{scene.mark(path)}: {path}"
    faults = _unsupported(scene, container, locations)
    if faults:
        raise PackingError("\n".join(f"{place}: {each}" for each in faults))
    asked = zone.fraction
    assert asked is not None
    aim = _aim(scene, container, place, asked)
    plain = zone.model_copy(update=dict.fromkeys(FRACTIONS))
    return replace(scene, zones=(plain,)), aim


def _unsupported(scene: Scene, container: Container, locations: Sequence[Locations]) -> list[str]:
    """Return why a bed cannot be compacted at all."""
    faults = []
    if len(scene.zones) > 1:
        faults.append(
            f"found {len(scene.zones)} zones, expected one: a bed of several is not compacted as a whole; "
            "pack them as scenes of their own, or leave the key out"
        )
    elif locations[0]:
        faults.append(
            "found a location, expected none: only the bed of a whole container is compacted; leave one of "
            "both out"
        )
    if scene.start_from is not None:
        faults.append(
            "found start_from, expected none: a bed that goes on from another is not compacted as a whole; "
            "leave one of both out"
        )
    if getattr(scene.params, "tile", None) is not None:
        faults.append("found tiles, expected none: not supported yet; leave one of both out")
    if (instead := traits_of(scene.params).instead) is not None:
        faults.append(f"found optimizer {instead.lower()}, expected projection: not supported yet")
    if floor_direction(np.asarray(scene.gravity_direction, float), container.periodic) is None:
        faults.append(
            "found no floor, expected one: nothing sinks in a box that is periodic along gravity; take "
            "`algorithm: DISPERSED` or `JAMMED`"
        )
    return faults


def _aim(scene: Scene, container: Container, place: str, asked: FractionSpec) -> Aim:
    zone = scene.zones[0]
    supply = Supply(zone, scene.particle_sets, np.random.default_rng(0))
    radius = supply.take(1000).radius
    share = supply.solid_fraction(1.0)
    up = -np.asarray(scene.gravity_direction, float)
    up /= np.linalg.norm(up)
    top = float((container.surface.vertices @ up).max())
    loss = wall_loss(wall_area_below(container, up, top), container.volume, mean_diameter(radius))
    kept = 1.0 if asked.of == "core" else 1.0 - loss
    first = asked.value / kept / share
    if not LOOSEST - 2.0 * SLACK <= first <= DENSEST + 2.0 * SLACK:
        key = zone.density_key or ""
        least, most = LOOSEST * kept * share, DENSEST * kept * share
        if key == "porosity":
            least, most = 1.0 - most, 1.0 - least
        elif key == "void_ratio":
            least, most = 1.0 / most - 1.0, 1.0 / least - 1.0
        raise PackingError(
            f"{place}: found {getattr(zone, key).value:g}, expected about {least:.3f} to {most:.3f}: beds of "
            "such spheres under gravity are neither looser nor denser; change it, or take `algorithm: "
            f"{'DISPERSED` for looser' if first < LOOSEST else 'JAMMED` for denser'} ones without gravity"
        )
    return Aim(place, asked.value, asked.of == "core", min(max(first, LOOSEST), DENSEST))


def as_dense(aim: Aim, make: Callable[[float, int], Made]) -> tuple[Made, float | None]:
    """Pack beds until one is as dense as asked.

    Args:
        aim: How dense.
        make: Packs a bed (core fraction of equal spheres to aim at; number of the try, from 0).

    Returns:
        (what has the bed nearest to it, the fraction of that; None: the beds have no core).
    """
    at, best = aim.first, None
    for number in range(TRIES):
        made = make(at, number)
        found = aim.found(made.bed)
        if found is None:
            return made, None
        off = aim.asked - found
        if best is None or abs(off) < abs(aim.asked - best[1]):
            best = made, found
        following = min(max(at + off, LOOSEST), DENSEST)
        if abs(off) <= NEAR or following == at:
            break
        at = following
    assert best is not None
    return best


def falls(aim: Aim, friction: float) -> str | None:
    """Return a line where the friction of a material cannot carry a bed so loose; None: it can."""
    known, poured = zip(*STANDING, strict=True)
    # Beds denser than packgen's densest are not asked for.
    least = min(float(np.interp(friction, known, poured)), DENSEST)
    if aim.first >= least - FALLING:
        return None
    return (
        f"{aim.key}: found a solid fraction of {aim.asked:g} and a friction of {friction:g}, which cannot "
        "carry so loose a bed: it will sink as soon as a solver lets it go; ask for "
        f"{aim.asked * least / aim.first:.3f}, or raise the friction"
    )


def friction_of(scene: Scene, zone: ZoneSpec) -> float:
    """Return the friction of the smoothest spheres of a zone."""
    of_material = {each.name: each.friction for each in scene.materials}
    shares = zip(scene.particle_sets, zone.set_proportions, strict=True)
    return min(of_material[each.material or ""] for each, share in shares if share > 0.0)
