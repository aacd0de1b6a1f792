"""A container with named parts of its walls: some close an opening of it, others stand or hang in it.

A part closes an opening where its rim lies on that of the opening: it becomes one surface with the container.
Any other part is a solid body where it is closed, and a sheet, a wall with space on both sides, where it is
open. All hold spheres; which triangles belong to which part is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array, unique_rows
from packgen.container.closing import closing_pieces, joined
from packgen.container.convex import convex_hull
from packgen.container.crossings import spread_points
from packgen.container.inner_wall import share_within
from packgen.container.load import bounded_by, primitive_shape, told_vessel, vessel_shape
from packgen.container.meshfile import read_surface
from packgen.container.patches import read_named
from packgen.container.shells import bodies, flipped, shell_of, stacked
from packgen.container.solids import NamedSurfaces, listed
from packgen.container.stitching import SLACK
from packgen.errors import GeometryError
from packgen.geometry import Box, Container, Mesh, Shape, Surface, WallPart

if TYPE_CHECKING:
    from packgen.scene.models import ContainerSpec
    from packgen.scene.walls import WallSpec

REACH = 0.02  # how far from a point walls are looked for, as a fraction of the extent
Mark = Callable[[str], str]
Warn = Callable[[str], None]


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """A named part as a surface.

    Attributes:
        name: Its name.
        place: Where the scene has it, for messages.
        surface: Its triangles.
    """

    name: str
    place: str
    surface: Surface


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """What bounds the spheres, with and without the parts that stand in it.

    Attributes:
        shape: Its shape.
        walls: Its triangles.
        closed: The same with lids; winds once around inside points.
        volume: What it encloses [m3].
        known: Triangles of each surface that went into ``walls``.
        owner: The piece of each of ``known``, -1 for the container's own, shape (F,).
    """

    shape: Shape
    walls: Surface
    closed: Surface
    volume: float
    known: Surface
    owner: Int64Array


def container_with_parts(
    spec: ContainerSpec, walls: Sequence[WallSpec], gravity_direction: Float64Array, mark: Mark, warn: Warn
) -> Container:
    """Return a container with named parts of its walls.

    Args:
        spec: The container.
        walls: The parts, their materials filled in.
        gravity_direction: Where things fall, shape (3,).
        mark: Returns where ``container`` or ``walls``, or a key in them, stands, for messages.
        warn: Called with a sentence for each fault of a mesh that was mended.

    Raises:
        GeometryError: A mesh cannot be read, container and parts bound no volume, or a part lies outside of
            the container or on its wall.
    """
    up = -gravity_direction
    own, pieces = _read(spec, walls, mark, warn)
    room, closing = _room(spec, own, pieces, up, mark, warn)
    inner = [piece for number, piece in enumerate(pieces) if number not in closing]
    numbers = [number for number in range(len(pieces)) if number not in closing]
    if inner:
        room = _furnished(room, dict(zip(numbers, inner, strict=True)), up)
    owner = _owners(room)
    parts = tuple(
        WallPart(each.name, np.flatnonzero(owner == number), each.material or "", each.remove, each.motion)
        for number, each in enumerate(walls)
    )
    return bounded_by(spec, (room.shape, room.walls, room.volume), mark("container"), parts)


def _read(
    spec: ContainerSpec, walls: Sequence[WallSpec], mark: Mark, warn: Warn
) -> tuple[Surface | None, list[Piece]]:
    """Return the container's own mesh without the solids that are parts, None for a primitive; the parts."""
    inside: NamedSurfaces | None = None
    own: Surface | None = None
    if spec.path is not None and any(each.path is None for each in walls):
        wanted = [each.name for each in walls if each.path is None]
        inside = read_named(spec.path, spec.scale, mark("container.path"), wanted)
        own_names = [name for name in inside.surfaces if name not in wanted]
        if not own_names:
            raise GeometryError(
                f"{mark('walls')}: all surfaces of {spec.path.name} are parts, expected one that is not"
            )
        own = stacked([inside.surfaces[name] for name in own_names])
        _say(spec.path.name, inside.mended, warn)
    elif spec.path is not None:
        own, mended = read_surface(spec.path, spec.scale, mark("container.path"))
        _say(spec.path.name, mended, warn)
    pieces = []
    for index, each in enumerate(walls):
        place = f"{mark(f'walls[{index}]')}: walls[{index}] ({each.name})"
        if each.path is not None:
            surface, mended = read_surface(
                each.path, each.scale, f"{mark(f'walls[{index}].path')}: {each.name}"
            )
            _say(each.path.name, mended, warn)
        else:
            surface = _named(inside, each.name, place)
        pieces.append(Piece(each.name, place, surface))
    return own, pieces


def _named(inside: NamedSurfaces | None, name: str, place: str) -> Surface:
    """Return a surface of the container's file.

    Raises:
        GeometryError: It has none of that name.
    """
    surfaces = inside.surfaces if inside is not None else {}
    if name not in surfaces:
        known = listed(inside.names if inside is not None else ())
        raise GeometryError(
            f"{place}: found no surface of that name, expected one of the container's file: {known}; or give "
            "it a `path`"
        )
    return surfaces[name]


def _say(name: str, sentences: Sequence[str], warn: Warn) -> None:
    for sentence in sentences:
        warn(f"{name}: {sentence}")


