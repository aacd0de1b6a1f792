"""The main figures of a bed, as plain data: what ``--json`` shows and what a sweep has in its table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["FIGURES", "main_figures", "summary"]

FIGURES = (
    "sphere_count", "body_count", "asked", "mass", "solid_fraction_filled", "solid_fraction_core",
    "close_packing_reached", "overlap_max", "wall_overlap_max", "contacts", "coordination", "rattlers",
    "crystal", "law_distance", "force_max", "stands_from_friction", "weight_not_carried",
    "arrange_seconds", "seconds", "peak_memory",
)  # fmt: skip
"""The keys of the main figures, in their order."""

GAP = 0.01
"""Gap up to which two spheres are in contact here, in smaller radii."""


def main_figures(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return the main figures of a bed.

    Args:
        report: Content of ``report.json``.

    Returns:
        A value for each of ``FIGURES``, None where the bed has none: numbers of spheres, of particles where
        there are clumps, and of particles asked for,
        mass [kg], solid fractions of the filled volume and of the core, share of random close packing that is
        reached, largest overlaps [smaller radii], contacts a sphere at gaps up to 1 % of the radius, on their
        plateau over the gap, share of rattlers, share of the spheres in a crystal, largest distance of a
        set's sizes from its law by number, largest force at step 0 [mean weights], least friction at which
        the bed stands, None where none is enough or nobody asked, share of the weight that contacts do not
        carry at the bed's own friction, time of the arrangement and of all [s], memory [bytes].
    """
    asked = [each["asked"] for each in report["zones"]]
    masses = [each["mass"] for each in report["sets"]]
    distances = [each["by_number"]["distance_max"] for each in report["sizes"]]
    contacts: Mapping[str, Any] = next((each for each in report["contacts"] if each["gap"] == GAP), {})
    return {
        "sphere_count": report["sphere_count"],
        "body_count": (report.get("bodies") or {}).get("body_count"),
        "asked": sum(asked) if asked and None not in asked else None,
        "mass": sum(masses) if None not in masses else None,
        "solid_fraction_filled": report["solid_fraction"]["filled"],
        "solid_fraction_core": report["solid_fraction"]["core"],
        "close_packing_reached": (report.get("close_packing") or {}).get("reached"),
        "overlap_max": report["overlap"]["overlap_max"],
        "wall_overlap_max": report["overlap"]["wall_overlap_max"],
        "contacts": contacts.get("mean"),
        "coordination": (report.get("coordination") or {}).get("plateau"),
        "rattlers": contacts.get("rattlers"),
        "crystal": (report.get("order") or {}).get("crystal"),
        "law_distance": max((each for each in distances if each is not None), default=None),
        "force_max": (report.get("step_zero") or {}).get("force_max"),
        "stands_from_friction": (report.get("stands_at_friction") or {}).get("friction_least"),
        "weight_not_carried": (report.get("stands_at_friction") or {}).get("not_carried"),
        "arrange_seconds": report["timings"].get("arrange"),
        "seconds": sum(report["timings"].values()),
        "peak_memory": report["peak_memory"],
    }


def summary(report: Mapping[str, Any], folder: str, exit_code: int) -> dict[str, Any]:
    """Return what a run reached.

    Args:
        report: Content of ``report.json``.
        folder: The result folder.
        exit_code: The exit code of the run.

    Returns:
        ``exit_code``, ``folder``, ``missed`` and ``warnings`` (a line each), the main figures, ``timings``
        [s], ``files``, ``scene``, ``seed`` and the version, ``packgen``.
    """
    settings = report["settings"]
    return {
        "exit_code": exit_code,
        "folder": folder,
        "missed": list(report["missed"]),
        "warnings": list(report["warnings"]),
        **main_figures(report),
        "timings": dict(report["timings"]),
        "files": list(report["files"]),
        "scene": settings.get("scene"),
        "seed": settings.get("seed"),
        "packgen": report["packgen"],
    }
