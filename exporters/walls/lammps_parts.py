"""Named parts of walls in LAMMPS: which of them its regions can be, and what is left when one is removed.

Found by running LAMMPS of 29 Sep 2021: a region ``block`` with ``side out`` pushes a sphere from the nearest
point of the block, at its edges and corners too, and one without thickness pushes from both sides. It may
move and turn. So a rectangle and a block along the axes can be parts within a convex container. Walls of the
container are one region; its planes that a part has to itself can be left out of it, and then the others go
on to the end of the box: that is as good as an opening where none of them leans over it. There is no plane
with a hole.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exporters.walls import lammps_regions as regions
from packgen.errors import ExportError
from packgen.geometry import (
    Container,
    Mesh,
    Motion,
    Polyhedron,
    Rotation,
    Surface,
    Translation,
    WallPart,
)

FLAT = 1.0e-6  # of the container's size: what is thinner has no thickness
LEAN = 1.0e-6  # sine of the angle by which a wall may lean over an opening

Float64Array = NDArray[np.float64]
Int64Array = NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class BlockPart:
    """A part within the container.

    Attributes:
        number: Its index among the container's parts.
        part: The part.
        label: Its name in letters, digits and underscores, unlike every other one.
        low: Its lower corner [m], shape (3,).
        high: Its upper corner [m], shape (3,); that of a sheet is the lower one along its normal.
    """

    number: int
    part: WallPart
    label: str
    low: Float64Array
    high: Float64Array

    @property
    def region(self) -> str:
        """What follows the name of its region."""
        sides = (f"{low!r} {high!r}" for low, high in zip(self.low.tolist(), self.high.tolist(), strict=True))
        return f"block {' '.join(sides)} side out"


@dataclass(frozen=True, eq=False, slots=True)
class Walls:
    """The walls of a deck.

    Attributes:
        commands: What makes the region ``wall``.
        open_top: Whether the container is open at its top.
        blocks: Parts within it.
        removed: Names of the parts of the region ``wall`` that are removed.
        commands_left: What makes the region ``wall_left``, without them; none where no plane is left.
    """

    commands: tuple[str, ...]
    open_top: bool
    blocks: tuple[BlockPart, ...] = ()
    removed: tuple[str, ...] = ()
    commands_left: tuple[str, ...] = ()


def walls_of(container: Container, wall_material: str) -> Walls:
    """Return the walls of a container as LAMMPS has them.

    Args:
        container: The container.
        wall_material: Name of the material of the walls without a name.

    Raises:
        ExportError: LAMMPS has no region for the container, or cannot do what a part is to do; a line a part.
    """
    if not container.parts:
        return Walls(*regions.wall_regions(container))
    blocks, lines = _blocks(container)
    inner = {each.number for each in blocks}
    outer = [number for number in range(len(container.parts)) if number not in inner]
    hull = None if lines else _hull(container, inner)
    if hull is None and not lines:
        lines = [_refusal(container.parts[number], NOT_CONVEX) for number in outer]
        if not lines:
            raise ExportError(regions.NOT_CONVEX)
    if hull is None:
        raise ExportError("\n".join(lines))
    planes = regions.planes_with_facets(hull, hull.surface)
    lines = [line for number in outer if (line := _fault(container, number, planes, wall_material))]
    if lines:
        raise ExportError("\n".join(lines))
    taken = [number for number in outer if container.parts[number].remove]
    left = np.ones(len(planes.offset), np.bool_)
    for number in taken:
        left &= ~_planes_of(container, container.parts[number].faces, planes)
    centre = container.bounds.mean(axis=0)
    commands_left: tuple[str, ...] = ()
    if taken:
        commands_left = regions.plane_commands("wall_left", planes.normal[left], planes.offset[left], centre)
    return Walls(
        regions.plane_commands("wall", planes.normal, planes.offset, centre),
        planes.is_open or (isinstance(container.shape, Mesh) and _has_open_edges(hull.surface)),
        blocks,
        tuple(container.parts[number].name for number in taken),
        commands_left,
    )


NOT_CONVEX = (
    "walls with it are not convex, and LAMMPS has no walls of triangles: within a convex container it has "
    "rectangles and blocks along x, y and z"
)


def _refusal(part: WallPart, why: str, remedy: str = "") -> str:
    advice = f", or {remedy}" if remedy else ""
    return f"lammps: wall {part.name}: {why}; export it for liggghts or yade{advice}"


def _blocks(container: Container) -> tuple[tuple[BlockPart, ...], list[str]]:
    """Return the parts within a container, and a line for each one that is no rectangle and no block."""
    if not isinstance(container.shape, Mesh):
        return (), []
    found, lines = [], []
    size = float(np.ptp(container.bounds, axis=0).max())
    labels: set[str] = set()
    for number, part in enumerate(container.parts):
        corners = container.surface.vertices[container.surface.faces[part.faces]]
        if not _is_within(container, corners, size):
            continue
        if not _is_block(corners, size):
            lines.append(_refusal(part, NOT_CONVEX))
            continue
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        high = np.where(high - low <= FLAT * size, low, high)
        label = re.sub(r"\W", "_", part.name)
        while label in labels:
            label += "_"
        labels.add(label)
        found.append(BlockPart(number, part, label, low, high))
    return tuple(found), lines


def _is_within(container: Container, corners: Float64Array, size: float) -> bool:
    """Return whether the plane of one of some triangles (K, 3, 3) has walls without a name on both sides."""
    walls = container.surface.vertices[container.surface.faces[container.part_index < 0]].reshape(-1, 3)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    slack = 10 * regions.SAME_OFFSET * size
    for each, corner in zip(normal, corners[:, 0], strict=True):
        height = walls @ each - corner @ each
        if height.min() < -slack and height.max() > slack:
            return True
    return False


def _is_block(corners: Float64Array, size: float) -> bool:
    """Return whether triangles (K, 3, 3) are a rectangle along the axes, or the surface of such a block."""
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    extent = np.where(high - low <= FLAT * size, 0.0, high - low)
    flat = np.abs(corners[:, :, None] - np.stack([low, high])).max(axis=1) <= FLAT * size
    if not flat.any(axis=(1, 2)).all():
        return False
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    ).sum()  # fmt: skip
    sides = extent[[1, 2, 0]] * extent[[2, 0, 1]]
    if (extent == 0.0).sum() == 1:
        return bool(abs(area - sides.max()) <= FLAT * sides.max())
    volume = (
        abs(np.einsum("ki,ki->", corners[:, 0] - low, np.cross(corners[:, 1] - low, corners[:, 2] - low))) / 6
    )
    return bool(
        extent.min() > 0.0
        and abs(area - 2.0 * sides.sum()) <= FLAT * area
        and abs(volume - extent.prod()) <= FLAT * extent.prod()
    )


def _hull(container: Container, inner: set[int]) -> Polyhedron | None:
    """Return the walls without the parts within them as a convex polyhedron, None where they are none."""
    if isinstance(container.shape, Polyhedron):
        return container.shape
    faces = container.surface.faces[~np.isin(container.part_index, list(inner))]
    used, compact = np.unique(faces, return_inverse=True)
    surface = Surface(container.surface.vertices[used], compact.reshape(-1, 3))
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    offset = (normal * corners[:, 0]).sum(axis=1)
    wraps = (np.abs(normal[:, list(container.periodic)]) > 1.0 - FLAT).any(axis=1)
    planes = regions.same_planes_once(normal[~wraps], offset[~wraps], surface.vertices)
    slack = 10 * regions.SAME_OFFSET * float(np.ptp(surface.vertices, axis=0).max())
    if (surface.vertices @ planes[0].T > planes[1] + slack).any():
        return None
    return Polyhedron(*planes, surface)


def _has_open_edges(surface: Surface) -> bool:
    edges = np.sort(surface.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 1).any())


def _fault(container: Container, number: int, planes: regions.Planes, wall_material: str) -> str | None:
    """Return a line where LAMMPS cannot do what a part of the container's own walls is to do."""
    part = container.parts[number]
    if part.material != wall_material:
        why = f"its material is {part.material}, and LAMMPS has one wall all round"
        return _refusal(part, why, f"give it the material {wall_material}")
    if part.motion is not None:
        return _refusal(
            part, "LAMMPS has one wall all round, and cannot move a part of it", "leave `move` out"
        )
    if not part.remove:
        return None
    own = _planes_of(container, part.faces, planes)
    others = np.flatnonzero(container.part_index != number)
    if (own & _planes_of(container, others, planes)).any():
        return _refusal(
            part, "it is a part of a flat wall, and LAMMPS has no wall with a hole", "leave `remove` out"
        )
    corners = np.unique(container.surface.faces[part.faces])
    beside = others[np.isin(container.surface.faces[others], corners).any(axis=1)]
    near = _planes_of(container, beside, planes) & ~own
    if (planes.normal[near] @ planes.normal[own].T > LEAN).any():
        return _refusal(
            part, "LAMMPS' walls beside it would go on beyond the opening, and lean over it",
            "leave `remove` out",
        )  # fmt: skip
    return None


