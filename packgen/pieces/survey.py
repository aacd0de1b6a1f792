"""What is found of a bed in pieces without any sphere's neighbours: sizes, amounts, heights, its top.

Of radii the distinct ones are counted. Where they are very many, those that differ by less than `WIDTH`
become one class, so that no more than some megabytes are held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.amounts import SetTotal
from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.measure.fraction import TOP_SHARE
from packgen.measure.volumes import sphere_volume
from packgen.pieces.bed import PieceBed

CLASSES_MAX = 200_000
WIDTH = 1.0e-5  # of a class of radii, as a fraction
HEIGHTS = 65_536  # classes of height in which the top is sought


@dataclass(frozen=True, eq=False, slots=True)
class RadiusClasses:
    """Radii and how many spheres have each.

    Attributes:
        radius: Radii [m], rising, shape (K,).
        number: Spheres of each, shape (K,), int64.
    """

    radius: Float64Array
    number: Int64Array

    @classmethod
    def of(cls, radius: Float64Array) -> RadiusClasses:
        """Return the distinct ones of some radii."""
        return cls(*np.unique(radius, return_counts=True))

    def join(self, other: RadiusClasses, most: int = CLASSES_MAX) -> RadiusClasses:
        """Return the classes of both, of more than ``most`` fewer and wider ones."""
        radius, place = np.unique(np.concatenate([self.radius, other.radius]), return_inverse=True)
        number = np.zeros(len(radius), np.int64)
        np.add.at(number, place, np.concatenate([self.number, other.number]))
        if len(radius) <= most:
            return RadiusClasses(radius, number)
        # The largest radius of a class stands for it: a step of a size law stays where it is.
        last = np.append(np.diff(np.floor(np.log(radius) / WIDTH)) > 0.0, True)
        ends = np.cumsum(number)[last]
        return RadiusClasses(radius[last], np.diff(ends, prepend=0))


NO_CLASSES = RadiusClasses(np.zeros(0), np.zeros(0, np.int64))


@dataclass(frozen=True, eq=False, slots=True)
class Survey:
    """What is found of a bed.

    Attributes:
        classes: Radii of each set.
        zone_counts: Number of spheres of each zone.
        volumes: Solid volume of each set [m3].
        top: Height along the direction against gravity at or below which spheres with 95 % of the solid
            volume have their centres [m].
        highest: Height of the highest point of a sphere [m].
        diameter: Mean diameter of all spheres by volume [m].
    """

    classes: tuple[RadiusClasses, ...]
    zone_counts: Int64Array
    volumes: tuple[float, ...]
    top: float
    highest: float
    diameter: float

    def set_totals(self, bed: PieceBed) -> tuple[SetTotal, ...]:
        """Return count, volume and mass of each set."""
        return tuple(
            SetTotal(each.name, count, volume, None if np.isnan(each.density) else volume * each.density)
            for each, count, volume in zip(bed.particle_sets, bed.census.counts, self.volumes, strict=True)
        )

    @property
    def all_classes(self) -> RadiusClasses:
        """Radii of all sets."""
        found = NO_CLASSES
        for each in self.classes:
            found = found.join(each)
        return found


def survey(bed: PieceBed, zones: int, up: Float64Array) -> Survey:
    """Look at all spheres of a bed once, and at those near its top once more.

    Args:
        bed: The bed, whose numbers are finite.
        zones: Number of zones.
        up: Unit vector against gravity, shape (3,).
    """
    sets = len(bed.particle_sets)
    classes = [NO_CLASSES] * sets
    zone_counts = np.zeros(max(zones, 1), np.int64)
    volumes, of_height = np.zeros(sets), np.zeros(HEIGHTS)
    powers, highest = np.zeros(2), -np.inf
    edges = _height_edges(bed, up)
    for chunk in bed.chunks():
        volume, height = sphere_volume(chunk.radius), chunk.position @ up
        for each in range(sets):
            classes[each] = classes[each].join(RadiusClasses.of(chunk.radius[chunk.set_index == each]))
        zone_counts += np.bincount(chunk.zone_index, minlength=len(zone_counts))[: len(zone_counts)]
        volumes += np.bincount(chunk.set_index, volume, sets)
        of_height += np.bincount(_class_of(height, edges), volume, HEIGHTS)
        powers += (chunk.radius**3).sum(), (chunk.radius**4).sum()
        highest = max(highest, float((height + chunk.radius).max()))
    top = _top(bed, up, edges, np.cumsum(of_height))
    diameter = 2.0 * float(powers[1] / powers[0])
    return Survey(tuple(classes), zone_counts, tuple(volumes.tolist()), top, highest, diameter)


def _height_edges(bed: PieceBed, up: Float64Array) -> tuple[float, float]:
    """Return the least and the largest height that a centre may have [m]."""
    low, high = np.array(bed.census.low) * up, np.array(bed.census.high) * up
    return float(np.minimum(low, high).sum()), float(np.maximum(low, high).sum())


def _class_of(height: Float64Array, edges: tuple[float, float]) -> Int64Array:
    span = edges[1] - edges[0]
    share = (height - edges[0]) / span if span > 0.0 else np.zeros(len(height))
    return np.asarray(np.clip(share * HEIGHTS, 0, HEIGHTS - 1).astype(np.int64))


def _top(bed: PieceBed, up: Float64Array, edges: tuple[float, float], below: Float64Array) -> float:
    """Return the height of the bed's top, by the spheres of the class of heights in which it is."""
    wanted = TOP_SHARE * below[-1]
    place = int(np.searchsorted(below, wanted))
    heights, volumes = [np.zeros(0)], [np.zeros(0)]
    for chunk in _near(bed, up, edges, place):
        height = chunk.position @ up
        own = _class_of(height, edges) == place
        heights.append(height[own])
        volumes.append(sphere_volume(chunk.radius[own]))
    height, volume = np.concatenate(heights), np.concatenate(volumes)
    order = np.argsort(height, kind="stable")
    share = np.cumsum(volume[order]) + (below[place - 1] if place else 0.0)
    return float(height[order[min(int(np.searchsorted(share, wanted)), len(order) - 1)]])


def _near(bed: PieceBed, up: Float64Array, edges: tuple[float, float], place: int) -> list[Bed]:
    """Return the spheres of a class of heights and of the next ones to it."""
    step = (edges[1] - edges[0]) / HEIGHTS
    middle = edges[0] + (place + 0.5) * step
    axis = int(np.abs(up).argmax())
    if abs(abs(up[axis]) - 1.0) > 1e-12:
        return list(bed.chunks())
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    low[axis], high[axis] = sorted([(middle - step) * up[axis], (middle + step) * up[axis]])
    return [bed.bed_of([bed.in_box(low, high)[0]])]
