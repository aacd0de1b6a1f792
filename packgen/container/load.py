"""From the scene's words to shapes: which form a container or a location takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import Float64Array
from packgen.container.convex import Hull, convex_hull, is_convex
from packgen.container.meshfile import read_surface
from packgen.container.openings import refuse_open, why_no_vessel
from packgen.container.primitives import ball_surface, box_surface, cone_surface
from packgen.container.shells import Vessel, sorted_vessel
from packgen.container.stitching import stitched
from packgen.container.thick_walls import steel_remark
from packgen.errors import GeometryError
from packgen.geometry import (
    Ball,
    Box,
    Cone,
    Container,
    Mesh,
    Polyhedron,
    Shape,
    Slice,
    Surface,
    WallPart,
    floor_direction,
)
from packgen.geometry.cells import cell_container

if TYPE_CHECKING:
    from packgen.scene import Scene
    from packgen.scene.models import ContainerSpec, LocationSpec, PrimitiveSpec


def load_container(scene: Scene, warn: Callable[[str], None] = lambda _: None) -> Container:
    """Return the scene's container.

    Args:
        scene: The scene.
        warn: Called with a sentence for each fault of a mesh that was mended.

    Returns:
        The container: a primitive as it is, a convex mesh by its planes, any other by its triangles.

    Raises:
        GeometryError: The mesh cannot be read or bounds no volume.
    """
    down = np.asarray(scene.gravity_direction)
    if scene.walls:
        from packgen.container.parts import container_with_parts

        return container_with_parts(scene.container, scene.walls, down, scene.mark, warn)
    return container_of(scene.container, down, scene.mark, warn)


def container_of(
    spec: ContainerSpec,
    gravity_direction: Float64Array,
    mark: Callable[[str], str],
    warn: Callable[[str], None] = lambda _: None,
) -> Container:
    """Return the container that a specification names, as `load_container` does.

    Args:
        spec: The specification.
        gravity_direction: Where things fall, shape (3,).
        mark: Returns where ``container`` or a key in it stands, for messages.
        warn: Called with a sentence for each fault of a mesh that was mended.

    Raises:
        GeometryError: The mesh cannot be read or bounds no volume.
    """
    if spec.cell is not None:
        return cell_container(np.eye(3))  # as long as nothing is known of it
    if spec.primitive is not None:
        bounded = primitive_shape(spec.primitive)
    else:
        bounded = _mesh(spec, -gravity_direction, mark("container.path"), warn)
    return bounded_by(spec, bounded, mark("container"))


def bounded_by(
    spec: ContainerSpec,
    bounded: tuple[Shape, Surface, float],
    place: str,
    parts: tuple[WallPart, ...] = (),
) -> Container:
    """Return the container of a specification.

    Args:
        spec: The specification.
        bounded: Its shape, its walls as triangles, and the volume that they enclose [m3].
        place: Where the specification stands, for messages.
        parts: The parts of the walls that have names.

    Raises:
        GeometryError: It encloses no volume.
    """
    shape, surface, volume = bounded
    corners = surface.vertices
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    if isinstance(shape, Cone | Ball):
        from packgen.geometry.bounds import shape_bounds

        bounds = np.stack(shape_bounds(shape))
    if not volume > 0.0:
        raise GeometryError(f"{place}: the container encloses no volume")
    name = (
        spec.path.stem
        if spec.path is not None
        else type(spec.primitive).__name__.removesuffix("Spec").lower()
    )
    return Container(name, shape, surface, bounds, volume, spec.periodic, parts=parts)


def mesh_container(
    path: Path, units: str, place: str, warn: Callable[[str], None] = lambda _: None
) -> Container:
    """Return the container of a mesh file that no scene names; what is open is open towards z.

    Args:
        path: The file.
        units: Unit of its coordinates, a key of `packgen.units.LENGTHS`.
        place: Where the file is named, for messages.
        warn: Called with a sentence for each fault of the mesh that was mended.

    Raises:
        GeometryError: The mesh cannot be read or bounds no volume.
    """
    from packgen.scene.models import ContainerSpec

    try:
        spec = ContainerSpec.model_validate({"path": str(path), "units": units})
    except ValueError as error:
        raise GeometryError(f"{place}: found {path}, expected a mesh file that can be read") from error
    return container_of(spec, np.array([0.0, 0.0, -1.0]), lambda _: place, warn)


def closed_mesh(
    path: Path, units: str = "m", place: str = "mesh", warn: Callable[[str], None] = lambda _: None
) -> Container:
    """Return a closed mesh as a container, as `mesh_container` does; one that is open anywhere is refused.

    Args:
        path: The file.
        units: Unit of its coordinates, a key of `packgen.units.LENGTHS`.
        place: Where the file is named, for messages.
        warn: Called with a sentence for each fault of the mesh that was mended.

    Raises:
        GeometryError: The mesh cannot be read, is open, or bounds no volume.
    """
    from packgen.units import LENGTHS

    surface = stitched(read_surface(path, LENGTHS[units], place)[0])
    refuse_open(surface, lambda count: f"{place}: {path.name} is open at {count} edges,")
    return mesh_container(path, units, place, warn)


def load_location(
    spec: LocationSpec, scene: Scene, place: str, warn: Callable[[str], None] = lambda _: None
) -> Shape | Slice:
    """Return the shape of a zone's location.

    Args:
        spec: The location.
        scene: The scene it belongs to.
        place: The key's path, such as ``zones[0].location``.
        warn: Called with a sentence for each fault of a mesh that was mended.

    Returns:
        The shape; a slice across gravity bounds the spheres' centres only.

    Raises:
        GeometryError: The mesh cannot be read or bounds no volume.
    """
    if spec.slice is not None:
        axis = np.asarray(spec.slice.axis, float)
        gravity = np.asarray(scene.gravity_direction)
        down = floor_direction(gravity, scene.container.periodic)
        along = abs(float(axis @ (gravity if down is None else down)))
        return Slice(axis, spec.slice.min_bound, spec.slice.max_bound, centers_only=along > 0.999999)
    if spec.primitive is not None:
        return primitive_shape(spec.primitive)[0]
    up = -np.asarray(scene.gravity_direction)
    return _mesh(spec, up, scene.mark(f"{place}.path"), warn)[0]


def primitive_shape(spec: PrimitiveSpec) -> tuple[Shape, Surface, float]:
    """Return a primitive's shape, its walls as triangles, and its volume [m3]."""
    from packgen.scene.models import BoxSpec, CylinderSpec, SphereSpec

    if isinstance(spec, BoxSpec):
        box = Box(np.array(spec.min), np.array(spec.max))
        return box, box_surface(box), float(np.prod(box.max - box.min))
    if isinstance(spec, SphereSpec):
        ball = Ball(np.array(spec.center), spec.radius)
        return ball, ball_surface(ball), 4.0 / 3.0 * math.pi * spec.radius**3
    if isinstance(spec, CylinderSpec):
        bottom = top = spec.radius
    else:
        bottom, top = spec.radius_bottom, spec.radius_top
    cone = Cone(np.array(spec.base), np.array(spec.axis), spec.height, bottom, top)
    volume = math.pi * spec.height * (bottom**2 + bottom * top + top**2) / 3.0
    return cone, cone_surface(cone), volume


