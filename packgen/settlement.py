"""What is known of a bed that a solver has settled: how long that took, and the bed before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from packgen.check import Check
    from packgen.measure import Contacts, SolidFraction

DEM_TOLERANCE = 0.2
"""Largest overlap of a bed that a solver has settled, as a fraction of the smaller radius.

The spheres of the discrete element method carry their load by overlaps. A scene of which no warning is given
has 0.05 in a mean contact at its foot (``packgen.filling.softness``), and about four times as much in the
strongest of a million, whose forces are spread as exp(-1.5 f): what is deeper is a fault.
"""
CONTACT_GAP = 0.01  # smaller radii


@dataclass(frozen=True, slots=True)
class BedFigures:
    """A bed in a few figures, of which two sets are put side by side.

    Attributes:
        solid_fraction: Solid fraction of the filled volume.
        core: Solid fraction of the core; None where the bed has no room for one.
        contacts: Contacts a sphere at gaps up to 1 % of the smaller radius.
        top: Height of the bed's top, see ``solid_fraction.top`` [m].
        overlap_max: Largest overlap of two spheres, as a fraction of the smaller radius.
        wall_overlap_max: Largest overlap with a wall, as a fraction of the radius.
        seconds: Wall time that making it took [s].
    """

    solid_fraction: float
    core: float | None
    contacts: float
    top: float
    overlap_max: float
    wall_overlap_max: float
    seconds: float

    def cells(self) -> tuple[str, ...]:
        """Return the figures as text, in the order of `LABELS`."""
        return (
            f"{self.solid_fraction:.4f}",
            "none" if self.core is None else f"{self.core:.4f}",
            f"{self.contacts:.2f}",
            f"{self.top:.5g} m",
            f"{self.overlap_max:.3g} r",
            f"{self.wall_overlap_max:.3g} r",
            f"{self.seconds:.1f} s",
        )


LABELS = (
    "solid fraction, filled volume",
    "solid fraction, core",
    "contacts a sphere at gaps of 1%",
    "height of the top",
    "largest overlap",
    "largest overlap with a wall",
    "time it took",
)


def bed_figures(
    check: Check, fraction: SolidFraction, touching: Sequence[Contacts], seconds: float
) -> BedFigures:
    """Return a bed in a few figures.

    Args:
        check: The check of the bed.
        fraction: Its solid fractions.
        touching: Its contacts, among them those at gaps of 1 %.
        seconds: Wall time that making it took [s].
    """
    contacts = next(each.mean for each in touching if each.gap == CONTACT_GAP)
    return BedFigures(
        fraction.filled, fraction.core, contacts, fraction.top, check.overlap_max, check.wall_overlap_max,
        seconds,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Settling:
    """How a solver settled the bed.

    Attributes:
        solver: Its name.
        version: What it calls itself, with its version.
        until: What was asked for: ``still``, or a time such as ``0.5 s``.
        still: Whether the bed was still in the end: the mean speed of its spheres stayed below
            ``still_speed`` for one free-fall time.
        interrupted: Whether a stop ended the run before.
        time: Time that passed in the solver [s].
        steps: Steps that it took.
        free_fall_times: That time, in times sqrt(2 r / g), r the mean radius.
        speed: Mean speed of the spheres in the end, in sqrt(g r).
        still_speed: Mean speed below which the bed counts as still, likewise.
        displacement_mean: Mean displacement of the spheres, in mean radii.
        displacement_max: Largest displacement, likewise.
        tolerance: Largest overlap that the settled bed may have, as a fraction of the smaller radius; None:
            the scene allows soft spheres.
        restart: The solver's own state of the settled bed, relative to the folder; empty without one.
        before: The bed as it was packed.
        after: The bed as it was settled.
    """

    solver: str
    version: str
    until: str
    still: bool
    interrupted: bool
    time: float
    steps: int
    free_fall_times: float
    speed: float
    still_speed: float
    displacement_mean: float
    displacement_max: float
    tolerance: float | None
    restart: str
    before: BedFigures
    after: BedFigures

    @property
    def ending(self) -> str:
        """In what state the bed was left, in words."""
        if self.interrupted:
            return "interrupted"
        return "still" if self.still else "still moving"

    def line(self) -> str:
        """Return how it went, in a line."""
        return f"{self.ending} {self.course()}"

    def course(self) -> str:
        """Return how long it took, and what it did, as the end of a line."""
        return (
            f"after {self.time:.4g} s ({self.free_fall_times:.3g} free-fall times), "
            f"mean speed {self.speed:.2g} sqrt(g r), moved by {self.displacement_mean:.2g} r"
        )

    def allowed(self) -> str:
        """Return which overlaps a bed of soft spheres may have."""
        return "DEM bed, no limit" if self.tolerance is None else f"DEM bed, at most {self.tolerance:g}"

    def missed(self) -> tuple[str, ...]:
        """Return a line where the bed is not as still as was asked for."""
        if self.interrupted:
            return (f"{self.solver}: interrupted before the bed was settled, {self.course()}",)
        if self.still or self.until != "still":
            return ()
        return (
            f"{self.solver}: the bed is not still {self.course()}, expected less than "
            f"{self.still_speed:g} sqrt(g r); --until TIME settles for a time that you give",
        )

    def rows(self) -> list[tuple[str, str]]:
        """Return the summary as rows of a label and a value."""
        sides = zip(LABELS, self.before.cells(), self.after.cells(), strict=True)
        return [
            (f"settled by {self.solver}", self.line()),
            *((f"packed, settled: {label}", f"{before}, {after}") for label, before, after in sides),
        ]
