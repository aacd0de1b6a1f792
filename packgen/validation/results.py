"""What a solver measured of a bed, and the verdict on it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

JUDGED_SHARE = 0.25  # of the gravity run that the limits ask for


@dataclass(frozen=True, slots=True)
class Limits:
    """What a bed has to keep to, and how much work the proof may take.

    Attributes:
        force_limit: Largest step-0 contact force, in mean sphere weights; None: any, of a bed that a solver
            has settled, whose contacts carry it.
        displacement_limit: Mean displacement in the gravity run that is not elastic, in mean radii.
        sinking_limit: Sinking of the centre of mass that is not elastic, as a fraction of its height above
            the bed's lowest point.
        lost_limit: Number of spheres that may leave the container.
        law_limit: Relative difference of step-0 forces from Hertz' law.
        free_fall_times: Length of the gravity run, in times sqrt(2 r / g) with the mean radius.
        work_budget: Most sphere-steps of the gravity run; a large bed stops there, and the report says so. A
            small one counts for as many spheres as make a step's own cost.
        still_speed: Mean speed, as a share of sqrt(g r), below which for one free-fall time a bed is still:
            the gravity run ends then, as nothing moves any more; 0: it goes on.
        silence_max: Silence after which the solver counts as hung [s].
    """

    force_limit: float | None = 1.0
    displacement_limit: float = 0.2
    sinking_limit: float = 0.015
    lost_limit: int = 0
    law_limit: float = 1.0e-6
    free_fall_times: float = 20.0
    work_budget: float = 2.0e9
    still_speed: float = 1.0e-3
    silence_max: float = 600.0


@dataclass(frozen=True, slots=True)
class StepZero:
    """Forces before anything moves; sphere numbers are indices in the bed, from 0.

    Attributes:
        pair_count: Contacts between spheres that the solver found.
        wall_count: Contacts with walls that the solver found; spheres at primitive walls, each direction
            once.
        pair_overlap_max: Largest overlap of two spheres, as a fraction of the smaller radius.
        wall_overlap_max: Largest overlap with a wall, as a fraction of the radius.
        pair_force_max: Largest force between two spheres, in mean sphere weights.
        wall_force_max: Largest force of a wall, in mean sphere weights.
        worst_pair: The spheres of the largest pair force; None without contacts.
        worst_wall_sphere: The sphere of the largest wall force; None without contacts.
        law_error: Largest difference from Hertz' law, relative to the force or to a thousandth of a sphere
            weight, whichever is more.
        predicted_force_max: Largest force that geometry alone predicts, in mean sphere weights.
        outside_count: Spheres whose centre is outside the container.
        worst_outside: One of them; None where there is none.
    """

    pair_count: int
    wall_count: int
    pair_overlap_max: float
    wall_overlap_max: float
    pair_force_max: float
    wall_force_max: float
    worst_pair: tuple[int, int] | None
    worst_wall_sphere: int | None
    law_error: float
    predicted_force_max: float
    outside_count: int
    worst_outside: int | None

    def __str__(self) -> str:
        """One line for messages."""
        outside = f", {self.outside_count} centres outside (sphere {self.worst_outside})"
        return f"largest force {self.force_max:.3g} W ({self.blame()}){outside if self.outside_count else ''}"

    def blame(self) -> str:
        """Return which spheres the largest force acts on."""
        pair_is_worse = self.worst_wall_sphere is None or self.pair_force_max >= self.wall_force_max
        if pair_is_worse and self.worst_pair is not None:
            return f"spheres {self.worst_pair[0]} and {self.worst_pair[1]}"
        return (
            "no contact"
            if self.worst_wall_sphere is None
            else f"sphere {self.worst_wall_sphere} and the wall"
        )

    @property
    def force_max(self) -> float:
        """Largest force of all, in mean sphere weights."""
        forces = self.pair_force_max, self.wall_force_max
        return math.nan if any(math.isnan(force) for force in forces) else max(forces)


@dataclass(frozen=True, slots=True)
class GravityRun:
    """What the bed did when it was let go.

    The rule of the elastic part: a bed is compressed by its own weight, however well it is packed. That part
    of the sinking is integrated from the overlaps at the end of the run (``packgen.validation.elastic``),
    less that of the overlaps at its start. The limits of displacement and sinking hold for what is left.

    They are judged where at least `JUDGED_SHARE` of the run was done, or the bed was still: less says nothing
    of where a bed ends.

    Attributes:
        timestep: The deck's own time step [s].
        timestep_rayleigh: The same, as a fraction of the smallest Rayleigh time.
        steps: Steps that were run.
        steps_wanted: Steps that the limits ask for; more than ``steps`` where the work budget ended the run,
            or the bed was still.
        free_fall_times: Length of the run, in times sqrt(2 r / g).
        lost: Indices of spheres that left the container or the solver's box.
        energy_peak: Largest kinetic energy of the samples, in N m g r (mean weight times mean radius a
            sphere).
        energy_end: Kinetic energy at the end, likewise.
        displacement_mean: Mean displacement, in mean radii.
        displacement_max: Largest displacement, in mean radii.
        worst_displaced: The sphere of that displacement.
        displacement_rest_mean: Mean of what is left of the displacements without the elastic sinking.
        sinking: Sinking of the centre of mass, as a fraction of its height above the bed's lowest point.
        sinking_elastic: The part of it that the compression of the contacts makes.
        height_change: Change of the bed's height (highest to lowest point of a sphere), as a fraction of it.
        still: Whether the run ended since nothing moved any more.
    """

    timestep: float
    timestep_rayleigh: float
    steps: int
    steps_wanted: int
    free_fall_times: float
    lost: tuple[int, ...]
    energy_peak: float
    energy_end: float
    displacement_mean: float
    displacement_max: float
    worst_displaced: int
    displacement_rest_mean: float
    sinking: float
    sinking_elastic: float
    height_change: float
    still: bool = False

    @property
    def sinking_rest(self) -> float:
        """Sinking of the centre of mass that is not elastic, as a fraction of its height."""
        return self.sinking - self.sinking_elastic

    @property
    def judged(self) -> bool:
        """Whether enough of the run was done to judge where the bed goes; no run at all is a fault."""
        enough = self.still or self.steps >= JUDGED_SHARE * self.steps_wanted
        return self.steps == 0 or enough


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the verdict: what, how much, at most how much (empty: any), and whether that holds."""

    quantity: str
    value: str
    limit: str
    passed: bool
    judged: bool = True

    @property
    def verdict(self) -> str:
        """``MISSED``, ``not judged``, or nothing."""
        if not self.judged:
            return "not judged"
        return "" if self.passed else "MISSED"


