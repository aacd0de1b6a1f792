"""How far a bed's own weight presses its spheres into each other, known before the first one is placed.

Assumptions and sources:

- The bed is level and fills the container from below at a solid fraction of 0.6, with the amounts that the
  zones ask for; a zone without an amount is full.
- Janssen (Zeitschrift des Vereins deutscher Ingenieure 39 (1895) 1045): walls carry part of the weight. At
  depth z the stress is s = w D / (4 f K) (1 - exp(-4 f K z / D)), where w is the weight of a cubic metre of
  bed, f the friction at the wall, D = 4 area / perimeter, and K Rankine's active ratio of the stresses across
  and along, (1 - sin p) / (1 + sin p) with tan p = friction. Where the shape does not tell the perimeter, it
  is that of a circle, the least: that is the safe side.
- The mean force of a contact under that stress: F = pi d^2 s / (phi Z) (Rumpf, Chemie-Ingenieur-Technik 42
  (1970) 538; Bathurst and Rothenburg, J. Appl. Mech. 55 (1988) 17) with Z = 6 contacts a sphere. A floor
  carries the spheres of its lowest layer, which cover 0.8 of it: F = pi r^2 s / 0.8.
- Hertz: F = 4/3 Y sqrt(R) delta^1.5 (Johnson, Contact Mechanics (1985), chapter 4), with R = r / 2 of two
  spheres, r of one at a wall. F is proportional to r^2, so that delta / r does not depend on r.

This is the overlap of a mean contact at the foot, by which scenes are judged. Forces f, in means, are spread
as exp(-1.5 f) (Mueth, Jaeger and Nagel, Phys. Rev. E 57 (1998) 3164), so that the largest of some hundred
contacts is about four means, and its overlap 4^(2/3) of the mean one's.

Against LIGGGHTS (``tests/test_softness.py``), boxes with 5 % expected and so 12.6 % at most: 400 spheres on
0.6 x 0.6 m at rest have 5.4 % in the lowest tenth and 12.6 % at most, 1111 on 1 x 1 m have 3.7 and 10.3 %.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Material, pair_coefficient
from packgen.distributions import UNIT_VOLUME
from packgen.errors import SceneError
from packgen.geometry import Box, Container, floor_direction
from packgen.supply.shares import expected_count, mean_weights, number_shares

if TYPE_CHECKING:
    from packgen.filling.earlier import Earlier
    from packgen.scene import Scene
    from packgen.scene.models import ZoneSpec

__all__ = ["OVERLAP_ERROR", "OVERLAP_WARNING", "Softness", "check_softness", "softness"]

OVERLAP_WARNING = 0.05  # radii; a usual bound of the method of soft spheres is a few percent
OVERLAP_ERROR = 0.5  # radii; spheres pass through each other and through walls
SOLID_FRACTION = 0.6
CONTACTS = 6.0  # contacts of a sphere
FLOOR_COVERED = 0.8
STRONG_FORCE = 4.0  # largest force over the mean one
LEVELS = 17  # heights at which the container's volume is looked up


@dataclass(frozen=True, slots=True)
class Softness:
    """The load on the spheres at a bed's foot.

    Attributes:
        height: Height of the bed [m].
        stress: Stress at its foot, what the walls carry taken off [Pa].
        overlap: Mean overlap of the softest contacts there, as a fraction of the radius.
        material: Name of the softest material of those contacts.
        modulus_wanted: Young's modulus, of both sides, at which the overlap is `OVERLAP_WARNING` [Pa].
    """

    height: float
    stress: float
    overlap: float
    material: str
    modulus_wanted: float

    @property
    def overlap_max(self) -> float:
        """Largest overlap there, as a fraction of the radius."""
        return float(STRONG_FORCE ** (2 / 3)) * self.overlap


def check_softness(
    scene: Scene, container: Container, earlier: Earlier | None = None, *, for_solver: bool
) -> list[str]:
    """Return a warning where the bed's weight presses spheres deep into each other; none where it does not.

    Args:
        scene: The scene.
        container: Its container.
        earlier: The bed that it goes on from; None: there is none.
        for_solver: Whether a deck is written: without one, only a modulus that the scene states counts.

    Raises:
        SceneError: They would pass through each other, and the scene does not say ``allow_soft``.
    """
    found = softness(scene, container, earlier)
    if found is None or found.overlap < OVERLAP_WARNING:
        return []
    location = ("materials", found.material, "youngs_modulus")
    if not for_solver and not scene.marked.states(location):
        return []
    place = scene.marked.named(location)
    modulus = next(each.youngs_modulus for each in scene.materials if each.name == found.material)
    line = (
        f"{place}: found {modulus:.3g} Pa, expected at least {_rounded_up(found.modulus_wanted):.2g} Pa: at "
        f"the foot of a bed {found.height:.3g} m high a stress of {found.stress:.3g} Pa presses spheres "
        f"{100 * found.overlap:.2g} % of a radius into each other, some {100 * found.overlap_max:.2g} %"
    )
    if found.overlap < OVERLAP_ERROR:
        return [f"{line}; raise it if the solver's bed sinks too far"]
    if found.material in scene.soft_materials:
        return [f"{line}, and solvers may lose some; the scene allows that"]
    raise SceneError([f"{line}, and solvers lose some; raise it, or say `allow_soft: true` in the material"])


def softness(scene: Scene, container: Container, earlier: Earlier | None = None) -> Softness | None:
    """Return the load on the spheres at the foot of a scene's bed; None where it has no foot.

    Args:
        scene: The scene.
        container: Its container.
        earlier: The bed that it goes on from, whose weight counts; None: there is none.
    """
    gravity = np.asarray(scene.gravity_direction, float)
    down = floor_direction(gravity, container.periodic)
    solid, mass = _amounts(scene, container, earlier)
    if down is None or not solid > 0.0:
        return None
    height, area = _filled(container, down, solid / SOLID_FRACTION)
    weight = SOLID_FRACTION * mass / solid * scene.gravity * float(down @ gravity)
    used = _used(scene, earlier)
    wall = next(each for each in scene.materials if each.name == scene.wall_material)
    stress = _janssen(weight, height, _width(container, down, area), used, wall)
    first, second, at_wall = max(_contacts(used, wall), key=lambda each: _compliance(*each))
    overlap = (stress * _compliance(first, second, at_wall)) ** (2 / 3)
    softest = min((first, second), key=lambda each: each.youngs_modulus).name
    # The compliance at a modulus of 1 Pa on both sides equals the modulus that makes it 1 / Pa.
    alike = _compliance(replace(first, youngs_modulus=1.0), replace(second, youngs_modulus=1.0), at_wall)
    return Softness(height, stress, overlap, softest, stress * alike / OVERLAP_WARNING**1.5)


def _contacts(used: list[Material], wall: Material) -> Iterator[tuple[Material, Material, bool]]:
    """Yield the two materials of each kind of contact, and whether it is one with the wall."""
    for each in used:
        yield each, each, False
        yield each, wall, True


def _compliance(first: Material, second: Material, at_wall: bool) -> float:
    """Return (delta / r)^1.5 over the stress [1/Pa]; see the module's text."""
    modulus = 1 / sum((1 - each.poissons_ratio**2) / each.youngs_modulus for each in (first, second))
    if at_wall:
        return math.pi / FLOOR_COVERED / (4 / 3 * modulus)
    return 4 * math.pi / (SOLID_FRACTION * CONTACTS) / (4 / 3 * modulus * math.sqrt(0.5))


