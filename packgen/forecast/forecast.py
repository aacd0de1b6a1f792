"""What a scene's bed will be like: amounts, heights, solid fractions, cost, and what will be missed.

Solid fractions are predicted from random close packing, as the refusal of amounts that cannot fit is: a bed
of packgen has 0.956 of it away from its walls, less what the walls cost. Heights follow by the cells of a
grid, to about a percent, as if each zone were level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrange.traits import traits_of
from packgen.arrays import Float64Array
from packgen.container.load import load_location
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackgenError
from packgen.filling.clumps import check_clumps
from packgen.filling.compacted import aim_of, falls, friction_of
from packgen.filling.densest import Sizes, together
from packgen.filling.densities import Density, densities, gap_of
from packgen.filling.earlier import Earlier, earlier_bed
from packgen.filling.fit import asked_of, check_beside, checked_locations
from packgen.filling.periods import check_periods
from packgen.filling.remarks import remarks_of_amounts
from packgen.filling.room import Locations, volume_of
from packgen.filling.softness import check_softness
from packgen.forecast.cells import Cells, Taken
from packgen.forecast.costs import cost_of
from packgen.forecast.misses import SURE, loose_zones, misfit, no_room
from packgen.forecast.result import Forecast, SetForecast, ZoneForecast
from packgen.forecast.voids import expected_voids
from packgen.geometry import Container, floor_direction
from packgen.portable import length
from packgen.scene.models import AMOUNTS
from packgen.supply.close_packing import EQUAL_SPHERES, wall_loss
from packgen.supply.fitting import SumFit
from packgen.supply.shares import mean_weights, number_shares
from packgen.supply.supply import Supply

if TYPE_CHECKING:
    from packgen.scene import Scene

__all__ = ["forecast", "remedies"]

DRAWN_MAX = 3_000_000
"""Number of spheres up to which they are drawn as the run will draw them; of more the mean is taken."""

BED = 0.615
"""Solid fraction of beds of equal spheres away from walls, at friction 0.5 (benchmark `scaling`)."""

ROUGH = 0.9
"""How far the highest spheres reach above the level of a bed, in mean diameters."""


@dataclass(frozen=True, eq=False, slots=True)
class _Zone:
    """What is known of a zone before it is filled: its spheres, and where they go."""

    sizes: Sizes
    mean_volume: float
    count: float | None
    mean_mass: float
    shares: Float64Array
    locations: Locations
    density: Density | None
    supply: Supply | None
    core: float = BED  # with equal spheres in place of its own

    @property
    def solid(self) -> float | None:
        """Solid volume asked for [m3]; None: until full."""
        return None if self.count is None else self.count * self.mean_volume

    @property
    def reach(self) -> float:
        """How far its spheres reach beyond a slice that bounds their centres [m]."""
        return 0.5 * self.sizes.diameter

    @property
    def asked(self) -> int | None:
        """Spheres asked for; None: until full."""
        return None if self.count is None else round(self.count)

    @property
    def placed(self) -> int:
        """Spheres placed: none yet."""
        return 0

    @property
    def counts(self) -> tuple[int, ...] | None:
        """Spheres drawn of each set; None: until full, or too many to draw them now."""
        drawn = None if self.supply is None else self.supply.counts
        return None if drawn is None else tuple(drawn.tolist())

    @property
    def fit(self) -> SumFit | None:
        """How closely the spheres drawn add up to what is asked for."""
        return None if self.supply is None else self.supply.fit

    @property
    def solid_fraction_asked(self) -> float | None:
        """Solid fraction asked for."""
        return None if self.density is None else self.density.fraction


def forecast(
    scene: Scene,
    container: Container,
    warn: Callable[[str], None] = lambda _: None,
    *,
    for_solver: bool = True,
) -> Forecast:
    """Tell what a scene's bed will be like.

    Args:
        scene: The scene.
        container: Its container.
        warn: Called with a line for each thing that looks wrong, as before a run.
        for_solver: Whether the softness of spheres whose Young's modulus the scene does not state is judged.

    Returns:
        The forecast.

    Raises:
        PackgenError: A run of the scene would be refused, with the same lines.
    """
    warnings: list[str] = []

    def tell(line: str) -> None:
        warnings.append(line)
        warn(line)

    check_clumps(scene, container)
    locations = checked_locations(scene, container, tell)
    plain, aim = aim_of(scene, container, locations)
    asked, wanted = densities(plain, container, locations)
    earlier = earlier_bed(scene, container, tell)
    if earlier is not None:
        check_beside(scene, container, earlier.spheres.radius)
    for line in check_softness(scene, container, earlier, for_solver=for_solver):
        tell(line)
    reach = max(
        float(gap_of(zone).half(np.array(asked_of(zone, asked).sizes.radius_max))) for zone in asked.zones
    )
    check_periods(scene, container, reach)
    zones = [_with_voids(scene, container, zone) for zone in _zones(asked, locations, wanted)]
    if aim is not None:
        zones = [replace(zone, core=aim.first) for zone in zones]
        if (warning := falls(aim, friction_of(scene, scene.zones[0]))) is not None:
            tell(warning)
    for line in remarks_of_amounts(asked, zones):
        tell(line)
    found = _fill(scene, container, zones, earlier)
    for line in found.warnings:
        tell(line)
    counts = [each.sphere_count for each in found.zones]
    shares = np.array([zone.shares * count for zone, count in zip(zones, counts, strict=True)]).sum(axis=0)
    heavy = mean_weights("mass", scene.particle_sets)
    sets = tuple(
        SetForecast(each.name, round(float(share)), float(share * mass))
        for each, share, mass in zip(scene.particle_sets, shares, heavy, strict=True)
    )
    all_sizes = _together(zones, counts)
    ratio = max(zone.sizes.radius_max for zone in zones) / min(zone.sizes.radius_min for zone in zones)
    tops = [
        (each.top, each.top + ROUGH * zone.sizes.diameter)
        for each, zone in zip(found.zones, zones, strict=True)
        if each.top is not None and each.sphere_count
    ]
    height, highest = max(tops, default=(None, None))
    return Forecast(
        container, found.up, tuple(found.zones), sets, height, highest, all_sizes.close_packing,
        _cube(zones, found.zones, all_sizes, jammed=_jams(scene), endless=all(container.periodic)),
        found.factor,
        cost_of(
            scene.algorithm, scene.params, sum(counts), ratio,
            aimed=any(zone.solid_fraction_asked is not None for zone in zones),
        ),
        tuple(found.missed), tuple(warnings),
    )  # fmt: skip


def remedies(scene: Scene, container: Container) -> list[str]:
    """Return what amounts that cannot fit need; a line each, none where all may fit or that cannot be told.

    Args:
        scene: A scene that is refused.
        container: Its container.
    """
    if any(zone.density_key is not None for zone in scene.zones):
        return []
    try:
        places = [f"zones[{index}].location" for index in range(len(scene.zones))]
        locations: list[Locations] = [
            () if zone.location is None else (load_location(zone.location, scene, place),)
            for zone, place in zip(scene.zones, places, strict=True)
        ]
    except PackgenError:
        return []
    zones = _zones(scene, locations, [None] * len(locations))
    lines = []
    for index, (zone, made) in enumerate(zip(zones, _fill(scene, container, zones).zones, strict=True)):
        need = 0.0 if zone.solid is None else zone.solid / made.solid_fraction
        if need <= SURE * made.room:
            continue
        cube = _cube([zone], [made], zone.sizes, jammed=_jams(scene), endless=all(container.periodic))
        high = "" if made.height_needed is None else f"a height of {made.height_needed:.4g} m there, or "
        lines.append(f"{_place(scene, index)}: {zone.asked or 0:,} spheres need {high}a cube of {cube:.4g} m")
    return lines


def _zones(scene: Scene, locations: Sequence[Locations], wanted: Sequence[Density | None]) -> list[_Zone]:
    """Return what each zone asks for, drawn as the run will draw it."""
    seeds = np.random.SeedSequence(scene.seed).spawn(len(scene.zones) + 1)[1:]
    zones = []
    for index, (zone, own, density) in enumerate(zip(scene.zones, locations, wanted, strict=True)):
        asked = asked_of(zone, scene)
        count, mean, supply = asked.count, asked.mean_volume, None
        if count is None or count <= DRAWN_MAX:
            supply = Supply(zone, scene.particle_sets, np.random.default_rng(seeds[index]))
            count = None if supply.asked is None else float(supply.asked)
            mean = supply.mean_volume
        shares = number_shares(zone, scene.particle_sets)
        heavy, large = (float(shares @ mean_weights(by, scene.particle_sets)) for by in ("mass", "volume"))
        zones.append(_Zone(asked.sizes, mean, count, mean * heavy / large, shares, own, density, supply))
    return zones


def _with_voids(scene: Scene, container: Container, zone: _Zone) -> _Zone:
    """Return a zone of free sizes with those that it will about have; any other one as it is."""
    if zone.supply is None or zone.supply.free is None:
        return zone
    room = volume_of(container, zone.locations)
    coverage = traits_of(scene.params).coverage
    count, share = expected_voids(zone.supply.free, zone.supply.asked, coverage, room)
    mean = share * room / count
    radius = np.array([np.cbrt(mean / UNIT_VOLUME)])
    sizes = Sizes(radius, np.ones(1), float(radius[0]), float(radius[0]))
    heavy = zone.mean_mass / zone.mean_volume * mean
    return replace(
        zone, sizes=sizes, mean_volume=mean, count=float(round(count)), mean_mass=heavy,
        density=Density(room, share),
    )  # fmt: skip


@dataclass(slots=True)
class _Filled:
    """The zones once they are filled, and what is to be said of them."""

    up: Float64Array
    zones: list[ZoneForecast] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    factor: float | None = None


def _fill(
    scene: Scene, container: Container, zones: Sequence[_Zone], earlier: Earlier | None = None
) -> _Filled:
    """Fill the zones one after the other, on top of the bed that is there before."""
    gravity = np.asarray(scene.gravity_direction, float)
    floor = floor_direction(gravity, container.periodic)
    level = floor is not None and scene.gravity > 0.0
    down = gravity / length(gravity) if floor is None else floor
    cells = Cells(container, down, [(zone.locations, zone.reach) for zone in zones])
    base = cells.take(0, cells.inside, 0.0, mark=False).bottom
    if earlier is not None:
        solid = float((UNIT_VOLUME * earlier.spheres.radius**3).sum())
        top = float((earlier.spheres.position @ -down + earlier.spheres.radius).max())
        cells.take(len(zones), cells.below(top), solid / BED)
    filled, traits = _Filled(-down), traits_of(scene.params)
    fitted, any_amount = traits.fits_container, traits.any_amount
    for index, zone in enumerate(zones):
        place, part = _place(scene, index), cells.within(zone.locations, zone.reach)
        fraction = _settled(scene, container, zone, cells, part, -down)
        need = None if zone.solid is None else zone.solid / fraction
        if (fitted or any_amount) and need is not None:
            filled.factor = float(np.cbrt(need / container.volume)) if fitted else None
            taken = Taken(need, need, base, base, 0.0)
        else:
            taken = cells.take(index, part, need)
        if need is not None and zone.density is None:
            missed, close = (
                ([], []) if any_amount else misfit(place, zone.asked or 0, need, taken, level=level)
            )
            filled.missed += missed
            filled.warnings += [] if filled.factor else close
        elif taken.volume < zone.mean_volume:
            filled.missed.append(no_room(place))
        filled.zones.append(_of_zone(zone, taken, fraction, need, base if level else None))
    if level:
        diameter = 2.0 * max(zone.sizes.radius_max for zone in zones)
        filled.warnings += loose_zones(scene, [zone.locations for zone in zones], cells, diameter)
    return filled


def _place(scene: Scene, index: int) -> str:
    """Return where a scene says how much is in a zone."""
    given = [key for key in AMOUNTS if getattr(scene.zones[index], key) is not None]
    return scene.named(".".join([f"zones[{index}]", *given]))


def _of_zone(
    zone: _Zone, taken: Taken, fraction: float, need: float | None, base: float | None
) -> ZoneForecast:
    """Return what a zone will hold.

    Args:
        zone: The zone.
        taken: What it takes of the container.
        fraction: Its solid fraction.
        need: Volume that its amount needs [m3]; None: it is filled until full.
        base: Altitude of the container's lower end [m]; None: the zone has no level.
    """
    fits = zone.density is not None or (need is not None and taken.volume >= need * (1.0 - 1e-9))
    count = zone.asked or 0 if fits else int(taken.volume * fraction / zone.mean_volume)
    return ZoneForecast(
        zone.asked, count, count * zone.mean_volume, count * zone.mean_mass, fraction, taken.room,
        None if base is None else taken.bottom - base,
        None if base is None else taken.top - base,
        None if base is None else _height(taken, need),
        zone.locations,
    )  # fmt: skip


def _settled(
    scene: Scene, container: Container, zone: _Zone, cells: Cells, part: np.ndarray, up: Float64Array
) -> float:
    """Return the solid fraction of a zone, walls included."""
    if zone.density is not None:
        return zone.density.fraction
    free = zone.sizes.close_packing * (1.0 if _jams(scene) else zone.core / EQUAL_SPHERES)
    fraction = free
    for _ in range(3):
        taken = cells.take(0, part, None if zone.solid is None else zone.solid / fraction, mark=False)
        if taken.volume <= 0.0:
            break
        area = _walls(container, up, taken.bottom - 1e-6 * cells.height.sum(), taken.top)
        fraction = free * (1.0 - wall_loss(area, taken.volume, zone.sizes.diameter))
    return fraction


def _jams(scene: Scene) -> bool:
    """Return whether the algorithm makes jammed packings."""
    return hasattr(scene.params, "fits_container")


def _walls(container: Container, up: Float64Array, bottom: float, top: float) -> float:
    """Return the area of a container's walls between two levels [m2]."""
    from packgen.measure.volumes import wall_area_below

    return wall_area_below(container, up, top) - wall_area_below(container, up, bottom)


