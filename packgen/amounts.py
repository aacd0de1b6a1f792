"""Amounts asked for and reached: the spheres of each zone, count, volume and mass of each set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from packgen.bed import UNKNOWN, Bed
from packgen.measure.particles import as_particles
from packgen.measure.volumes import sphere_volume


class ZoneOutcome(Protocol):
    """The part of a zone's result that the report needs.

    It may also have ``solid_fraction_asked`` and ``solid_fraction``; see ``ZoneCount``.
    """

    @property
    def asked(self) -> int | None:
        """Number of spheres asked for; None: until full."""

    @property
    def placed(self) -> int:
        """Number of spheres placed."""


@dataclass(frozen=True, slots=True)
class ZoneCount:
    """Spheres of a zone.

    Attributes:
        asked: Number asked for; None: until full.
        placed: Number placed.
        solid_fraction_asked: Solid fraction asked for, of all of the zone; None: none was.
        solid_fraction: The one reached; None: none was asked for, or it could not be measured.
        slack: Largest difference of the two that is no miss; None: whole spheres decide that.
    """

    asked: int | None
    placed: int
    solid_fraction_asked: float | None = None
    solid_fraction: float | None = None
    slack: float | None = None


@dataclass(frozen=True, slots=True)
class SetTotal:
    """Totals of a particle set.

    Attributes:
        name: Its name.
        count: Number of its particles, spheres or clumps.
        volume: Their solid volume [m3].
        mass: Their mass [kg]; None where their density is not known.
    """

    name: str
    count: int
    volume: float
    mass: float | None


@dataclass(frozen=True, slots=True)
class GoneOn:
    """The bed that a bed goes on from.

    Attributes:
        path: Name of its file; empty where that is not known.
        hold: ``surface``: its spheres near the surface could move again; ``fixed``; or empty likewise.
        earlier_count: Number of its spheres.
        new_count: Number of spheres that were placed beside them.
    """

    path: str
    hold: str
    earlier_count: int
    new_count: int

    def line(self) -> str:
        """Return both counts as text."""
        source = f" of {self.path}" if self.path else ""
        held = {"surface": ", its surface re-opened", "fixed": ", held where they were"}.get(self.hold, "")
        return f"{self.earlier_count:,} earlier{source}{held}; {self.new_count:,} new"


def gone_on(bed: Bed) -> GoneOn | None:
    """Return what a bed goes on from; None where it does not."""
    if bed.earlier is None:
        return None
    told, count = bed.provenance.get("start_from", {}), int(np.count_nonzero(bed.is_earlier))
    return GoneOn(str(told.get("path", "")), str(told.get("hold", "")), count, bed.count - count)


def zone_counts(zones: Sequence[ZoneOutcome]) -> tuple[ZoneCount, ...]:
    """Return what was asked of zones, and what was placed."""
    return tuple(
        ZoneCount(
            zone.asked,
            zone.placed,
            getattr(zone, "solid_fraction_asked", None),
            getattr(zone, "solid_fraction", None),
            getattr(zone, "slack", None),
        )
        for zone in zones
    )


def unfilled(zones: Sequence[ZoneCount]) -> list[str]:
    """Return a line for each zone that did not get its spheres."""
    lines = []
    for index, zone in enumerate(zones):
        if zone.asked is not None and zone.placed < zone.asked:
            lines.append(
                f"zones[{index}]: {zone.placed:,} of {zone.asked:,} spheres placed, "
                f"{zone.asked - zone.placed:,} did not fit{_reached(zone)}; enlarge the zone or ask for fewer"
            )
        elif zone.asked is None and zone.placed == 0:
            lines.append(
                f"zones[{index}]: not one sphere placed; enlarge the zone, or leave it out if others fill it"
            )
        if off := _off(zone):
            lines.append(f"zones[{index}]: {off}")
    return lines


def _off(zone: ZoneCount) -> str:
    """Return what is said of a bed that is looser or denser than asked; empty: it is neither."""
    if zone.solid_fraction_asked is None or zone.slack is None:
        return ""
    if zone.solid_fraction is None:
        return (
            f"its bed has no core, so that nobody knows whether it has the solid fraction of "
            f"{zone.solid_fraction_asked:.4f} asked for; ask for that of the filled volume"
        )
    if abs(zone.solid_fraction - zone.solid_fraction_asked) <= zone.slack:
        return ""
    side = "looser" if zone.solid_fraction < zone.solid_fraction_asked else "denser"
    return (
        f"solid fraction {zone.solid_fraction:.4f}, asked {zone.solid_fraction_asked:.4f}: it is {side}; "
        "ask for what it has, or for more spheres, of which single ones count less"
    )


def _reached(zone: ZoneCount) -> str:
    """Return what is said of the solid fraction of a zone that did not get all spheres."""
    if zone.solid_fraction_asked is None or zone.slack is not None:
        return ""
    return f": a solid fraction of {zone.solid_fraction:.4f} is possible, not {zone.solid_fraction_asked:.4f}"


def set_totals(bed: Bed) -> tuple[SetTotal, ...]:
    """Return count, volume and mass of each set; a clump counts once, overlaps of its spheres too."""
    bed = as_particles(bed)
    volume = sphere_volume(bed.radius)
    totals = []
    for index, each in enumerate(bed.particle_sets):
        chosen = bed.set_index == index
        solid = float(volume[chosen].sum())
        mass = None if np.isnan(each.density) else solid * each.density
        totals.append(SetTotal(each.name, int(chosen.sum()), solid, mass))
    return tuple(totals)


def mass_text(sets: Sequence[SetTotal]) -> str:
    """Return the mass of all sets as text."""
    masses = [each.mass for each in sets if each.mass is not None]
    return f"{sum(masses):,.6g} kg" if len(masses) == len(sets) else UNKNOWN
