"""What a forecast says."""

from __future__ import annotations

from dataclasses import dataclass

from packgen.arrays import Float64Array
from packgen.filling.room import Locations
from packgen.forecast.costs import Cost
from packgen.geometry import Container

__all__ = ["Forecast", "SetForecast", "ZoneForecast"]


@dataclass(frozen=True, slots=True)
class ZoneForecast:
    """What a zone will hold.

    Attributes:
        asked: Spheres asked for; None: until full.
        sphere_count: Spheres that it will hold.
        solid_volume: Their volume [m3].
        mass: Their mass [kg].
        solid_fraction: Solid fraction of what they fill, walls included.
        room: Volume of the zone within the container that earlier ones leave [m3].
        bottom: Height of its lower end over the container's [m]; None without gravity.
        top: Height up to which it is filled [m]; None without gravity.
        height_needed: Height that its amount needs in its cross-section [m]; None without gravity.
        locations: What bounds the zone beside the container.
    """

    asked: int | None
    sphere_count: int
    solid_volume: float
    mass: float
    solid_fraction: float
    room: float
    bottom: float | None
    top: float | None
    height_needed: float | None
    locations: Locations


@dataclass(frozen=True, slots=True)
class SetForecast:
    """Spheres of a particle set: its name, how many, and their mass [kg]."""

    name: str
    sphere_count: int
    mass: float


@dataclass(frozen=True, eq=False, slots=True)
class Forecast:
    """What a bed will be like.

    Attributes:
        container: The vessel.
        up: Unit vector against gravity, shape (3,).
        zones: What each zone will hold.
        sets: What there will be of each set.
        height: Level of the bed over the container's lower end [m]; None without gravity.
        highest: How far its highest spheres reach over that end [m]; None without gravity.
        close_packing: Solid fraction of random close packing of all spheres.
        cube_needed: Edge of a cube, filled up to its brim, that all of the amount asked for needs [m].
        factor: Factor by which all lengths of the container will be multiplied; None: it stays.
        cost: Time and memory.
        missed: A line for each thing that will be missed.
        warnings: A line for each thing that looks wrong.
    """

    container: Container
    up: Float64Array
    zones: tuple[ZoneForecast, ...]
    sets: tuple[SetForecast, ...]
    height: float | None
    highest: float | None
    close_packing: float
    cube_needed: float
    factor: float | None
    cost: Cost
    missed: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def sphere_count(self) -> int:
        """Number of spheres."""
        return sum(each.sphere_count for each in self.zones)

    @property
    def mass(self) -> float:
        """Mass of all spheres [kg]."""
        return sum(each.mass for each in self.zones)

    @property
    def solid_fraction(self) -> float:
        """Solid fraction of what all spheres fill, walls included."""
        solid = sum(each.solid_volume for each in self.zones)
        filled = sum(each.solid_volume / each.solid_fraction for each in self.zones if each.solid_volume)
        return solid / filled if filled else 0.0
