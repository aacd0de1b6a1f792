"""How well spheres stand for a body: errors of volume, centre, inertia and surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, read_only
from packgen.bodies import MassProperties, Template
from packgen.clumps.body import Body
from packgen.clumps.cover_kernels import gaps
from packgen.clumps.points import surface_points
from packgen.clumps.properties import sum_of_spheres, union_properties

POINTS, MARGIN = 60_000, 0.2
SURFACE_POINTS = 20_000
SHIFT = 0.37  # other points than those that the spheres were chosen by


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Spheres beside the body that they stand for.

    Attributes:
        body: Properties of the body itself, its centre of mass at the origin.
        union: Those of the union of the spheres, exact, each place counted once.
        volume_error: Volume of the union less the body's, as a share of it.
        misplaced: Volume that the spheres miss and that they put outside, together, as a share of the body's.
        centre_error: Distance of the centres of mass, in equivalent diameters.
        inertia_error: Largest error of a moment of inertia about any axis, as a share of the body's.
        surface_mean: Mean distance of the body's surface from the union [m].
        surface_largest: Largest distance of the body's surface from the union [m].
        overlap_factor: Volume of the spheres one by one, as a multiple of the union's.
    """

    body: MassProperties
    union: MassProperties
    volume_error: float
    misplaced: float
    centre_error: float
    inertia_error: float
    surface_mean: float
    surface_largest: float
    overlap_factor: float


def fit_of(body: Body, spheres: Float64Array, *, inscribed: bool) -> Fit:
    """Return how well spheres stand for a body.

    Args:
        body: The body.
        spheres: Centres and radii along the mesh's axes, the centre of mass at the origin [m], shape (N, 4).
        inscribed: Whether they are all in the body: then what is misplaced is what is missing.
    """
    true = MassProperties(body.properties.volume, np.zeros(3), body.properties.inertia)
    union = union_properties(spheres)
    own = np.ascontiguousarray(body.from_mesh_axes(spheres))
    volume_error = union.volume / true.volume - 1.0
    point = surface_points(body.corners, SURFACE_POINTS, SHIFT)[0]
    mean = np.abs(gaps(point, own))
    vertices = np.ascontiguousarray(body.corners.reshape(-1, 3))
    largest = max(float(mean.max()), float(np.abs(gaps(vertices, own)).max()))
    return Fit(
        true,
        union,
        volume_error,
        abs(volume_error) if inscribed else _misplaced(body, own),
        float(np.linalg.norm(union.centre)) / body.unit,
        inertia_error(union.inertia, true.inertia),
        float(mean.mean()) * body.unit,
        largest * body.unit,
        sum_of_spheres(spheres) / union.volume,
    )


def inertia_error(found: Float64Array, true: Float64Array) -> float:
    """Return the largest relative difference of two inertia tensors' (3, 3) moments about any one axis."""
    moments, axes = np.linalg.eigh(read_only(true, np.float64, (3, 3), "inertia"))
    scaled = axes / np.sqrt(moments)
    return float(np.abs(np.linalg.eigvalsh(scaled.T @ (found - true) @ scaled)).max())


def _misplaced(body: Body, own: Float64Array) -> float:
    points = body.points(POINTS, MARGIN, SHIFT)
    missing = int((gaps(points.inside, own) > 0.0).sum())
    beyond = int((gaps(points.outside, own) <= 0.0).sum())
    return (missing + beyond) / max(len(points.inside), 1)


def fit_of_union(template: Template) -> Fit:
    """Return the fit of a body that is the union of its spheres itself: without an error."""
    union = union_properties(template.spheres)
    factor = sum_of_spheres(template.spheres) / union.volume
    return Fit(template.properties, union, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, factor)
