"""How layers of bodies come, and the constants by which they come to rest."""

from __future__ import annotations

from dataclasses import replace

from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.projection.recipe import Recipe
from packgen.arrays import Float64Array
from packgen.bodies import Form

TOLERANCE = 1.0e-6
"""Largest overlap where none is asked for: bodies are parted in any case."""


def clump_recipe(friction: float, tolerance: float | None) -> Recipe:
    """Return the recipe of a bed about as dense as gravity would make it of bodies of some friction.

    Args:
        friction: Coefficient of sliding friction of body on body.
        tolerance: Largest overlap of the true spheres, as a fraction of the smaller radius; None: any.
    """
    usual = Recipe(tolerance=TOLERANCE if tolerance is None else tolerance)
    return replace(usual, friction=friction, stride=0.3, sink_first=0.03)


def clump_plan(slender: float) -> LayerPlan:
    """Return the layers of bodies that reach ``slender`` radii of the spheres of their volumes."""
    return LayerPlan(thickness=2.0 * slender, reopened=1.0, buffer=2.0 * slender, first=1.0)


def slenderness(forms: tuple[Form | None, ...], shares: Float64Array) -> float:
    """Return how far the most slender particles of a zone reach, in radii of the spheres of their volumes."""
    used = [
        form.template for form, share in zip(forms, shares, strict=True) if form is not None and share > 0.0
    ]
    return max((each.reach / each.equivalent_radius for each in used), default=1.0)
