"""What is known of a bed that was found by a search: how often, how good, and how good it could be."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Search:
    """How a bed was found.

    Attributes:
        maximized: What is largest: ``fraction``, the solid fraction of a cell; ``volume``, the volume of the
            spheres chosen among the candidates; ``scale``, the common factor of all radii.
        value: What was reached: a solid fraction, a volume [m3], a factor.
        fraction: Solid fraction of the cell or the container.
        bound: What it cannot exceed; None: nothing is known.
        bound_by: Where the bound is from.
        gap: Share of the value that the bound is above it; None: no bound is known.
        proven: Whether nothing better exists, but for rounding.
        starts: Starts, or moves, of the search.
        hits: Those that led to this value.
        programmes: Linear programmes that were solved.
        chosen: Number of spheres in the bed.
        candidates: Number of those it was chosen from.
        ended: Why the search ended: ``done``, ``time_limit``, ``stopped``.
        cell: Lengths of a cell's edges [m] and the angles between them [degrees], a b c alpha beta gamma;
            None: there is none.
    """

    maximized: str
    value: float
    fraction: float
    bound: float | None
    bound_by: str
    gap: float | None
    proven: bool
    starts: int
    hits: int
    programmes: int
    chosen: int
    candidates: int
    ended: str
    cell: tuple[float, float, float, float, float, float] | None = None

    def line(self) -> str:
        """Return what was reached, in a line."""
        what = {"fraction": "solid fraction", "volume": "volume", "scale": "all radii times"}[self.maximized]
        unit = " m3" if self.maximized == "volume" else ""
        found = f"{what} {self.value:.10g}{unit}, by {self.hits:,} of {self.starts:,} starts"
        if self.ended != "done":
            found += f", {'stopped' if self.ended == 'stopped' else 'until the time limit'}"
        return found

    def bound_line(self) -> str:
        """Return what could be reached at most, in a line."""
        if self.bound is None:
            return "no bound is known"
        verdict = "proven: nothing is better" if self.proven else f"{self.gap:.2%} above"
        return f"{self.bound:.10g} ({self.bound_by}), {verdict}"

    def cell_line(self) -> str:
        """Return a cell's edges and angles, in a line; empty: there is none."""
        if self.cell is None:
            return ""
        a, b, c, alpha, beta, gamma = self.cell
        return f"{a:.6g} x {b:.6g} x {c:.6g} m, {alpha:.4g}, {beta:.4g}, {gamma:.4g} degrees"
