"""The part of a bed inside or outside a closed mesh: a core sample, a tunnel, a borehole.

Distances to the mesh are exact, to its triangles; it need not be convex. A sphere's body is inside where its
centre is, and no triangle is nearer than the radius. Spheres that only the rounding of a packed bed puts into
the mesh, by no more than the bed's tolerance, count as beside it. With the touching ones, what is inside is
all that is not wholly outside: each sphere is in exactly one of the two parts, whichever way it is cut.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed
from packgen.bodies import touched_bodies, whole_bodies
from packgen.check import wall_clearance
from packgen.check.mesh import MeshWalls
from packgen.container.inner_wall import with_inner_wall
from packgen.errors import GeometryError
from packgen.geometry import Container, Mesh, Surface
from packgen.reshape.bodies import bodies_beside, periods

TOLERANCE = 1.0e-6  # of a bed that has none
IMAGES_MAX = 10_000  # of a box that wraps around


@dataclass(frozen=True, eq=False, slots=True)
class Cut:
    """What is kept of a bed.

    Attributes:
        mesh: The closed mesh.
        inside: Whether the part inside the mesh is kept; else the part outside.
        touching: Whether bodies that are partly there are kept too.
    """

    mesh: Container
    inside: bool
    touching: bool = False

    @property
    def side(self) -> str:
        """What is kept, as a word."""
        return "inside" if self.inside else "outside"


@dataclass(frozen=True, eq=False, slots=True)
class Carved:
    """A part of a bed.

    Attributes:
        bed: The spheres that are kept, in the order that they had.
        source_index: The index that each of them had, shape (N,), int64.
        walls: A sentence that says what the walls are now.
        notes: A sentence for each thing that may not be what was meant.
    """

    bed: Bed
    source_index: Int64Array
    walls: str
    notes: tuple[str, ...] = ()


def carve_bed(bed: Bed, cut: Cut) -> Carved:
    """Return the part of a bed inside or outside a closed mesh.

    Inside a mesh the mesh is the new container. Outside of it the bed's container gets the mesh as an inner
    wall. Where bodies cross the mesh, or the container wraps around or is not known, it stays as it is. Of a
    bed that wraps around, the images of the spheres are looked at too; what is inside is moved there.

    Args:
        bed: The bed.
        cut: What is kept.

    Raises:
        GeometryError: The bed is in a periodic cell that is no box, nothing is kept, or the mesh
            holds two images of one sphere.
    """
    if bed.container.cell is not None:
        raise GeometryError(
            f"--{cut.side}: found a bed in a periodic cell whose edges are not along x, y and z, expected "
            "a box or walls: not supported yet; export csv, which knows no cell, and carve that"
        )
    position, kept = _chosen(bed, cut)
    name = cut.mesh.name
    if not kept.any():
        raise GeometryError(
            f"--{cut.side}: no sphere {_where(cut)} {name}, which goes from {_point(cut.mesh.bounds[0])} to "
            f"{_point(cut.mesh.bounds[1])} m, the bed from {_point(bed.position.min(axis=0))} to "
            f"{_point(bed.position.max(axis=0))} m; is --mesh-units right?"
        )
    notes = () if not kept.all() else (f"--{cut.side}: all spheres are kept: each one {_where(cut)} {name}",)
    part = _selected(bed, position, kept)
    container, walls = _container(part, cut)
    provenance = _provenance(bed, cut, changed=container is not bed.container)
    part = replace(part, container=container, provenance=provenance)
    return Carved(part, np.flatnonzero(kept).astype(np.int64), walls, notes)


def _where(cut: Cut) -> str:
    return f"lies {'partly' if cut.touching else 'wholly'} {cut.side}"


def _point(place: Float64Array) -> str:
    return "(" + ", ".join(f"{each:.4g}" for each in place) + ")"


def _chosen(bed: Bed, cut: Cut) -> tuple[Float64Array, BoolArray]:
    """Return where the spheres are afterwards [m], (N, 3), and which of them are kept, (N,)."""
    wholly, partly = np.zeros(bed.count, bool), np.zeros(bed.count, bool)
    lengths = np.array([length or 0.0 for length in bed.container.period])
    beside = bed.position + periods(bed) * lengths
    position = bed.position if cut.touching or not cut.inside else beside.copy()
    for shift in _shifts(bed, beside, lengths, cut.mesh):
        image = beside + shift * lengths
        within, touched = _sides(bed, image, cut.mesh)
        if cut.inside and (wholly & within).any():
            twice = int(np.flatnonzero(wholly & within)[0])
            raise GeometryError(
                f"--inside: {cut.mesh.name} holds sphere {twice} and its image, expected one narrower than "
                "the box, which wraps around; repeat the bed first, by packgen repeat"
            )
        if cut.inside and not cut.touching:
            position[within] = image[within]
        wholly |= within
        partly |= touched
    partly = touched_bodies(partly, bed.body_index)
    if cut.inside:
        return position, partly if cut.touching else wholly
    return position, ~wholly if cut.touching else ~partly


def _shifts(
    bed: Bed, position: Float64Array, lengths: Float64Array, mesh: Container
) -> Iterator[Float64Array]:
    """Yield the periods, along x, y, z, by which some sphere may be moved and reach the mesh, shape (3,)."""
    reach = float(bed.radius.max())
    ranges = []
    for axis in range(3):
        if lengths[axis] == 0.0:
            ranges.append(range(1))
            continue
        low = (mesh.bounds[0, axis] - reach - position[:, axis].max()) / lengths[axis]
        high = (mesh.bounds[1, axis] + reach - position[:, axis].min()) / lengths[axis]
        ranges.append(range(int(np.ceil(low)), int(np.floor(high)) + 1))
    if np.prod([float(len(each)) for each in ranges]) > IMAGES_MAX:
        raise GeometryError(
            f"{mesh.name}: found a mesh over more than {IMAGES_MAX:,} boxes of the bed, which wraps around, "
            "expected one about as wide as the box; is --mesh-units right?"
        )
    for shift in product(*ranges):
        yield np.array(shift, np.float64)


def _sides(bed: Bed, position: Float64Array, mesh: Container) -> tuple[BoolArray, BoolArray]:
    """Return which spheres' bodies are wholly inside a mesh, and which spheres are partly, (N,) each."""
    walls = MeshWalls(_closed(mesh))
    reach = bed.radius[:, None]
    near = np.flatnonzero(
        ((position + reach > mesh.bounds[0]) & (position - reach < mesh.bounds[1])).all(axis=1)
    )
    room = bed.radius[near] * (1.0 - (TOLERANCE if bed.tolerance is None else bed.tolerance))
    distance = walls.distance(position[near], bed.radius[near])
    inside = walls.contains(position[near], distance)
    wholly, partly = np.zeros(bed.count, bool), np.zeros(bed.count, bool)
    wholly[near] = inside & (distance >= room)
    partly[near] = inside | (distance < room)
    return whole_bodies(wholly, bed.body_index), partly