@dataclass(frozen=True, slots=True)
class SolverReport:
    """What one solver measured of one bed.

    Attributes:
        solver: Its name.
        version: What it calls itself, with its version.
        sphere_count: Number of spheres.
        body_count: Number of bodies, clumps and single spheres; None of a bed without clumps. With clumps,
            weights and radii are those of bodies, a clump's radius that of the sphere of its volume; lost and
            displaced are bodies, by their rows.
        step_zero: Forces before anything moves.
        gravity_run: What happened under gravity.
        limits: What was asked for.
    """

    solver: str
    version: str
    sphere_count: int
    step_zero: StepZero
    gravity_run: GravityRun
    limits: Limits
    body_count: int | None = None

    @property
    def passed(self) -> bool:
        """Whether every limit is kept."""
        return not self.missed

    @property
    def unjudged(self) -> str:
        """What the run was too short to judge, and what to do; empty where all was judged."""
        rows = [row.quantity for row in self.rows() if not row.judged]
        if not rows:
            return ""
        run = self.gravity_run
        share = 100 * run.steps / max(run.steps_wanted, 1)
        return (
            f"{self.solver}: not judged: {', '.join(rows)}: the gravity run came to {share:.2g} % of its "
            "steps within validation.work_budget; raise that, or validate a smaller bed of the same kind"
        )

    @property
    def missed(self) -> tuple[str, ...]:
        """One line for each limit that was missed, naming the sphere where one is to blame."""
        blame = {"largest step-0 force": f" ({self.step_zero.blame()})", self._lost: self._blame_lost()}
        blame["centres outside the container"] = f" (sphere {self.step_zero.worst_outside})"
        return tuple(
            f"{self.solver}: {row.quantity}: {row.value}, expected at most {row.limit}"
            f"{blame.get(row.quantity, '')}"
            for row in self.rows()
            if not row.passed
        )

    def rows(self) -> tuple[Row, ...]:
        """Return the verdict as the rows of a table."""
        zero, run, limits = self.step_zero, self.gravity_run, self.limits
        return (
            _row("centres outside the container", zero.outside_count, 0),
            _row("largest overlap of a pair", zero.pair_overlap_max, None, " r"),
            _row("largest overlap with a wall", zero.wall_overlap_max, None, " r"),
            _row("largest step-0 force", zero.force_max, limits.force_limit, " W"),
            _row("predicted by geometry", zero.predicted_force_max, None, " W"),
            _row("step-0 forces off Hertz' law", zero.law_error, limits.law_limit),
            _row("gravity run", f"{run.free_fall_times:.3g} free-fall times", None),
            _row("steps of the gravity run", self._work(), None),
            _row(self._lost, len(run.lost), limits.lost_limit),
            _row("kinetic energy, peak", run.energy_peak, None, " N m g r"),
            _row("kinetic energy, end", run.energy_end, None, " N m g r"),
            _row("mean displacement", run.displacement_mean, None, " r"),
            self._moved(
                "mean displacement, not elastic", run.displacement_rest_mean, "displacement_limit", " r"
            ),
            _row("largest displacement", run.displacement_max, None, " r"),
            _row("centre of mass sinks by", 100 * run.sinking, None, " % of its height"),
            _row("centre of mass sinks, elastic part", 100 * run.sinking_elastic, None, " %"),
            self._moved("centre of mass sinks, not elastic", 100 * run.sinking_rest, "sinking_limit", " %"),
            _row("height of the bed changes", 100 * run.height_change, None, " %"),
        )

    def as_dict(self) -> dict[str, Any]:
        """Return all of it as plain data for ``validation.json``; non-finite numbers become None."""
        content = {
            "passed": self.passed,
            "missed": list(self.missed),
            "version": self.version,
            "sphere_count": self.sphere_count,
            "body_count": self.body_count,
            "step_zero": {**asdict(self.step_zero), "force_max": self.step_zero.force_max},
            "gravity_run": {
                **asdict(self.gravity_run),
                "lost_count": len(self.gravity_run.lost),
                "sinking_rest": self.gravity_run.sinking_rest,
                "judged": self.gravity_run.judged,
            },
            "limits": asdict(self.limits),
        }
        return {key: _finite(value) for key, value in content.items()}

    def _moved(self, quantity: str, value: float, limit_name: str, unit: str) -> Row:
        """Return the row of how far the bed moved, which only a run that was long enough tells."""
        limit = getattr(self.limits, limit_name) * (100 if unit == " %" else 1)
        if self.gravity_run.steps == 0:
            return Row(quantity, "nothing was run", f"{limit:.3g}{unit}", passed=False)
        row = _row(quantity, value, limit, unit)
        return row if self.gravity_run.judged else replace(row, passed=True, judged=False)

    def _work(self) -> str:
        run = self.gravity_run
        if run.steps >= run.steps_wanted:
            return f"{run.steps}"
        share = 100 * run.steps / run.steps_wanted
        why = "nothing moves any more" if run.still else "work budget reached"
        return f"{run.steps} ({share:.0f} %), {why}"

    @property
    def _lost(self) -> str:
        return "spheres lost" if self.body_count is None else "bodies lost"

    def _blame_lost(self) -> str:
        named = ", ".join(str(index) for index in self.gravity_run.lost[:10])
        kind = "sphere" if self.body_count is None else "body"
        return f" ({kind} {named}{', ...' if len(self.gravity_run.lost) > 10 else ''})"


def comparison(reports: Sequence[SolverReport]) -> list[tuple[str, ...]]:
    """Return the verdicts of some solvers side by side, as the rows of one table with its head."""
    head = ("", *(report.version for report in reports), "at most")
    columns = [report.rows() for report in reports]
    cells = [
        (rows[0].quantity, *(f"{row.value}  {row.verdict}".rstrip() for row in rows), rows[0].limit)
        for rows in zip(*columns, strict=True)
    ]
    return [head, *cells] if reports else []


def validation_dict(reports: Mapping[str, SolverReport]) -> dict[str, Any]:
    """Return the content of ``validation.json``: the verdict, and each solver's report by name."""
    return {
        "passed": all(report.passed for report in reports.values()),
        "solvers": {name: report.as_dict() for name, report in reports.items()},
    }


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _row(quantity: str, value: float | str, limit: float | None, unit: str = "") -> Row:
    shown = value if isinstance(value, str) else f"{value:.3g}{unit}"
    # NaN (of a bed that exploded) fails every limit.
    passed = limit is None or isinstance(value, str) or value <= limit
    return Row(quantity, shown, "" if limit is None else f"{limit:.3g}{unit}", passed)
