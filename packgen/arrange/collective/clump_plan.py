"""How thick the layers of bodies are."""

from __future__ import annotations

from packgen.arrange.collective.plan import LayerPlan
from packgen.arrays import Float64Array
from packgen.bodies import Form


def clump_plan(slender: float) -> LayerPlan:
    """Return the layers of bodies that reach ``slender`` radii of the spheres of their volumes."""
    return LayerPlan(thickness=2.0 * slender, reopened=1.0, buffer=2.0 * slender, first=1.0)


def slenderness(forms: tuple[Form | None, ...], shares: Float64Array) -> float:
    """Return how far the most slender particles of a zone reach, in radii of the spheres of their volumes."""
    used = [
        form.template for form, share in zip(forms, shares, strict=True) if form is not None and share > 0.0
    ]
    return max((each.reach / each.equivalent_radius for each in used), default=1.0)