def _closed(mesh: Container) -> Surface:
    return mesh.shape.surface if isinstance(mesh.shape, Mesh) else mesh.surface


def _selected(bed: Bed, position: Float64Array, kept: BoolArray) -> Bed:
    """Return the chosen spheres, in the order that they have; of bodies that are known, whole ones only."""
    index, bodies = None if bed.body_index is None else bed.body_index[kept], bodies_beside(bed, position)
    if index is not None and bodies is not None:
        row, numbers = np.unique(index, return_inverse=True)
        index = numbers.astype(np.int32)
        bodies = bodies[row.astype(np.int64)]
    return replace(
        bed,
        position=position[kept],
        radius=bed.radius[kept],
        set_index=bed.set_index[kept],
        zone_index=bed.zone_index[kept],
        batch_index=bed.batch_index[kept],
        body_index=index,
        bodies=bodies,
    )


def _container(part: Bed, cut: Cut) -> tuple[Container, str]:
    """Return the container of a part of a bed, and a sentence about it."""
    name, old = cut.mesh.name, part.container
    if cut.touching:
        return old, f"walls: those of the bed, for spheres cross {name}"
    if cut.inside:
        return _tight(part, cut.mesh), f"walls: {name}"
    if not old.walls_known:
        return old, f"walls: not known; {name} is not made one"
    if any(old.periodic):
        return old, f"walls: those of the bed alone, whose box wraps around; {name} is not made one"
    return with_inner_wall(old, cut.mesh)


def _tight(part: Bed, mesh: Container) -> Container:
    """Return a mesh as a container: by its planes, unless these keep less than its triangles do."""
    clearance = wall_clearance(mesh, part.position, part.radius)
    slack = TOLERANCE if part.tolerance is None else part.tolerance
    if (clearance >= part.radius * (1.0 - slack)).all():
        return mesh
    return replace(mesh, shape=Mesh(_closed(mesh)))


def _provenance(bed: Bed, cut: Cut, *, changed: bool) -> dict[str, Any]:
    """Return where a part comes from; the container that it had is not its own any more."""
    told: dict[str, Any] = dict(bed.provenance)
    told["carved"] = {
        "mesh": cut.mesh.name, "side": cut.side, "touching": cut.touching, "spheres_before": bed.count
    }  # fmt: skip
    settings = told.get("settings")
    if changed and isinstance(settings, Mapping) and "container" in settings:
        kept = {name: value for name, value in settings.items() if name != "walls"}
        told["settings"] = {**kept, "container": {"path": "walls.stl", "units": "m"}}
    if changed:
        told.pop("walls", None)
    return told
