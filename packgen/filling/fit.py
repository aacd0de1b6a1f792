"""Whether the amounts of a scene can fit where they are to go: told before a long run starts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrange.registry import BUILTIN
from packgen.arrange.traits import traits_of
from packgen.arrays import Float64Array
from packgen.container.load import load_location
from packgen.distributions import UNIT_VOLUME
from packgen.errors import GeometryError, PackingError
from packgen.filling.clumps import has_clumps
from packgen.filling.densest import Sizes, densest_ordered, densest_random, poured_fraction, together
from packgen.filling.room import Locations, narrowest, room_of, width_of
from packgen.filling.unit_remarks import extent_text, units_remark
from packgen.geometry import Container
from packgen.supply.close_packing import EQUAL_SPHERES
from packgen.supply.shares import expected_count, free_sizes, mean_weights, number_shares, size_weights
from packgen.supply.supply import COUNT_LIMIT

if TYPE_CHECKING:
    from packgen.scene import Scene, ZoneSpec

MANY = 50_000_000
"""Number of spheres from which a zone without an amount gets a warning before the run."""

VAST = 1000.0
"""Width of a container [largest diameters] from which a counted zone gets a warning before the run."""

WIDE_SHARE = 1.0e-3
"""Largest share of a set's mass in spheres too wide for the container; above, the scene is refused."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What a zone asks for: sizes, mean volume of a sphere [m3], and number; None: until full.

    Attributes:
        free: Whether its sizes are those of the voids; the sizes here are then the least ones.
    """

    sizes: Sizes
    mean_volume: float
    count: float | None
    free: bool = False


class Amounts:
    """What the zones of a scene ask of a container."""

    def __init__(self, scene: Scene, container: Container) -> None:
        self._scene, self._container = scene, container
        traits = traits_of(scene.params)
        self._any, self._fitted = traits.any_amount, traits.any_amount or traits.fits_container
        self._zones = [asked_of(zone, scene) for zone in scene.zones]
        self._remark = units_remark(
            scene,
            container,
            min(zone.sizes.radius_min for zone in self._zones),
            max(zone.sizes.radius_max for zone in self._zones),
        )

    def too_wide(self) -> list[str]:
        """Return a line for each set whose spheres are wider than the container."""
        if self._any:
            return []
        scene, bounds = self._scene, self._container.bounds
        width, axis = narrowest(bounds, self._container.periodic)
        # A sphere as wide as its box fits; rounding must not tell otherwise.
        half = 0.5 * width * (1.0 + 1e-9)
        smallest = min(zone.sizes.radius_min for zone in self._zones)
        if smallest > half:
            return [
                f"{scene.named('container')}: found {extent_text(bounds)}, but not one sphere fits "
                f"(smallest radius {smallest:.4g} m); expected a larger container or smaller spheres; "
                f"{self._remark}"
            ]
        faults = []
        for index, each in enumerate(scene.particle_sets):
            widest = 2.0 * each.distribution.radius_bounds[1]
            share = 1.0 - float(each.distribution.cumulative_mass(np.array([half]))[0])
            if widest > 2.0 * half and share > WIDE_SHARE:
                path = f"particle_sets[{index}]"
                faults.append(
                    f"{scene.named(path)}: found spheres up to {widest:.4g} m wide, {share:.1%} of "
                    f"the mass in spheres wider than the container, {width:.4g} m along {axis}; expected "
                    f"smaller ones; {self._remark}"
                )
        return faults

    def too_many(self, index: int, room: float, width: float) -> list[str]:
        """Return a line where a zone of some volume [m3] and least extent [m] asks for more than fits."""
        zone, spec, scene = self._zones[index], self._scene.zones[index], self._scene
        path = f"zones[{index}]"
        if zone.free:
            return self._too_many_free(zone, path, room)
        if zone.count is None:
            count = self._filling_count(zone, room, COUNT_LIMIT)
            if count <= COUNT_LIMIT:
                return []
            return [
                f"{scene.named(path)}: found {room:.4g} m3 to fill, about {count:.3g} spheres, "
                f"expected at most {COUNT_LIMIT:,}; {self._remark}"
            ]
        asked = zone.count * zone.mean_volume
        if self._fitted or asked <= EQUAL_SPHERES * room:
            return []  # mixtures are denser than equal spheres
        densest, packing = self._densest(room, width, zone.sizes), self._packing
        if asked <= densest * room:
            return []
        poured = poured_fraction(self._container, zone.sizes)
        key = next(name for name in ("n_particles", "volume", "mass") if getattr(spec, name) is not None)
        limit = getattr(spec, key) * densest * room / asked
        unit = {"volume": " m3", "mass": " kg"}.get(key, "")
        most = f"{limit:.4g}{unit}" if unit else f"{int(limit):,}"
        return [
            f"{scene.named(f'{path}.{key}')}: found {getattr(spec, key):,.6g}{unit}, expected "
            f"at most {most}: the zone has {room:.4g} m3, of which no {packing} of such spheres fills more "
            f"than {densest:.2f}, and a poured bed about {poured:.2f}; {self._remark}"
        ]

    def _too_many_free(self, zone: Asked, path: str, room: float) -> list[str]:
        """Return a line where the smallest spheres that a zone may have do not fit, one beside the other."""
        if zone.count is None or zone.count * zone.mean_volume <= room:
            return []
        return [
            f"{self._scene.named(f'{path}.n_particles')}: found {zone.count:,.0f}, expected at most "
            f"{int(room / zone.mean_volume):,}: the zone has {room:.4g} m3, and no sphere is smaller than "
            f"radius_min = {zone.sizes.radius_min:.4g} m; {self._remark}"
        ]

    def too_many_together(self, earlier: Float64Array | None = None) -> list[str]:
        """Return a line where the zones fit one by one, but not together.

        Args:
            earlier: Radii of spheres that are there before [m], shape (N,); None: there are none.
        """
        volume, width = self._container.volume, width_of(self._container)
        counted = [(zone, zone.count) for zone in self._zones if zone.count and not zone.free]
        solid = new = sum(count * zone.mean_volume for zone, count in counted)
        if earlier is not None:
            solid += float((UNIT_VOLUME * earlier**3).sum())
        if self._fitted or not counted or solid <= EQUAL_SPHERES * volume:
            return []
        # One mixture or one above the other, whichever is denser.
        kinds = [
            together([(zone.sizes, count) for zone, count in counted]),
            *(zone.sizes for zone, _ in counted),
        ]
        if earlier is not None:
            old = Sizes(earlier, np.ones(len(earlier)), float(earlier.min()), float(earlier.max()))
            kinds += [old, together([(kinds[0], sum(count for _, count in counted)), (old, len(earlier))])]
        densest = max(self._densest(volume, width, sizes) for sizes in kinds)
        if solid <= densest * volume:
            return []
        if earlier is not None:
            return [
                f"{self._scene.named('zones')}: found {new:.4g} m3 of spheres beside {solid - new:.4g} m3 of "
                f"start_from, expected at most {densest * volume:.4g} m3 together, {densest:.2f} of the "
                f"container's {volume:.4g} m3; ask for fewer"
            ]
        return [
            f"{self._scene.named('zones')}: found {solid:.4g} m3 of spheres in all of them together, "
            f"expected at most {densest * volume:.4g} m3, {densest:.2f} of the container's {volume:.4g} m3; "
            "ask for fewer"
        ]

    def suspicions(self, rooms: Sequence[float]) -> list[str]:
        """Return a line for what looks like a container in the wrong unit, far too large for its spheres."""
        scene, bounds = self._scene, self._container.bounds
        lines = []
        for index, (zone, room) in enumerate(zip(self._zones, rooms, strict=True)):
            if zone.free:
                continue
            count = self._filling_count(zone, room, MANY)
            if zone.count is None and count > MANY:
                path = f"zones[{index}]"
                lines.append(
                    f"{scene.named(path)}: about {count:.3g} spheres will fill its {room:.4g} m3; "
                    f"{self._remark}"
                )
        width, _ = narrowest(bounds, self._container.periodic)
        widest = 2.0 * max(zone.sizes.radius_max for zone in self._zones)
        counted = all(zone.count is not None and not zone.free for zone in self._zones)
        if counted and not self._fitted and VAST * widest < width < np.inf:
            lines.append(
                f"{scene.named('container')}: {extent_text(bounds)}, {width / widest:,.0f} times "
                f"as wide as the largest sphere; {self._remark}"
            )
        return lines

    def room(self, index: int, own: Locations) -> float:
        """Return the volume of a zone [m3] with these locations.

        Raises:
            GeometryError: It has none within the container.
        """
        path, zone = f"zones[{index}].location", self._zones[index]
        place = self._scene.named(path)
        sizes = zone.sizes
        return room_of(self._container, own, sizes.radius_min, sizes.radius_max, place)

    @property
    def _packing(self) -> str:
        """What the scene's algorithm makes: ours no crystals, plug-ins maybe."""
        return "random packing" if self._scene.algorithm in BUILTIN else "packing"

    def _densest(self, room: float, width: float, sizes: Sizes) -> float:
        """Return the solid fraction of a volume [m3] of some least extent [m] that sizes cannot exceed."""
        if has_clumps(self._scene):
            return 1.0  # blocks fit each other better than any spheres
        if self._scene.algorithm in BUILTIN:
            return densest_random(room, width, sizes)
        return densest_ordered(room, sizes)

    def _filling_count(self, zone: Asked, room: float, enough: float) -> float:
        """Return about how many spheres fill a volume [m3]; exact only above what is enough."""
        most = room / zone.mean_volume
        return most if most <= enough else most * poured_fraction(self._container, zone.sizes)