def _used(scene: Scene, earlier: Earlier | None) -> list[Material]:
    """Return the scene's materials of the sets that some zone, or the bed before, uses."""
    names = {
        each.material
        for index, each in enumerate(scene.particle_sets)
        if any(zone.set_proportions[index] > 0.0 for zone in scene.zones)
    }
    if earlier is not None:
        names |= {
            earlier.scene.particle_sets[index].material for index in np.unique(earlier.spheres.set_index)
        }
    return [each for each in scene.materials if each.name in names]


def _amounts(scene: Scene, container: Container, earlier: Earlier | None) -> tuple[float, float]:
    """Return solid volume [m3] and mass [kg] of the bed, at most what the container holds."""
    before, heavy_before = (0.0, 0.0) if earlier is None else _amounts_before(earlier)
    room = max(SOLID_FRACTION * container.volume - before, 0.0)
    solid = mass = 0.0
    for zone in scene.zones:
        share = number_shares(zone, scene.particle_sets)
        one = float(share @ mean_weights("volume", scene.particle_sets))
        heavy = float(share @ mean_weights("mass", scene.particle_sets))
        count = expected_count(zone, scene.particle_sets)
        volume = SOLID_FRACTION * _zone_room(scene, container, zone) if count is None else count * one
        solid, mass = solid + volume, mass + volume * heavy / one
    part = min(1.0, room / solid) if solid > 0.0 else 0.0
    return before + part * solid, heavy_before + part * mass


