"""Check and measures of a bed in pieces, as a report has them: each a pass over the pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from packgen.amounts import ZoneOutcome, zone_counts
from packgen.check import Check, Checker, wall_clearance
from packgen.check.naming import FaultNamer
from packgen.errors import ReadError
from packgen.measure.fraction import against_gravity
from packgen.measure.sizes import SizeLaw, Sizes, sizes_of_classes
from packgen.pieces import PieceBed
from packgen.pieces.measure import LEFT_OUT, measured
from packgen.pieces.survey import RadiusClasses, survey
from packgen.report import Measures

SLACK = 1.0 + 1.0e-9
"""Keeps pairs that rounding would put just beyond their reach."""


def left_out() -> str:
    """Return a line that says what is not measured of a bed in pieces."""
    return f"{' and '.join(LEFT_OUT)} are left out (null): they hang on the whole bed, which is in pieces"


def check_pieces(bed: PieceBed) -> Check:
    """Check every pair and every wall of a bed in pieces, pairs of two pieces included.

    Returns:
        What `packgen.check.check_bed` finds of the bed in one piece, to the last digit.
    """
    check = Checker(bed.tolerance)
    for part in bed.parts(_reach(bed)):
        check.add(part, None if bed.container.walls_known else np.full(part.own, np.inf))
    return check.result()


def faults_in_pieces(bed: PieceBed) -> tuple[str, ...]:
    """Return the lines of `packgen.check.naming.named_faults` for a bed in pieces."""
    if bed.tolerance is None:
        return ()
    namer = FaultNamer(bed.tolerance)
    for part in bed.parts(_reach(bed)):
        own = part.bed.position[: part.own], part.bed.radius[: part.own]
        known = bed.container.walls_known
        namer.add(part, wall_clearance(bed.container, *own) if known else np.full(part.own, np.inf))
    return namer.result()


def _reach(bed: PieceBed) -> float:
    return 2.0 * SLACK * max(bed.census.radius_max)


def _sizes(bed: PieceBed, place: int, classes: RadiusClasses, law: SizeLaw | None) -> Sizes | None:
    """Return the sizes of a set; only its curves hang on classes of radii."""
    name, census = bed.particle_sets[place].name, bed.census
    found = sizes_of_classes(name, classes.radius, classes.number.astype(np.float64), law)
    if found is None:
        return None
    mean = float(census.radius_sum[place] / census.counts[place])
    return replace(found, radius_min=census.radius_min[place], radius_mean=mean)


def measure_pieces(
    bed: PieceBed,
    check: Check,
    *,
    zones: Sequence[ZoneOutcome] = (),
    laws: Sequence[SizeLaw | None] = (),
) -> Measures:
    """Measure a bed in pieces, as `packgen.report.measure_bed` does a bed in one, to rounding.

    Args:
        bed: The bed.
        check: Its check.
        zones: What was asked of each zone, and what was placed.
        laws: Size distribution of each particle set; may be left out.

    Returns:
        The measures; `packgen.pieces.measure.LEFT_OUT` names those that are not measured.

    Raises:
        ReadError: The bed has numbers that are not finite, which no measure takes.
    """
    if check.invalid_count:
        raise ReadError(f"{bed.folder}: {check.faults()[0]}, expected numbers; make the bed anew")
    up = against_gravity(bed)
    known = survey(bed, len(zones), up)
    overlaps = bool(check.overlap_count or check.wall_overlap_max)
    found = measured(bed, known, up, overlaps=overlaps)
    by_law = [*laws, *[None] * (len(bed.particle_sets) - len(laws))]
    compared = [
        _sizes(bed, place, classes, law)
        for place, (classes, law) in enumerate(zip(known.classes, by_law, strict=True))
    ]
    return Measures(
        sphere_count=bed.count,
        zones=zone_counts(zones),
        sets=known.set_totals(bed),
        overlap=check,
        solid_fraction=found.solid_fraction,
        close_packing=found.close_packing,
        contacts=found.contacts,
        sizes=tuple(each for each in compared if each is not None),
        profile=found.profile,
        gaps=found.gaps,
        coordination=found.coordination,
        radial=found.radial,
        pair_correlation=found.pair_correlation,
        order=found.order,
        step_zero=found.step_zero,
        stands_at_friction=found.stands_at_friction,
    )