def checked_locations(
    scene: Scene, container: Container, warn: Callable[[str], None] = lambda _: None
) -> tuple[Locations, ...]:
    """Return the shapes that bound each zone beside the container, once what the zones ask for makes sense.

    Args:
        scene: The scene.
        container: Its container.
        warn: Called with a line for each fault of a mesh that was mended, and each unit that looks wrong.

    Returns:
        The shapes of each zone, none for the whole container.

    Raises:
        PackingError: A location cannot be read, lies outside the container, or has no volume; spheres are too
            wide, or more than could ever fit. One line a fault, all of them at once.
    """
    amounts = Amounts(scene, container)
    faults = amounts.too_wide()
    wrong_size = bool(faults)
    locations: list[Locations] = []
    rooms: list[float] = []
    for index, zone in enumerate(scene.zones):
        path = f"zones[{index}].location"
        try:
            own = () if zone.location is None else (load_location(zone.location, scene, path, warn),)
            room = container.volume if wrong_size else amounts.room(index, own)
        except GeometryError as error:
            faults.append(str(error))
            continue
        locations.append(own)
        rooms.append(room)
        faults += [] if wrong_size else amounts.too_many(index, room, width_of(container, own))
    faults = faults or amounts.too_many_together()
    if faults:
        raise PackingError("\n".join(faults))
    for line in amounts.suspicions(rooms):
        warn(line)
    return tuple(locations)


def check_beside(scene: Scene, container: Container, radius: Float64Array) -> None:
    """Refuse more spheres than ever fit beside those that are there before, of some radii [m], shape (N,).

    Raises:
        PackingError: The scene asks for more.
    """
    faults = Amounts(scene, container).too_many_together(radius)
    if faults:
        raise PackingError("\n".join(faults))


def asked_of(zone: ZoneSpec, scene: Scene) -> Asked:
    """Return what a zone asks for, on average over the laws of size."""
    sets = scene.particle_sets
    share = number_shares(zone, sets)
    bounds = [each.distribution.radius_bounds for each, part in zip(sets, share, strict=True) if part > 0.0]
    mean_volume = float(share @ mean_weights("volume", sets))
    smallest, largest = min(low for low, _ in bounds), max(high for _, high in bounds)
    sizes = Sizes(*size_weights(share, sets), smallest, largest)
    return Asked(sizes, mean_volume, expected_count(zone, sets), free_sizes(zone, sets) is not None)