def _height(taken: Taken, need: float | None) -> float | None:
    """Return the height that a volume needs [m]; beyond the zone's end with its mean cross-section."""
    if need is None or need <= taken.volume * (1.0 + 1e-9):
        return taken.top - taken.bottom
    return need / taken.area if taken.area > 0.0 else None


def _together(zones: Sequence[_Zone], counts: Sequence[int]) -> Sizes:
    used = [(zone.sizes, float(count)) for zone, count in zip(zones, counts, strict=True) if count]
    return together(used or [(zones[0].sizes, 1.0)])


def _cube(
    zones: Sequence[_Zone], made: Sequence[ZoneForecast], sizes: Sizes, *, jammed: bool, endless: bool
) -> float:
    """Return the edge of a cube without a lid that all of the amount fills [m].

    Args:
        zones: What the zones ask for.
        made: What they hold.
        sizes: The sizes of all of it.
        jammed: Whether they are jammed.
        endless: Whether the cube has no walls.
    """
    solid = sum(
        each.solid_volume if zone.solid is None else zone.solid
        for zone, each in zip(zones, made, strict=True)
    )
    asked = [zone.density.fraction for zone in zones if zone.density is not None]
    core = max(zone.core for zone in zones)
    free = max(asked) if asked else sizes.close_packing * (1.0 if jammed else core / EQUAL_SPHERES)
    edge = float(np.cbrt(solid / free))
    for _ in range(0 if asked or endless else 20):
        loss = wall_loss(5.0 * edge**2, edge**3, sizes.diameter)
        edge = float(np.cbrt(solid / (free * (1.0 - loss))))
    return edge