def _room(
    spec: ContainerSpec, own: Surface | None, pieces: list[Piece], up: Float64Array, mark: Mark, warn: Warn
) -> tuple[Room, set[int]]:
    """Return the container with the parts that close its openings, and which parts these are."""
    if own is None:
        assert spec.primitive is not None
        shape, walls, volume = primitive_shape(spec.primitive)
        exact = shape if isinstance(shape, Box) else Mesh(walls)
        return Room(exact, walls, walls, volume, walls, np.full(len(walls.faces), -1)), set()
    assert spec.path is not None
    surfaces = [piece.surface for piece in pieces]
    closing = closing_pieces(own, surfaces)
    known, owner = joined(own, {number: surfaces[number] for number in sorted(closing)})
    place = f"{mark('container.path')}: {spec.path.name}"
    if closing:
        place += f" with {', '.join(pieces[number].name for number in sorted(closing))}"
    try:
        vessel = told_vessel(known, up, place, spec.path.name, warn)
    except GeometryError as error:
        left = [piece.name for number, piece in enumerate(pieces) if number not in closing]
        if not left:
            raise
        raise GeometryError(
            f"{error}; no opening is closed by {', '.join(left)}: a wall closes one where its rim lies on "
            "that of the opening"
        ) from error
    shape, walls, volume = vessel_shape(vessel, convex_hull(known.vertices, place))
    return Room(shape, walls, vessel.closed, volume, known, owner), closing


def _furnished(room: Room, inner: dict[int, Piece], up: Float64Array) -> Room:
    """Return a room with the parts that stand or hang in it."""
    walls, closed, known, owner = [room.walls], [room.closed], [room.known], [room.owner]
    volume = room.volume
    for number, piece in inner.items():
        for body in bodies(piece.surface):
            solid = shell_of(body, up)
            if solid is None or solid.lidded:
                _check_sheet(room, piece, body)
                walls.append(body)
                closed += [body, flipped(body)]
            else:
                outward = solid.closed if solid.volume > 0.0 else flipped(solid.closed)
                _check_room_left(room, piece, outward)
                share = share_within(outward, room.closed)
                if share == 0.0 and not _within(room, spread_points(outward)).any():
                    raise _outside(piece, room)
                inward = flipped(outward)
                walls.append(inward)
                closed.append(inward)
                volume -= share * abs(solid.volume)
        known.append(piece.surface)
        owner.append(np.full(len(piece.surface.faces), number))
    return Room(
        Mesh(stacked(closed)), stacked(walls), room.closed, volume, stacked(known), np.concatenate(owner)
    )


def _check_room_left(room: Room, piece: Piece, body: Surface) -> None:
    """Refuse a body that has all of a room within.

    Raises:
        GeometryError: It has.
    """
    from packgen.check.inside import inside

    if not np.asarray(inside(body.vertices[body.faces], spread_points(room.closed))).all():
        return
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    raise GeometryError(
        f"{piece.place}: found a body around the container, from {_point(low)} to {_point(high)} m, expected "
        "one within it that leaves room; are its `units` right?"
    )


def _check_sheet(room: Room, piece: Piece, sheet: Surface) -> None:
    """Refuse a sheet that is nowhere inside a room, or lies on its walls.

    Raises:
        GeometryError: It is so.
    """
    from packgen.check.mesh import MeshWalls

    points = spread_points(sheet)
    extent = float(np.ptp(room.walls.vertices, axis=0).max())
    distance = MeshWalls(room.closed).distance(points, np.full(len(points), REACH * extent))
    at_wall = distance <= SLACK * extent
    if at_wall.any() and np.count_nonzero(at_wall) >= 0.5 * len(points):
        raise GeometryError(
            f"{piece.place}: found a wall that lies on the container's own, expected an opening there, which "
            "it closes, its rim on that of the opening; cut the opening out of the container's mesh"
        )
    if not _within(room, points[~at_wall]).any():
        raise _outside(piece, room)


def _within(room: Room, points: Float64Array) -> BoolArray:
    """Return which points (N, 3) are inside a room, shape (N,)."""
    from packgen.check.inside import inside

    return np.asarray(inside(room.closed.vertices[room.closed.faces], points))


def _outside(piece: Piece, room: Room) -> GeometryError:
    low, high = piece.surface.vertices.min(axis=0), piece.surface.vertices.max(axis=0)
    least, most = room.walls.vertices.min(axis=0), room.walls.vertices.max(axis=0)
    return GeometryError(
        f"{piece.place}: found a wall outside of the container, from {_point(low)} to {_point(high)} m, "
        f"expected it within {_point(least)} to {_point(most)} m, or closing an opening, its rim on that of "
        "the opening; are its `units` right?"
    )


def _point(place: Float64Array) -> str:
    return "(" + ", ".join(f"{each:.4g}" for each in place) + ")"


def _owners(room: Room) -> Int64Array:
    """Return the piece of each triangle of a room's walls, -1 for the container's own, shape (F,)."""
    corners = np.concatenate([room.walls.vertices, room.known.vertices])
    _, place = unique_rows(corners)
    first = len(room.walls.vertices)
    faces = np.concatenate([place[:first][room.walls.faces], place[first:][room.known.faces]])
    _, group = unique_rows(np.sort(faces, axis=1))
    owner_of = np.full(int(group.max()) + 1, -1)
    owner_of[group[len(room.walls.faces) :]] = room.owner
    return np.asarray(owner_of[group[: len(room.walls.faces)]])
