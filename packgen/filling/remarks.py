"""What looks wrong in a packed bed: a line for each thing, with its place in the scene and a remedy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import AnyBed, Bed
from packgen.check.sides import free_standing_zones
from packgen.check.support import hanging_zones
from packgen.distributions import Free
from packgen.geometry import Shape, Slice
from packgen.measure.particles import as_particles
from packgen.supply.fitting import SumFit
from packgen.supply.shares import mean_weights, number_shares, reached_amounts

if TYPE_CHECKING:
    from packgen.scene import Scene, ZoneSpec

__all__ = ["PackedZone", "remarks", "remarks_in_pieces", "remarks_of_amounts"]

SHARE_ERROR = 0.005
"""Deviation of a set's share in a zone that is tolerated for any number of spheres."""

FEW = 200
"""Number of spheres of a zone below which the volumes and masses of its sets hang on single spheres."""

UNITS = {"volume": "m3", "mass": "kg"}


class PackedZone(Protocol):
    """The outcome of a zone; ``packgen.filling.pack.ZoneResult`` is one."""

    @property
    def asked(self) -> int | None:
        """Spheres asked for; None: until full."""
        ...

    @property
    def placed(self) -> int:
        """Spheres placed."""
        ...

    @property
    def locations(self) -> Sequence[Shape | Slice]:
        """What bounds the zone beside the container."""
        ...

    @property
    def counts(self) -> tuple[int, ...] | None:
        """Spheres drawn of each set; None: until full."""
        ...

    @property
    def fit(self) -> SumFit | None:
        """How closely the spheres drawn add up to a volume or mass; None: none was asked for."""
        ...


def remarks(scene: Scene, bed: Bed, zones: Sequence[PackedZone]) -> tuple[str, ...]:
    """Return a line for each thing of a packed scene that looks wrong, though all spheres are placed.

    Args:
        scene: The scene.
        bed: Its bed.
        zones: The outcome of each of its zones, in their order.
    """
    return (
        *_hanging(scene, bed, zones),
        *_free_standing(scene, bed, zones),
        *remarks_of_amounts(scene, zones),
        *_off_shares(scene, as_particles(bed), zones),
    )


def remarks_of_amounts(scene: Scene, zones: Sequence[PackedZone]) -> tuple[str, ...]:
    """Return a line for each thing that looks wrong in the spheres drawn, wherever they will be placed.

    Args:
        scene: The scene.
        zones: Each of its zones, in their order.
    """
    return (*_off_sums(scene, zones), *_without_spheres(scene, zones))


def remarks_in_pieces(scene: Scene, bed: AnyBed, zones: Sequence[PackedZone]) -> tuple[str, ...]:
    """Return what `remarks` does, of a bed in pieces; what is not looked at there is said."""
    return (
        *(
            f"{_place(scene, index)}: whether anything holds it up is not looked at in a bed in pieces; "
            "pack it without --pieces to know"
            for index, zone in enumerate(zones)
            if zone.locations
        ),
        *remarks_of_amounts(scene, zones),
        *_off_shares(scene, bed, zones),
    )


def _place(scene: Scene, zone: int) -> str:
    path = f"zones[{zone}]"
    return scene.named(path)


def _hanging(scene: Scene, bed: Bed, zones: Sequence[PackedZone]) -> list[str]:
    """Return a line for each zone that nothing holds up."""
    return [
        f"{_place(scene, each.zone)}: nothing holds it up: of {each.looked_at} spheres at its lower end "
        f"{each.hanging} have neither sphere nor wall below, and will fall by about {each.fall:.3g} m; "
        "lower the zone onto what is below it, or fill the space in between first"
        for each in hanging_zones(bed, [zone.locations for zone in zones])
    ]


def _free_standing(scene: Scene, bed: Bed, zones: Sequence[PackedZone]) -> list[str]:
    """Return a line for each zone whose sides nothing holds."""
    return [
        f"{_place(scene, each.zone)}: nothing holds {each.free / each.looked_at:.0%} of its side: of "
        f"{each.looked_at} spheres there {each.free} have neither sphere nor wall beside them, and will fall "
        f"by about {each.fall:.3g} m; fill what is beside the zone, or add a wall there"
        for each in free_standing_zones(bed, [zone.locations for zone in zones])
    ]


