"""A clump of any shape: its template, and how well it stands for the shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packgen.bodies import Template
from packgen.clumps.body import Body, body_of
from packgen.clumps.fit import Fit, fit_of, fit_of_union
from packgen.clumps.make import Wanted, clump_spheres
from packgen.clumps.shapes import Dumbbell, ParametricShape, Ring, Rod, Tetrapod
from packgen.clumps.stone import read_stone
from packgen.clumps.template import template_of_spheres
from packgen.errors import PackgenError
from packgen.geometry import Surface

COUNTS = {"dumbbell": 2, "rod": 5, "tetrapod": 9, "ring": 12}
"""Spheres of the shapes that are made of spheres, where nobody says how many."""


@dataclass(frozen=True, eq=False, slots=True)
class Clump:
    """A clump that was made.

    Attributes:
        template: Its spheres, with the mass properties of the body.
        fit: How well the spheres stand for the body.
        surface: The body's mesh as given [m]; null where the body is the union of the spheres.
        missed: One sentence for each limit that was asked for and not reached.
    """

    template: Template
    fit: Fit
    surface: Surface | None
    missed: tuple[str, ...] = ()


def make_clump(
    source: Path | Surface | ParametricShape,
    wanted: Wanted | None = None,
    *,
    name: str | None = None,
    units: str = "m",
    warn: Callable[[str], None] = lambda _: None,
) -> Clump:
    """Make a clump.

    Args:
        source: A closed mesh, by its file or as a surface, or a parametric shape.
        wanted: Number of spheres, or errors to be reached, and what spheres are allowed; null: what is usual
            for a shape made of spheres.
        name: What the template is called; null: as the file or the shape.
        units: Unit of the coordinates in the file.
        warn: Called with a sentence for each fault of the mesh that was mended.

    Returns:
        The clump.

    Raises:
        PackgenError: The mesh has holes or bounds nothing, no sphere fits, or the shape cannot have so many.
        ValueError: ``wanted`` says nothing, or limits that exclude each other.
    """
    kind = type(source).__name__.lower()
    if isinstance(source, Dumbbell | Rod | Tetrapod | Ring):
        return _of_spheres(source, wanted, name or kind)
    if wanted is None:
        raise ValueError(
            "found no limit, expected Wanted(spheres=...), or with a volume_error or surface_error"
        )
    if isinstance(source, Path):
        body, name = read_stone(source, units, warn), name or source.stem
    elif isinstance(source, Surface):
        body, name = body_of(source, name or "mesh"), name or "mesh"
    else:
        body, name = body_of(source.surface(), f"clump: {kind}"), name or kind
    spheres = clump_spheres(body, wanted, f"clump: {name}")
    fit = fit_of(body, spheres, inscribed=not wanted.best_fit)
    template = Template(
        name, spheres, body.properties.volume, body.properties.inertia, body.properties.centre
    )
    return Clump(template, fit, body.surface, _missed(template, fit, wanted))


def _of_spheres(source: Dumbbell | Rod | Tetrapod | Ring, wanted: Wanted | None, name: str) -> Clump:
    kind = type(source).__name__.lower()
    if wanted is not None and wanted != Wanted(spheres=wanted.spheres or 1):
        raise PackgenError(
            f"clump: {kind}: found limits of errors or sizes, expected the number of spheres alone"
        )
    spheres = source.spheres(COUNTS[kind] if wanted is None else wanted.most)
    if not isinstance(source, Rod):
        template = template_of_spheres(name, spheres)
        return Clump(template, fit_of_union(template), None)
    body: Body = body_of(source.surface(), f"clump: {name}")
    template = Template(name, spheres, body.properties.volume, body.properties.inertia, np.zeros(3))
    return Clump(template, fit_of(body, spheres, inscribed=False), body.surface)


def _missed(template: Template, fit: Fit, wanted: Wanted) -> tuple[str, ...]:
    unit = template.equivalent_diameter
    said = []
    for what, limit, found in (
        ("volume error", wanted.volume_error, fit.misplaced),
        ("surface error", wanted.surface_error, fit.surface_largest / unit),
    ):
        if limit is not None and found > limit:
            smaller = "" if wanted.least_radius == 0.0 else ", or a lower least radius"
            said.append(
                f"{what}: found {found:.3g} with {template.count} spheres, asked for at most {limit:g}; "
                f"allow more spheres{smaller}"
            )
    return tuple(said)
