"""What is known of a jammed bed: what moved so that it jams, and what proves that it does."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Jamming:
    """How a bed was jammed, and the proof.

    Attributes:
        adjusted: What gave way: ``container`` or ``count``.
        factor: Factor on all lengths of the container; 1 where it stayed.
        extent_asked: Extent of the container asked for along x, y and z [m].
        extent: Extent of the bed's container along x, y and z [m].
        slack: Share by which all volumes of spheres could still grow until the bed is jammed; 0 where the
            container moved.
        certificate: What the figures below are from: ``programme``, the forces of a linear programme; or
            ``quench``, the soft spheres that came to rest, where the bed has many.
        proven: Whether forces that all press balance on each sphere that is held, at contacts that touch: no
            small move then lets the spheres grow.
        contacts: Contacts between spheres that are held, and between them and walls.
        isostatic_excess: Contacts beyond the least number that can hold them: 3 n + 1, less one for each
            way in which all n spheres can move as a whole.
        rattlers: Share of the spheres that nothing holds.
        force_residual: Largest sum of all forces upon a sphere, over the mean force at a contact.
        overlap_max: Largest overlap, as a fraction of the smaller radius.
        gap_max: Largest gap of those contacts, as a fraction of the smaller radius.
        pressure: Mean over the spheres of the relative overlaps of their contacts, when they last were soft.
        programmes: Linear programmes that were solved.
        crystal: Share of the spheres in a crystal; None until it is measured.
    """

    adjusted: str
    factor: float
    extent_asked: tuple[float, float, float]
    extent: tuple[float, float, float]
    slack: float
    certificate: str
    proven: bool
    contacts: int
    isostatic_excess: int
    rattlers: float
    force_residual: float
    overlap_max: float
    gap_max: float
    pressure: float
    programmes: int
    crystal: float | None = None

    def line(self) -> str:
        """Return what is proven, in a line."""
        beside = f", {self.isostatic_excess:+,} beside isostatic" if self.isostatic_excess else ", isostatic"
        held = f"{self.contacts:,} contacts{beside}, {self.rattlers:.1%} rattlers"
        if self.certificate == "quench":
            return f"by soft spheres at rest; {held}, residual {self.force_residual:.1e}"
        verdict = "proven by its forces" if self.proven else "not proven"
        return f"{verdict}; {held}, residual {self.force_residual:.1e}"

    def container_line(self) -> str:
        """Return what gave way, in a line."""
        asked, reached = (
            " x ".join(f"{each:.6g}" for each in size) for size in (self.extent_asked, self.extent)
        )
        if self.adjusted == "container":
            return f"{reached} m, {self.factor:.6g} times the {asked} m asked for"
        return f"{reached} m as asked for; all spheres could grow by {self.slack:.2%} of their volume"
