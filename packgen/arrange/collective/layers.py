"""The default outer loop: thin layers on a re-opened surface, each arranged by the projection optimiser."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packgen.arrange.collective.layer_starts import LayerStarts
from packgen.arrange.collective.loose import settled_with_loose
from packgen.arrange.collective.open_zone import LayerReport, OpenZone, no_report
from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.collective.surface import Surface
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.lowest_place import lowest_place
from packgen.arrange.space.seams import Seams
from packgen.arrange.spheres import Spheres, joined
from packgen.arrays import Float64Array
from packgen.bodies import whole_bodies
from packgen.portable import cube

STALLED_SHARE = 0.02
STALLED_MAX = 3
"""The zone is full after `STALLED_MAX` layers in a row that gain at most `STALLED_SHARE` of the volume they
try."""

TRIES_MIN = 8
"""A failed layer of fewer spheres than this counts as a fraction of a failure: a narrow tube has room for
one."""


@dataclass(frozen=True, eq=False, slots=True)
class Begun:
    """A bed that was begun by other means.

    Attributes:
        front: Its spheres near the surface.
        buried_tops: Top of its other spheres, column by column [m].
        level: Altitude up to which it is filled [m].
    """

    front: Spheres
    buried_tops: Float64Array
    level: float


def fill_in_layers(
    zone: OpenZone,
    recipe: Recipe,
    plan: LayerPlan,
    on_layer: LayerReport = no_report,
    first_batch: int = 0,
    begun: Begun | None = None,
) -> int:
    """Fill a zone until the supply is finished or nothing more fits.

    Args:
        zone: The zone; its pile grows.
        recipe: Constants of the optimiser.
        plan: Thickness of the layers.
        on_layer: Called after each layer.
        first_batch: Number of the first layer.
        begun: The bed that the layers go on; None: there is none.

    Returns:
        Number of the next batch.
    """
    loop = _Layers(zone, recipe, plan)
    surface = loop.surface
    if begun is not None:
        zone.pile.front = begun.front
        surface.go_on(begun.buried_tops, begun.level)
    batch, stalled, thrown_back = first_batch, 0.0, 0
    while not zone.supply.finished and stalled < STALLED_MAX and surface.base < zone.region.ceiling:
        level = surface.level
        gained, back, tried = loop.add(batch)
        thrown_back += back
        # Without an end game a full vessel takes any number of spheres, one inside the other.
        crammed = recipe.tolerance is None and surface.level < level + STALLED_SHARE * surface.thickness
        if not surface.started or (gained > STALLED_SHARE and not crammed):
            stalled = 0.0
        else:
            stalled += 1.0 if crammed else failure(tried)
        if stalled >= STALLED_MAX and not zone.supply.finished and (loop.put_singly(batch) or loop.climb()):
            # Another chamber may lie above a throat, or a tip may widen. One layer there will tell.
            stalled = STALLED_MAX - 1.0
        batch += 1
        on_layer(batch, len(zone.pile), surface.level, thrown_back)
    return batch


def failure(tried: int) -> float:
    """Return the weight of a layer that gained nothing: 1 where it found no room, or tried enough spheres."""
    return min(1.0, tried / TRIES_MIN) if tried else 1.0


class _Layers:
    """Adds layer after layer to a zone."""

    def __init__(self, zone: OpenZone, recipe: Recipe, plan: LayerPlan) -> None:
        self.zone, self.recipe = zone, recipe
        self.surface = Surface(zone, plan)
        self.starts = LayerStarts(zone, self.surface)
        self.closing = self.searched = self.singly = False

    def add(self, batch: int) -> tuple[float, int, int]:
        """Add one layer; return (share of its volume gained, spheres thrown back, spheres to be placed).

        An overfull layer is undone and tried again with fewer spheres. It counts as if it had found room: it
        does not tell whether the zone is full.
        """
        zone, surface = self.zone, self.surface
        front, tops = zone.pile.front, surface.tops()
        start, draw = self.starts.assigned(self.starts.points(tops), front)
        tried = len(draw.radius)
        # The last spheres go on top of the bed: re-opening it would throw back as many as it places.
        reopened = surface.shallow(front, tops, start) & (not self.closing)
        self.closing = self.closing or zone.supply.finished
        moving, fixed = joined([zone.newcomers(start, draw, batch), front[reopened]]), front[~reopened]
        position, kept = settled_with_loose(zone, moving, fixed, self.recipe, surface.above_buried)
        kept = whole_bodies(kept, moving.body_index)
        settled, thrown = replace(moving, position=position)[kept], moving[~kept]
        volume = float(np.sum(cube(settled.radius)) - np.sum(cube(front.radius[reopened])))
        gained = volume / float(np.sum(cube(draw.radius))) if tried else min(volume, 0.0)
        overfull = self.starts.overfull(gained, closing=self.closing)
        if overfull or gained < 0.0:
            # A layer that removes more volume than it adds is discarded, too.
            zone.supply.put_back(draw)
            return (1.0 if overfull else 0.0), tried, tried
        zone.put_back(thrown)
        zone.pile.front = joined([fixed, settled])
        surface.started = surface.started or gained > 0.0
        self.singly = self.singly and gained <= 0.0
        if not surface.started:
            self._rise(batch, tried)
        surface.bury()
        return gained, len(thrown), tried

    def _rise(self, batch: int, tried: int) -> None:
        """Rise to where a first sphere fits: the tip of a hopper is too narrow, or too steep to sink into."""
        surface = self.surface
        surface.base += 0.25 * surface.diameter * failure(tried)
        if not self.searched:
            self.searched = True
            self.put_singly(batch)

    def put_singly(self, batch: int) -> bool:
        """Put one sphere at the lowest place where no other sphere of the zone is; tell whether one is there.

        Once a layer has found a place, none is put singly: where layers find no more, the zone is full.
        """
        zone, surface = self.zone, self.surface
        if surface.started and not self.singly:
            return False
        first, own = zone.supply.take(1), zone.pile.front
        own = own[own.zone_index == zone.index]
        radius, others = float(first.radius[0]), np.column_stack([own.position, own.radius])
        place = lowest_place(zone.region, radius * (1.0 + self.recipe.gap), others)
        if place.center is not None and len(first.radius) == 1:
            sphere = zone.newcomers(place.center[None], first, batch)
            if _is_clear(sphere, zone.pile.all(), zone.region.walls.seams):
                zone.pile.front = joined([zone.pile.front, sphere])
                surface.started = self.singly = True
                return True
        zone.supply.put_back(first)
        if not surface.started and not zone.supply.broad:
            # Nowhere below is a place. Where there is none at all, the zone is full.
            surface.base = max(surface.base, place.altitude - radius)
        return False

    def climb(self) -> bool:
        """Raise the level to the next room between non-convex walls or earlier beds; False: there is none."""
        return self.surface.climb(lambda: len(self.starts.points(self.surface.tops())) > 0)


def _is_clear(sphere: Spheres, others: Spheres, seams: Seams) -> bool:
    """Tell whether a single sphere overlaps none of the others."""
    apart = others.position - sphere.position
    wraps = seams.period > 0.0
    apart[:, wraps] -= seams.period[wraps] * np.rint(apart[:, wraps] / seams.period[wraps])
    touching = others.radius + sphere.radius
    return bool(((apart * apart).sum(axis=1) >= touching * touching).all())
