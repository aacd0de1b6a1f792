"""What is told of a clump: lines for the screen, plain data for a file."""

from __future__ import annotations

from typing import Any

from packgen.bodies import MassProperties, Template
from packgen.clumps.fit import Fit

ROUNDING = 1.0e-8  # what is less counts as no error


def fit_rows(template: Template, fit: Fit, of: str) -> list[tuple[str, str, str, str]]:
    """Return the table of the errors: what, of the body, of the spheres, error.

    Args:
        template: The clump.
        fit: How well its spheres stand for the body.
        of: What the body is called.
    """
    unit = template.equivalent_diameter
    moments, found = (each.principal()[0] for each in (fit.body, fit.union))
    rows = [("", of, f"{template.count} spheres", "error")]
    rows += [("volume [m3]", f"{fit.body.volume:.6g}", f"{fit.union.volume:.6g}", _percent(fit.volume_error))]
    rows += [("missing or outside", "", "", f"{100.0 * fit.misplaced:.3g} % of the volume")]
    away = f"{100.0 * max(fit.centre_error - ROUNDING, 0.0):.2g} % of the equivalent diameter"
    rows += [("centre of mass", "", "", away)]
    for name, one, other in zip(("smallest", "middle", "largest"), moments, found, strict=True):
        rows += [(f"{name} moment [m5]", f"{one:.6g}", f"{other:.6g}", _percent(other / one - 1.0))]
    rows += [("moment about any axis", "", "", f"{100.0 * fit.inertia_error:.3g} % at most")]
    for name, value in (("mean", fit.surface_mean), ("largest", fit.surface_largest)):
        share = f"{100.0 * value / unit:.3g} % of the equivalent diameter"
        rows += [(f"surface from spheres, {name} [m]", "", f"{value:.4g}", share)]
    rows += [("sum of single spheres [m3]", "", f"{fit.overlap_factor * fit.union.volume:.6g}", _times(fit))]
    return rows


def _percent(share: float) -> str:
    return "0 %" if abs(share) < ROUNDING else f"{100.0 * share:+.3g} %"


def _times(fit: Fit) -> str:
    return f"{fit.overlap_factor:.3g} times their union"


def fit_content(template: Template, fit: Fit, source: dict[str, Any]) -> dict[str, Any]:
    """Return the report as plain data.

    Args:
        template: The clump.
        fit: How well its spheres stand for the body.
        source: What the body comes from, and what was asked for.
    """
    return {
        "name": template.name,
        "source": source,
        "sphere_count": template.count,
        "radius_smallest": float(template.spheres[:, 3].min()),
        "radius_largest": float(template.spheres[:, 3].max()),
        "equivalent_diameter": template.equivalent_diameter,
        "place": template.place.tolist(),
        "body": _properties(fit.body),
        "union": _properties(fit.union),
        "errors": {
            "volume": fit.volume_error,
            "misplaced": fit.misplaced,
            "centre": fit.centre_error,
            "inertia": fit.inertia_error,
            "surface_mean": fit.surface_mean / template.equivalent_diameter,
            "surface_largest": fit.surface_largest / template.equivalent_diameter,
        },
        "overlap_factor": fit.overlap_factor,
    }


def _properties(body: MassProperties) -> dict[str, Any]:
    moments, axes = body.principal()
    return {
        "volume": body.volume,
        "centre": body.centre.tolist(),
        "inertia": body.inertia.tolist(),
        "principal_moments": moments.tolist(),
        "principal_axes": axes.T.tolist(),
    }
