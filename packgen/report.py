"""The report of a run: what was asked, what was reached, as ``report.json`` and as a table."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from packgen.amounts import (
    GoneOn,
    SetTotal,
    ZoneCount,
    ZoneOutcome,
    gone_on,
    mass_text,
    set_totals,
    unfilled,
    zone_counts,
)
from packgen.arrays import Float64Array
from packgen.bed import UNKNOWN, Bed, has_clumps
from packgen.bedfile import plain
from packgen.check import Check, check_bed, wall_clearance
from packgen.cores import free_cores
from packgen.jamming import Jamming
from packgen.measure import (
    ClosePacking,
    Contacts,
    Gaps,
    HeightProfile,
    LocalOrder,
    PairCorrelation,
    RadialProfile,
    Sizes,
    SolidFraction,
    Standing,
    close_packing,
    contacts_and_gaps,
    core_of,
    height_profile,
    local_order,
    pair_correlation,
    radial_profile,
    sizes,
    solid_fraction_with,
    standing,
)
from packgen.measure.bodies import BodyMeasures, body_measures
from packgen.measure.coordination import Coordination, coordination
from packgen.measure.forces import PredictedForces, predicted_forces
from packgen.measure.hertz import mean_weight
from packgen.measure.order import WALL_REACH
from packgen.measure.particles import as_particles
from packgen.measure.sizes import SizeLaw
from packgen.search import Search
from packgen.settlement import Settling
from packgen.version import __version__

ROUNDING = 1.0e-13  # share of a radius


@dataclass(frozen=True, slots=True)
class Measures:
    """What is measured of a bed.

    Attributes:
        sphere_count: Number of spheres in the bed, those of clumps among them.
        zones: Spheres asked for and placed, zone by zone.
        sets: Totals, set by set.
        overlap: The independent check: overlaps as fractions of the smaller radius.
        solid_fraction: Solid fractions of the filled volume and of the core.
        close_packing: Random close packing of the spheres, beside what the bed reached; None of a bed without
            spheres, and of one with clumps.
        contacts: Contacts a sphere at gaps of 0, 0.1 %, 1 % and 5 % of the smaller radius; of a bed with
            clumps a particle, one for each pair of them.
        sizes: Size curves asked and reached, set by set.
        profile: Solid fraction along the height.
        gaps: Pairs of neighbours counted by their gap.
        coordination: Contacts a sphere over the gap, and their plateau; None without spheres, with clumps,
            and of a bed too large for it.
        radial: Porosity over the distance from the wall; None where the container is not round.
        pair_correlation: g(r) of the core; None where the bed has no room for one.
        order: Shares of the spheres that sit in a crystal; clumps count by their centres of mass.
        step_zero: The largest forces that a solver will find before anything moves, by geometry alone; None
            without gravity, or where materials or densities are not known.
        stands_at_friction: Whether the contacts can carry the bed's weight, and from what friction on; None
            of a bed that rests on nothing, and of spheres joined to bodies.
        jamming: How the bed is jammed, and the proof; None of other algorithms than JAMMED.
        search: How the bed was found, and how good it could be; None of algorithms that do not search.
        settling: How a solver settled the bed, and the bed before and after; None where none did.
        start_from: Spheres that were there before, and new ones; None of a bed that goes on from no other.
        bodies: The clumps: numbers, masses, and how they lie; None of a bed without clumps.
    """

    sphere_count: int
    zones: tuple[ZoneCount, ...]
    sets: tuple[SetTotal, ...]
    overlap: Check
    solid_fraction: SolidFraction
    close_packing: ClosePacking | None
    contacts: tuple[Contacts, ...]
    sizes: tuple[Sizes, ...]
    profile: HeightProfile
    gaps: Gaps
    coordination: Coordination | None
    radial: RadialProfile | None
    pair_correlation: PairCorrelation | None
    order: LocalOrder
    step_zero: PredictedForces | None
    stands_at_friction: Standing | None
    jamming: Jamming | None = None
    search: Search | None = None
    settling: Settling | None = None
    start_from: GoneOn | None = None
    bodies: BodyMeasures | None = None

    def faults(self) -> tuple[str, ...]:
        """Return a line for each zone that did not get its spheres and each limit that the bed breaks."""
        unsettled = () if self.settling is None else self.settling.missed()
        return (*unfilled(self.zones), *self.overlap.faults(), *unsettled)


@dataclass(frozen=True, slots=True, kw_only=True)
class Report(Measures):
    """All that is known of a bed: the measures, and what the run did; `KEYS` has the keys in their order.

    Attributes:
        packgen: Version that made the bed.
        missed: A line for each thing that was asked for and not reached; empty when all is well.
        warnings: A line for each thing that looks wrong although all was reached: mended meshes, likely
            mistakes in units, zones that nothing holds up or at their sides, shares and sums that whole
            spheres miss.
        timings: Wall time of each stage [s].
        peak_memory: Largest memory that the process held [bytes]; None where the system does not tell.
        settings: Scene, seed and effective settings, as in ``bed.npz``.
        files: Everything that the run wrote, relative to its folder.
    """

    packgen: str
    missed: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    timings: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    peak_memory: int | None = None
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    files: tuple[str, ...] = ()

    def as_json(self) -> str:
        """Return the text of ``report.json``."""
        # Not asdict of the whole: it copies the mappings by their constructor, which a view lacks.
        content: dict[str, Any] = {}
        for name in KEYS:
            value = getattr(self, name)
            if isinstance(value, tuple):
                content[name] = [each if isinstance(each, str) else asdict(each) for each in value]
            elif hasattr(value, "__dataclass_fields__"):
                content[name] = asdict(value)
            else:
                content[name] = plain(value)
        content["overlap"]["within_tolerance"] = self.overlap.within_tolerance
        if self.step_zero is not None:
            content["step_zero"]["force_max"] = self.step_zero.force_max
        return json.dumps(content, indent=2, ensure_ascii=False) + "\n"

    def write(self, path: Path) -> None:
        """Write ``report.json``."""
        path.write_text(self.as_json(), encoding="utf-8")

    def rows(self) -> list[tuple[str, str]]:
        """Return the summary as rows of a label and a value."""
        solid, check = self.solid_fraction, self.overlap
        asked = [zone.asked for zone in self.zones]
        known = [number for number in asked if number is not None]
        before = 0 if self.start_from is None else self.start_from.earlier_count
        wanted = f" of {before + sum(known):,}" if len(known) == len(asked) and known else ""
        tolerance = f"tolerance {'none' if check.tolerance is None else f'{check.tolerance:.3g}'}"
        if self.settling is not None:
            tolerance = self.settling.allowed()
        elif check.new is not None:
            tolerance = f"of new ones {check.new.overlap_max:.3g} r, {tolerance}"
        packing = self.close_packing
        beside = f", {packing.reached:.2f} of its random close packing" if packing else ""
        by_core = solid.core is not None
        walls = self.settings.get("walls") != UNKNOWN
        rows = [
            *self._counts(wanted),
            *([] if self.start_from is None else [("start_from", self.start_from.line())]),
            ("mass", mass_text(self.sets)),
            ("solid fraction, filled volume", f"{solid.filled:.4f}{'' if by_core else beside}"),
            ("solid fraction, core", f"{solid.core:.4f}{beside}" if by_core else solid.core_rule),
            ("largest overlap", f"{check.overlap_max:.3g} r ({tolerance})"),
            ("largest overlap with a wall", f"{check.wall_overlap_max:.3g} r" if walls else UNKNOWN),
        ]
        if self.contacts:
            gaps = " / ".join(f"{entry.gap:.1%}".replace(".0%", "%") for entry in self.contacts)
            means = " / ".join(f"{entry.mean:.2f}" for entry in self.contacts)
            of = "a sphere" if self.bodies is None else "a particle"
            rows.append((f"contacts {of} at gaps of {gaps}", means))
        if self.step_zero is not None:
            rows.append(("largest step-0 force, predicted", f"{self.step_zero.force_max:.3g} W"))
        if self.stands_at_friction is not None:
            rows.append(("stands from a friction of", self.stands_at_friction.as_text()))
        if self.jamming is not None:
            rows += [("jammed", self.jamming.line()), ("container", self.jamming.container_line())]
        if self.search is not None:
            rows += [("found", self.search.line()), ("bound", self.search.bound_line())]
            rows += [("cell", self.search.cell_line())] if self.search.cell is not None else []
        rows += [] if self.settling is None else self.settling.rows()
        rows += [
            (f"size curve of {each.name}, off by", f"{each.by_mass.distance_max:.2%} by mass")
            for each in self.sizes
            if each.by_mass.distance_max is not None
        ]
        rows += [(f"time, {stage}", f"{seconds:.1f} s") for stage, seconds in self.timings.items()]
        if self.peak_memory is not None:
            rows.append(("peak memory", f"{self.peak_memory / 1e6:,.0f} MB"))
        return rows

    def _counts(self, wanted: str) -> list[tuple[str, str]]:
        """Return the rows of how many particles there are, and how clumps lie."""
        if self.bodies is None:
            return [("spheres", f"{self.sphere_count:,}{wanted}")]
        bodies = self.bodies
        return [
            ("particles", f"{bodies.body_count:,}{wanted}: {bodies.line()}"),
            ("spheres of all", f"{self.sphere_count:,}"),
            *(
                (f"orientation of {each.name}", each.lie())
                for each in bodies.shapes
                if each.order is not None
            ),
        ]


MEASURED = tuple(each.name for each in fields(Measures))
KEYS = ("packgen", "missed", *MEASURED, "warnings", "timings", "peak_memory", "settings", "files")
"""The keys of ``report.json``, in their order."""


def build_report(
    bed: Bed,
    *,
    zones: Sequence[ZoneOutcome] = (),
    laws: Sequence[SizeLaw | None] = (),
    check: Check | None = None,
    clearance: Float64Array | None = None,
    threads: int | None = None,
    jamming: Jamming | None = None,
    search: Search | None = None,
) -> Report:
    """Measure a bed, as `measure_bed` does; the report has no timings, memory and files."""
    measures = measure_bed(
        bed, zones=zones, laws=laws, check=check, clearance=clearance, threads=threads, jamming=jamming,
        search=search,
    )  # fmt: skip
    return compose_report(measures, bed.provenance)


def compose_report(
    measures: Measures,
    settings: Mapping[str, Any],
    *,
    missed: Sequence[str] = (),
    warnings: Sequence[str] = (),
    timings: Mapping[str, float] = MappingProxyType({}),
    peak_memory: int | None = None,
    files: Sequence[str] = (),
) -> Report:
    """Return the report of a bed; see `Report` for what is not told here.

    Args:
        measures: What was measured of the bed.
        settings: The bed's provenance.
        missed: What was missed beside the measures' own faults, which come first.
        warnings: What looks wrong.
        timings: Wall time of each stage [s].
        peak_memory: Largest memory of the process [bytes].
        files: What the run wrote.
    """
    return Report(
        **{name: getattr(measures, name) for name in MEASURED},
        packgen=__version__,
        missed=(*measures.faults(), *missed),
        warnings=tuple(warnings),
        timings=timings,
        peak_memory=peak_memory,
        settings=settings,
        files=tuple(files),
    )


def measure_bed(
    bed: Bed,
    *,
    zones: Sequence[ZoneOutcome] = (),
    laws: Sequence[SizeLaw | None] = (),
    check: Check | None = None,
    clearance: Float64Array | None = None,
    threads: int | None = None,
    jamming: Jamming | None = None,
    search: Search | None = None,
) -> Measures:
    """Measure a bed.

    Args:
        bed: The bed.
        zones: What was asked of each zone, and what was placed.
        laws: Size distribution of each particle set; may be left out.
        check: The check of this bed, where it has been made already.
        clearance: Distance of each centre from the nearest wall [m], exact up to `WALL_REACH` radii, where it
            is known; shape (N,).
        threads: Threads to use; None: as many as cores are free. The numbers do not depend on it.
        jamming: How the bed is jammed, where its algorithm tells.
        search: How the bed was found, where its algorithm tells.

    Returns:
        The measures.
    """
    found = check if check is not None else check_bed(bed)
    if search is not None and search.maximized != "fraction":
        laws = ()  # what is chosen or scaled follows no law
    by_law = [*laws, *[None] * (len(bed.particle_sets) - len(laws))]
    compared = [_sizes(bed, index, law) for index, law in enumerate(by_law)]
    core = core_of(bed)
    # Each is a search of its own; the arrays they work through are long enough to leave the interpreter free.
    with ThreadPoolExecutor(threads or free_cores()) as pool:
        radial = pool.submit(radial_profile, bed)
        correlation = pool.submit(pair_correlation, bed, core)
        if clearance is None:
            clearance = wall_clearance(bed.container, bed.position, WALL_REACH * bed.radius)
        order = pool.submit(local_order, bed, core, clearance)
        contacts = pool.submit(contacts_and_gaps, bed, clearance=clearance)
        solid = pool.submit(solid_fraction_with, bed, core)
        profile = pool.submit(height_profile, bed)
        forces = pool.submit(_step_zero, bed, found, clearance)
        stands = pool.submit(standing, bed)
        number = pool.submit(coordination, bed, clearance)
        packing = close_packing(bed, solid.result())
    touching, gaps = contacts.result()
    return Measures(
        sphere_count=bed.count,
        zones=zone_counts(zones),
        sets=set_totals(bed),
        overlap=found,
        solid_fraction=solid.result(),
        close_packing=packing,
        contacts=touching,
        sizes=tuple(each for each in compared if each is not None),
        profile=profile.result(),
        gaps=gaps,
        coordination=number.result(),
        radial=radial.result(),
        pair_correlation=correlation.result(),
        order=order.result(),
        step_zero=forces.result(),
        stands_at_friction=stands.result(),
        start_from=gone_on(bed),
        jamming=None if jamming is None else replace(jamming, crystal=order.result().crystal),
        search=search,
        bodies=body_measures(bed),
    )


def _sizes(bed: Bed, index: int, law: SizeLaw | None) -> Sizes | None:
    """Return the sizes of a set; those drawn from a law are the new ones, where others were there before."""
    clumps, bed = has_clumps(bed), as_particles(bed)
    chosen, new = bed.set_index == index, ~bed.is_earlier
    drawn = chosen & new if (chosen & new).any() else chosen
    radius, compared = bed.radius[drawn], law if (drawn & new).any() else None
    if clumps and compared is not None:
        # A clump's size is its scale times its template's: by rounding beside the radius that was drawn.
        for bound in compared.radius_bounds:
            radius = np.where(np.abs(radius / bound - 1.0) < ROUNDING, bound, radius)
    return sizes(bed.particle_sets[index].name, radius, compared)


def _step_zero(bed: Bed, check: Check, clearance: Float64Array) -> PredictedForces | None:
    """Return the predicted forces; where the check found no overlap at all, a second search finds none."""
    if not (bed.gravity.any() and bed.materials and bed.weights_known) or bed.container.cell is not None:
        return None
    if bed.count and not (check.overlap_count or check.wall_overlap_max or check.invalid_count):
        return PredictedForces(mean_weight(bed), 0.0, None, 0, 0.0, None, 0, 0)
    return predicted_forces(bed, clearance)