def _planes_of(container: Container, faces: Int64Array, planes: regions.Planes) -> NDArray[np.bool_]:
    """Return which planes some facets lie on, shape (P,)."""
    return regions.on_planes(container.surface.vertices, container.surface.faces[faces], planes)


def motion_commands(motion: Motion, label: str) -> tuple[tuple[str, ...], str]:
    """Return the variables of a motion that starts with step 0, and what follows a region that moves so.

    Reference: LAMMPS manual, page "region", keywords move and rotate: variables, evaluated at each step.
    """
    if isinstance(motion, Rotation):
        name = f"turn_{label}"
        place = " ".join(map(repr, [*motion.origin.tolist(), *motion.axis.tolist()]))
        return (f"variable {name} equal 2.0*PI*step*dt/{motion.period!r}",), f"rotate v_{name} {place}"
    names, lines = [], []
    along = motion.velocity if isinstance(motion, Translation) else motion.amplitude
    for axis, size in zip("xyz", along.tolist(), strict=True):
        if size == 0.0:
            names.append("NULL")
            continue
        names.append(f"v_{axis}_{label}")
        way = "step*dt" if isinstance(motion, Translation) else f"sin(2.0*PI*step*dt/{motion.period!r})"
        lines.append(f"variable {axis}_{label} equal {size!r}*{way}")
    return tuple(lines), f"move {' '.join(names)}"
