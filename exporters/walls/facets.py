"""The walls of a deck: facets that a solver accepts, STL files, and primitive walls where they are exact.

What LIGGGHTS 3.8 does with facets, and what follows (found by running it):

- Two facets whose normals differ by less than the wall's ``curvature`` count as one smooth surface: the edge
  between them makes no contacts. With too small a value a sphere inside a finely triangulated, hollow surface
  is pushed by several facets at once. With a value above the angle of an edge that protrudes into the bed,
  that edge has no contact at all and spheres fall through it. `smooth_angle` therefore takes the hollow edges
  in and leaves the protruding ones.
- LIGGGHTS makes no contact at a corner where two edges, even of one facet, lie within ``curvature`` of each
  other. A sphere at the corner of a baffle of two long facets, or on the tip of a slender cone, sinks in, and
  is thrown off as soon as it meets an edge from beyond its end. Facets with such a corner that protrudes are
  made wider, too, and `smooth_angle` stays below the angles that are left there.
- It stops at two equal facets, and at a facet with an angle below 0.0573 degrees. Facets of a flat, convex
  part of the wall are made wider (``slivers``); what is too narrow after that, and doubles, are
  dropped.
- An ASCII STL is read in double precision, a binary one in single precision, in which a wall 32 m up is
  placed to 2e-6 m only. ASCII is the default, so that the walls of the deck are the walls of the bed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exporters.protocol import Outlook
from exporters.walls import slivers
from exporters.walls.angles import (
    corner_angles,
    exposed_corners,
    smallest_angles,
    smooth_angle,
)
from exporters.walls.edges import edge_uses
from packgen.arrays import unique_rows
from packgen.bed import AnyBed
from packgen.errors import ExportError
from packgen.geometry import Box, Cone, Container, Mesh, Surface

DEGENERATE_ANGLE = 1.0e-4  # degrees; narrower than that, single precision does not tell a facet from a line
FACET_ANGLE_MIN = 0.06  # degrees; LIGGGHTS' hard limit is 0.001 rad = 0.0573 degrees
NEIGHBORS_MAX = 5  # facets that share an edge with one facet; more stop LIGGGHTS
CORNER_MARGIN = 1.05  # angle at a protruding corner over the largest smooth angle

Float64Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class Facets:
    """The walls as facets that a solver accepts.

    Attributes:
        triangles: Corners of each facet [m], shape (F, 3, 3), float64.
        dropped: How many facets were left out because they were degenerate, too narrow or duplicates.
        open_edges: Number of edges that belong to one facet only; 0 for a closed surface.
        smooth_angle: What to give as ``curvature`` [degrees].
    """

    triangles: Float64Array
    dropped: int
    open_edges: int
    smooth_angle: float


@dataclass(frozen=True, slots=True)
class PrimitiveWall:
    """A wall that LIGGGHTS knows by its form.

    Attributes:
        name: Part of the fix's id.
        form: Its keyword and numbers, for example ``zplane 0.0`` or ``zcylinder 0.5 0.0 0.0``.
    """

    name: str
    form: str


def wall_facets(container: Container, *, angle_min: float = FACET_ANGLE_MIN) -> Facets:
    """Return the facets of a container's walls, those on periodic sides left out.

    Args:
        container: The container.
        angle_min: Facets with a smaller angle are too narrow for the solver [degrees].

    Raises:
        ExportError: A facet has more neighbours than LIGGGHTS takes.
    """
    surface = container.surface
    place, index = unique_rows(surface.vertices)
    vertices, faces = surface.vertices[place], index[surface.faces]
    # Counted before facets are left out: the hairline that a narrow facet leaves does not open the surface.
    open_edges = int((edge_uses(faces) == 1).sum())
    faces = faces[~on_periodic_side(container)]
    angle = smallest_angles(vertices, faces)
    vertices, faces, _ = slivers.widened(vertices, faces, (angle > DEGENERATE_ANGLE) & (angle <= angle_min))
    good = clean_facets(vertices, faces, angle_min=angle_min)
    kept, dropped = faces[good], len(faces) - int(good.sum())
    sheets = _on_sheets(container, vertices, kept)
    surface = Surface(vertices, kept)
    smooth = smooth_angle(surface, sheets)
    narrow = exposed_corners(surface, sheets) & (corner_angles(surface) <= CORNER_MARGIN * smooth)
    if narrow.any():
        vertices, kept, source = slivers.widened(
            vertices, kept, np.asarray(narrow.any(axis=1)), slivers.ASPECT_OF_CORNERS
        )
        surface, sheets = Surface(vertices, kept), sheets[source]
        narrowest = corner_angles(surface)[exposed_corners(surface, sheets)].min()
        smooth = min(smooth, float(narrowest) / CORNER_MARGIN)
    _check_neighbors(kept)
    return Facets(vertices[kept], dropped, open_edges, smooth)


def clean_facets(
    vertices: Float64Array, faces: NDArray[np.int64], *, angle_min: float = FACET_ANGLE_MIN
) -> BoolArray:
    """Return which facets LIGGGHTS accepts: neither degenerate, nor too narrow, nor a duplicate.

    Args:
        vertices: Corner positions [m], shape (V, 3), each position once.
        faces: Corner indices, shape (F, 3).
        angle_min: Facets with a smaller angle are too narrow [degrees].

    Returns:
        True for the facets to keep, shape (F,).
    """
    first = np.zeros(len(faces), dtype=bool)
    first[unique_rows(np.sort(faces, axis=1))[0]] = True
    accepted: BoolArray = first & (smallest_angles(vertices, faces) > max(angle_min, DEGENERATE_ANGLE))
    return accepted


def _on_sheets(container: Container, vertices: Float64Array, faces: NDArray[np.int64]) -> BoolArray:
    """Tell which facets belong to a sheet: a wall that the container's shape has with either side, (F,)."""
    if not isinstance(container.shape, Mesh):
        return np.zeros(len(faces), dtype=bool)
    whole = container.shape.surface
    _, group = unique_rows(np.sort(whole.faces, axis=1))
    twice = np.bincount(group)[group] == 2
    if not twice.any():
        return np.zeros(len(faces), dtype=bool)
    corners = whole.vertices[np.unique(whole.faces[twice])]
    places = {tuple(each) for each in corners.tolist()}
    on_sheet = np.array([tuple(each) in places for each in vertices.tolist()], dtype=bool)
    return np.asarray(on_sheet[faces].all(axis=1))