def _amounts_before(earlier: Earlier) -> tuple[float, float]:
    """Return solid volume [m3] and mass [kg] of the bed that a scene goes on from."""
    volume = UNIT_VOLUME * earlier.spheres.radius**3
    density = np.array([each.density for each in earlier.scene.particle_sets])
    return float(volume.sum()), float((volume * density[earlier.spheres.set_index]).sum())


def _zone_room(scene: Scene, container: Container, zone: ZoneSpec) -> float:
    """Return the volume [m3] that a zone cannot exceed: that of its bounding box, or the container's."""
    location = zone.location
    if location is None or location.path is not None:
        return container.volume
    from packgen.container.load import load_location
    from packgen.geometry.bounds import shape_bounds

    low, high = shape_bounds(load_location(location, scene, "zones"))
    low, high = np.maximum(low, container.bounds[0]), np.minimum(high, container.bounds[1])
    return min(container.volume, float(np.maximum(high - low, 0.0).prod()))


def _filled(container: Container, down: Float64Array, volume: float) -> tuple[float, float]:
    """Return the height [m] to which a volume [m3] fills the container, and the mean cross-section [m2]."""
    from packgen.measure.volumes import container_volume_below

    corners = container.bounds[[[int(bit) for bit in f"{number:03b}"] for number in range(8)], range(3)]
    low, high = float((corners @ -down).min()), float((corners @ -down).max())
    level = np.linspace(low, high, LEVELS)
    below = np.maximum.accumulate(container_volume_below(container, -down, level))
    first = float(np.interp(1e-6 * below[-1], below, level))
    height = max(float(np.interp(volume, below, level)) - first, 1e-9 * (high - low))
    return height, min(volume, float(below[-1])) / height


def _width(container: Container, down: Float64Array, area: float) -> float:
    """Return D = 4 area / perimeter [m]; infinite where no wall stands beside the bed."""
    axis = int(np.abs(down).argmax())
    if isinstance(container.shape, Box) and abs(float(down[axis])) == 1.0:
        first, second = (other for other in range(3) if other != axis)
        size = container.bounds[1] - container.bounds[0]
        sides = sum(
            2 * float(size[along])
            for along, across in ((first, second), (second, first))
            if not container.periodic[across]
        )
        return 4 * area / sides if sides > 0.0 else math.inf
    return math.inf if any(container.periodic) else 2 * math.sqrt(area / math.pi)


def _janssen(weight: float, height: float, width: float, used: list[Material], wall: Material) -> float:
    """Return the stress [Pa] at the foot of a bed.

    Args:
        weight: Weight of a cubic metre of bed [N/m3].
        height: Height of the bed [m].
        width: 4 area / perimeter of the vessel [m].
        used: Materials of the spheres.
        wall: Material of the wall.
    """
    screening = min(
        pair_coefficient(each.friction, wall.friction) * _active_ratio(each.friction) for each in used
    )
    depth = 4 * screening * height / width
    return weight * height * (-math.expm1(-depth) / depth if depth > 1e-12 else 1.0)


def _active_ratio(friction: float) -> float:
    sine = math.sin(math.atan(friction))
    return (1 - sine) / (1 + sine)


def _rounded_up(value: float) -> float:
    """Return a number rounded up to two significant digits."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / power * (1 - 1e-12)) * power