def _off_sums(scene: Scene, zones: Sequence[PackedZone]) -> list[str]:
    """Return a line for each zone whose spheres do not add up to what it asks for."""
    lines = []
    for index, zone in enumerate(zones):
        fit = zone.fit
        if fit is None or not fit.missed:
            continue
        asked = getattr(zone, "solid_fraction_asked", None)
        if asked is not None:
            lines.append(_off_fraction(scene, index, asked, fit))
            continue
        unit = UNITS[fit.by]
        why = "the shares of its sets allow" if fit.shared else "its spheres allow"
        lines.append(
            f"{_place(scene, index)}: found {fit.found:.6g} {unit}, asked {fit.wanted:.6g} {unit}, "
            f"{abs(fit.found - fit.wanted):.3g} {unit} too {'much' if fit.found > fit.wanted else 'little'}: "
            f"{why} no nearer in whole spheres; ask for {fit.found:.6g} {unit}, or change the "
            f"{'shares' if fit.shared else 'radii'}"
        )
    return lines


def _off_fraction(scene: Scene, index: int, asked: float, fit: SumFit) -> str:
    """Return the line of a zone whose spheres do not make the fraction that it asks for."""
    found, why = asked * fit.found / fit.wanted, "the shares of its sets" if fit.shared else "its spheres"
    return (
        f"{_place(scene, index)}: found spheres for a solid fraction of {found:.6g}, asked {asked:.6g}: "
        f"{why} allow no nearer in whole spheres"
    )


def _without_spheres(scene: Scene, zones: Sequence[PackedZone]) -> list[str]:
    """Return a line for each set that a zone has a share of, but not one sphere."""
    lines = []
    for index, (spec, zone) in enumerate(zip(scene.zones, zones, strict=True)):
        if zone.counts is None:
            continue
        for each, share, count in zip(scene.particle_sets, spec.set_proportions, zone.counts, strict=True):
            if share > 0.0 and count == 0:
                lines.append(
                    f"{_place(scene, index)}: found no sphere of {each.name}, expected a share of "
                    f"{share:.3g} by {spec.proportions_by}: too little for a whole one; ask for more, or set "
                    "the share to 0"
                )
    return lines


def _off_shares(scene: Scene, bed: AnyBed, zones: Sequence[PackedZone]) -> list[str]:
    """Return a line for each zone whose sets are not in the proportions asked for."""
    lines = []
    for index, (spec, zone) in enumerate(zip(scene.zones, zones, strict=True)):
        amount, largest = reached_amounts(bed, index, spec.proportions_by)
        asked = np.array(spec.set_proportions)
        counts, _ = reached_amounts(bed, index, "number")
        made = (asked == 0.0) & np.array(
            [isinstance(each.distribution, Free) for each in scene.particle_sets]
        )
        # Spheres that fill voids are no part of the shares.
        amount, counts = np.where(made, 0.0, amount), np.where(made, 0.0, counts)
        if zone.placed == 0 or _as_whole_spheres_allow(spec, scene, counts, amount, largest):
            continue
        shares = [", ".join(f"{each:.3f}" for each in part) for part in (amount / amount.sum(), asked)]
        why = (
            "so they were drawn; ask for more spheres, or for a volume or mass"
            if zone.placed == zone.asked
            else "some sizes found less room; ask for an amount that fits, or give more room"
        )
        lines.append(
            f"{_place(scene, index)}: found shares {shares[0]} by {spec.proportions_by}, expected "
            f"{shares[1]}: {why}"
        )
    return lines


def _as_whole_spheres_allow(
    zone: ZoneSpec, scene: Scene, counts: Float64Array, amount: Float64Array, largest: Float64Array
) -> bool:
    """Tell whether the sets of a zone are as near to their shares as whole spheres can be.

    Counts may be rounded up or down. A zone with a volume or mass leaves half a sphere of each set open, one
    with a number a whole sphere. The total of the shares is then as uncertain. Without a sum spheres are
    drawn by number, and a few of a broad law are no fair sample of its volume.

    Args:
        zone: The zone.
        scene: Its scene.
        counts: Number of spheres of each set, shape (sets,).
        amount: Number, volume [m3] or mass [kg] of each set, shape (sets,).
        largest: The largest sphere of each, in the same unit, shape (sets,); 0 where there is none.
    """
    share, by = np.array(zone.set_proportions), zone.proportions_by
    off = np.abs(amount - share * amount.sum())
    if off.max() <= SHARE_ERROR * amount.sum():
        return True
    if by == "number":
        return _rounded(share, amount)
    summed = zone.volume is not None or zone.mass is not None
    if not summed and counts.sum() < FEW and _rounded(number_shares(zone, scene.particle_sets), counts):
        return True
    sphere = np.where(share > 0.0, np.maximum(largest, mean_weights(by, scene.particle_sets)), 0.0)
    open_part = 0.5 * sphere if summed else sphere
    slack = (1.0 - share) * open_part + share * (open_part.sum() - open_part)
    return bool((off <= slack * (1.0 + 1e-9)).all())


def _rounded(share: Float64Array, counts: Float64Array) -> bool:
    """Tell whether counts are their shares of the total, rounded up or down."""
    return bool((np.abs(counts - share * counts.sum()) < 1.0 - 1e-9).all())