def on_periodic_side(container: Container) -> BoolArray:
    """Return which facets (F,) of a container lie on a side where it wraps around: no wall is there."""
    corners = container.surface.vertices[container.surface.faces]
    size = container.bounds[1] - container.bounds[0]
    on_side = np.zeros(len(corners), dtype=bool)
    for axis in np.flatnonzero(container.periodic):
        for bound in container.bounds[:, axis]:
            on_side |= (np.abs(corners[:, :, axis] - bound) <= 1e-9 * size[axis]).all(axis=1)
    return on_side


def primitive_walls(container: Container) -> tuple[PrimitiveWall, ...] | None:
    """Return the walls of an axis-parallel box or cylinder as LIGGGHTS' primitives; None for any other shape.

    The force of a sphere on them is that on a flat wall (effective radius r), as on facets.
    """
    shape = container.shape
    if isinstance(shape, Box):
        return tuple(
            PrimitiveWall(f"{axis}_{end}", f"{axis}plane {float(corner[index])!r}")
            for index, axis in enumerate("xyz")
            if not container.periodic[index]
            for end, corner in (("low", shape.min), ("high", shape.max))
        )
    if (
        isinstance(shape, Cone)
        and shape.radius_bottom == shape.radius_top
        and np.abs(shape.axis).max() == 1.0
    ):
        along = int(np.abs(shape.axis).argmax())
        across = [float(shape.base[index]) for index in range(3) if index != along]
        ends = sorted((float(shape.base[along]), float(shape.base[along] + shape.axis[along] * shape.height)))
        axis = "xyz"[along]
        return (
            PrimitiveWall("side", f"{axis}cylinder {float(shape.radius_top)!r} {across[0]!r} {across[1]!r}"),
            PrimitiveWall(f"{axis}_low", f"{axis}plane {ends[0]!r}"),
            PrimitiveWall(f"{axis}_high", f"{axis}plane {ends[1]!r}"),
        )
    return None


def has_wall(bed: AnyBed | Outlook) -> bool:
    """Return whether the container of a bed has a wall: a box that is periodic all round has none."""
    return not all(bed.container.periodic)


def _check_neighbors(faces: NDArray[np.int64]) -> None:
    neighbors = (edge_uses(faces) - 1).sum(axis=1)
    crowded = int((neighbors > NEIGHBORS_MAX).sum())
    if crowded:
        raise ExportError(
            f"walls: {crowded} facets share their edges with more than {NEIGHBORS_MAX} others, which"
            " LIGGGHTS refuses; remove the inner or doubled surfaces of the container's mesh"
        )