def _mesh(
    spec: ContainerSpec | LocationSpec, up: Float64Array, place: str, warn: Callable[[str], None]
) -> tuple[Shape, Surface, float]:
    assert spec.path is not None  # the scene has made sure of one form
    surface, mended = read_surface(spec.path, spec.scale, place)
    for sentence in mended:
        warn(f"{spec.path.name}: {sentence}")
    hull = convex_hull(surface.vertices, place)
    if spec.shape == "convex_hull":
        shape = hull.shape()
        return shape, shape.surface, hull.volume
    vessel = told_vessel(stitched(surface), up, f"{place}: {spec.path.name}", spec.path.name, warn)
    steel = steel_remark(vessel.closed, vessel.volume, hull.volume, up)
    if steel is not None:
        warn(f"{spec.path.name}: {steel}")
    return vessel_shape(vessel, hull)


def vessel_shape(vessel: Vessel, hull: Hull) -> tuple[Shape, Surface, float]:
    """Return a vessel's shape, by its planes where it is convex, its walls and its volume [m3]."""
    simple = vessel.shells == 1 and vessel.sheets == 0
    if simple and is_convex(vessel.closed, hull.volume, vessel.volume):
        shape = hull.shape()
        if isinstance(shape, Polyhedron):
            return Polyhedron(shape.normal, shape.offset, vessel.walls), vessel.walls, hull.volume
    return Mesh(vessel.closed), vessel.walls, vessel.volume


def told_vessel(
    surface: Surface, up: Float64Array, place: str, name: str, warn: Callable[[str], None]
) -> Vessel:
    """Return what the pieces of a mesh are; ``warn`` is told what may not be what was meant.

    Args:
        surface: The mesh.
        up: Unit vector against gravity, shape (3,).
        place: Where it is named, and its name, for errors.
        name: Its name, for warnings.
        warn: Called with a sentence for each thing.

    Raises:
        GeometryError: It bounds no volume.
    """
    try:
        vessel = sorted_vessel(surface, up)
    except GeometryError as error:
        raise GeometryError(f"{place}: {error}") from error
    if vessel is None:
        raise GeometryError(f"{place} {why_no_vessel(surface, up)}")
    if vessel.turned:
        warn(f"{name}: {vessel.turned} facets turned to agree with their neighbours")
    for sentence in vessel.notes:
        warn(f"{name}: {sentence}")
    return vessel
