"""The spheres that a page shows, from a bed or from ``bed.npz``, and a faithful part of very many."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bed import Bed
from packgen.bedfile import load_columns
from packgen.errors import PackgenError
from packgen.geometry import Container
from packgen.geometry.cells import cell_container
from packgen.measure import against_gravity
from packgen.pieces import MANIFEST, is_manifest, read_gathered

SHOWN_MAX = 480_000  # spheres in a page: 4.5 MB of text
PLACES = 65_535  # steps of a coordinate in a page
SIZES = 255  # steps of the logarithm of a radius in a page

BODY_COLOURS = 8  # by which bodies are told apart
BATCHES_MAX = 4_000  # batches that a page tells apart
FRAME_MAX = 1.5  # how far the picture reaches beyond a bed for the sake of its vessel, in sizes of the bed


@dataclass(frozen=True, eq=False, slots=True)
class Spheres:
    """What a view needs of a bed.

    Attributes:
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        set_index: Particle set of each sphere, shape (N,), int32.
        zone_index: Zone of each sphere, shape (N,), int32.
        batch_index: Batch of each sphere, shape (N,), int32.
        up: Unit vector against gravity, shape (3,), float64.
        container: The vessel; None: not known.
        body_index: Body of each sphere, shape (N,), int32; None: each sphere is a body.
    """

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    zone_index: Int32Array
    batch_index: Int32Array
    up: Float64Array
    container: Container | None = None
    body_index: Int32Array | None = None


def spheres_of(bed: Bed) -> Spheres:
    """Return the spheres of a bed."""
    return Spheres(
        bed.position, bed.radius, bed.set_index, bed.zone_index, bed.batch_index, against_gravity(bed),
        bed.container if bed.container.walls_known else None, bed.body_index,
    )  # fmt: skip


def read_spheres(
    path: Path, gravity_direction: Sequence[float] | None, container: Container | None = None
) -> Spheres:
    """Read ``bed.npz``, or the pieces in its place.

    Args:
        path: The file.
        gravity_direction: Where things fall; None: along -z.
        container: The vessel; None: not known.

    Raises:
        PackgenError: The file is missing, or was not written by packgen.
    """
    up = -np.asarray(gravity_direction or (0.0, 0.0, -1.0), dtype=np.float64)
    manifest = path.with_name(MANIFEST)
    try:
        in_pieces = not path.exists() and is_manifest(manifest)
        found = read_gathered(manifest) if in_pieces else load_columns(path)
    except FileNotFoundError as error:
        raise PackgenError(f"{path}: not found; expected a result folder of packgen") from error
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise PackgenError(
            f"{path}: cannot be read as a bed ({error}); run the scene again to make it anew"
        ) from error
    if found.cell is not None:
        container = cell_container(found.cell)
    return Spheres(
        found.position, found.radius, found.set_index, found.zone_index, found.batch_index,
        up / float(np.linalg.norm(up)) + 0.0, container, found.body_index,
    )  # fmt: skip


def view_data(spheres: Spheres, limit: int = SHOWN_MAX) -> dict[str, Any]:
    """Return what the page's 3-D view draws, as plain data.

    The view's frame: x to the right, y away from the viewer, z up, the origin in the bed's middle. The cut is
    a plane of equal y. Coordinates are rounded to a 65,535th of the bed's extents, radii to a 255th of the
    logarithm of their range: enough for a picture in which a bed is a thousand pixels wide.

    Args:
        spheres: All spheres.
        limit: Most spheres that the page may hold.

    Returns:
        ``count`` and ``shown``, numbers of spheres; ``outer``, number of those that may be seen from outside,
        which come first; ``half``, half the bed's extents [m]; ``span``, half the extents of the centres [m];
        ``radius_min`` and ``radius_max`` [m]; ``labels``, runs of spheres as (count, set, zone, batch); and
        as base64: ``place`` uint16 (x, y, z), from -span to span, and ``size`` uint8, from the smallest
        radius to the largest; where spheres belong to bodies ``body`` uint8, a number from 0 to 7 by which
        bodies have their colours, and ``depth`` uint16, the y of the body's middle as in ``place``: a cut
        shows or hides a body as a whole. Of a vessel that is known, ``outlines`` (see
        `packgen.page.outline.line_data`), and ``frame``, ``middle`` and ``half`` of what is to be seen [m].
    """
    sound = np.flatnonzero(
        np.isfinite(spheres.position).all(axis=1) & np.isfinite(spheres.radius) & (spheres.radius > 0.0)
    )
    position = spheres.position[sound] @ upright_frame(spheres.up).T
    radius = spheres.radius[sound]
    low, high = np.zeros(3), np.zeros(3)
    if len(sound):
        low = (position - radius[:, None]).min(axis=0)
        high = (position + radius[:, None]).max(axis=0)
    middle = 0.5 * (low + high)
    position = position - middle
    body = None if spheres.body_index is None else spheres.body_index[sound]
    depth = depth_of_bodies(position, body)
    chosen = np.arange(len(sound))
    if len(sound) > limit:
        chosen = faithful_part(position, radius, limit, None if body is None else depth)
    position, radius, own = position[chosen], radius[chosen], sound[chosen]
    inside = np.ones(len(radius), dtype=bool)
    inside[near_the_outside(position, radius, cells=2)] = False
    batch, zone, group = spheres.batch_index[own], spheres.zone_index[own], spheres.set_index[own]
    together = len(np.unique(batch)) // BATCHES_MAX + 1
    batch = batch // together * together  # of very many, neighbours share a number
    order = np.lexsort((batch, zone, group, inside))
    span = np.abs(position).max(axis=0, initial=0.0)
    smallest, largest = radius.min(initial=np.inf), radius.max(initial=0.0)
    share = np.log(radius / smallest) / max(np.log(largest / smallest), 1e-9) if len(radius) else radius
    place = 0.5 + 0.5 * position[order] / np.maximum(span, 1e-300)
    return {
        "count": len(spheres.radius),
        "shown": len(chosen),
        "outer": int(np.count_nonzero(~inside)),
        "half": (0.5 * (high - low)).tolist(),
        "span": span.tolist(),
        "radius_min": float(smallest) if len(radius) else 0.0,
        "radius_max": float(largest),
        "labels": _runs(np.stack([inside, group, zone, batch], axis=1)[order]),
        "place": _base64(np.rint(PLACES * place).astype("<u2")),
        "size": _base64(np.rint(SIZES * share[order]).astype("u1")),
        **_bodies(spheres, own[order], depth[chosen][order], span[1]),
        **_vessel(spheres, low, high),
    }


def _bodies(spheres: Spheres, shown: Int64Array, depth: Float64Array, span: float) -> dict[str, Any]:
    """Return the colour, neighbours in the list having others, and the depth of each shown sphere's body."""
    if spheres.body_index is None:
        return {}
    body = np.unique(spheres.body_index, return_inverse=True)[1]
    place = np.clip(0.5 + 0.5 * depth / max(span, 1e-300), 0.0, 1.0)
    return {
        "body": _base64((body[shown] % BODY_COLOURS).astype("u1")),
        "depth": _base64(np.rint(PLACES * place).astype("<u2")),
    }


def depth_of_bodies(position: Float64Array, body_index: Int32Array | None) -> Float64Array:
    """Return how far behind the bed's middle the particle of each sphere is [m], shape (N,), float64.

    Args:
        position: Centres in the view's frame, around the bed's middle [m], shape (N, 3).
        body_index: Body of each sphere, shape (N,); None: each sphere is a body.
    """
    own = position[:, 1]
    if body_index is None or len(own) == 0:
        return own
    body = np.unique(body_index, return_inverse=True)[1]
    count = np.bincount(body)
    lowest, highest = np.full(len(count), np.inf), np.full(len(count), -np.inf)
    np.minimum.at(lowest, body, own)
    np.maximum.at(highest, body, own)
    # Across a seam of the box the parts of a body are far from each other: each goes by its own place.
    whole = (highest - lowest < np.ptp(own) / 2.0)[body]
    return np.where(whole, (np.bincount(body, own) / count)[body], own)


def _vessel(spheres: Spheres, low: Float64Array, high: Float64Array) -> dict[str, Any]:
    """Return outlines and frame of a view whose bed has some bounds, (3,) each, in the view's frame [m]."""
    if spheres.container is None:
        return {}
    from packgen.page.outline import CONTAINER, line_data, outline

    middle = 0.5 * (low + high)
    lines = outline(spheres.container.surface, spheres.up)
    ends = (lines @ upright_frame(spheres.up).T).reshape(-1, 3)
    first, last = np.minimum(low, ends.min(axis=0)), np.maximum(high, ends.max(axis=0))
    # A small bed in a large vessel is what is looked at: the vessel then reaches beyond the picture.
    size = np.maximum(high - low, 1e-300)
    first, last = np.maximum(first, low - FRAME_MAX * size), np.minimum(last, high + FRAME_MAX * size)
    frame = {"middle": (0.5 * (first + last) - middle).tolist(), "half": (0.5 * (last - first)).tolist()}
    return {
        "frame": frame,
        "outlines": [line_data("container", CONTAINER, lines, spheres.up, middle)],
    }


def _runs(label: Int64Array) -> list[list[int]]:
    """Return runs of equal rows (inside, set, zone, batch) as (count, set, zone, batch)."""
    if len(label) == 0:
        return []
    first = np.flatnonzero(np.append(True, (label[1:] != label[:-1]).any(axis=1)))
    count = np.diff(np.append(first, len(label)))
    return np.column_stack([count, label[first, 1:]]).tolist()  # type: ignore[no-any-return]


def faithful_part(
    position: Float64Array, radius: Float64Array, limit: int, depth: Float64Array | None = None
) -> Int64Array:
    """Return which spheres to show of too many: what one sees of the whole, and of its half.

    In this order: spheres that the plane y = 0 cuts; those that are seen from outside; those seen
    through the gaps of the cut; then any, evenly.

    Args:
        position: Centres around the bed's middle [m], shape (N, 3), float64.
        radius: Radii [m], shape (N,), float64.
        limit: Number of spheres to choose, less than N.
        depth: How far behind y = 0 the body of each sphere is [m], shape (N,), float64: the plane shows or
            hides bodies as wholes; None: it cuts spheres.

    Returns:
        Their indices in rising order, shape (limit,), int64.
    """
    rank = np.full(len(radius), np.inf, dtype=np.float32)
    step = len(radius) // limit + 1
    rank[::step] = 100.0
    pixel = 1.2 * float(np.median(radius))
    own = position[:, 1]
    if depth is None:
        cut, first = np.abs(own) < radius, radius
    else:
        cut, first = np.zeros(len(own), dtype=bool), np.where(depth < 0.0, np.inf, -np.inf)
    reach = 0.0 if depth is None else float(np.abs(depth - own).max())
    behind = np.flatnonzero((own >= first) & (own < 8.0 * np.median(radius) + reach))
    rank[behind[_nearest(position[behind], radius[behind], np.array([0.0, -1.0, 0.0]), 0.5 * pixel)]] = 50.0
    # Where there is no room for all, those that few views see are the first to be left out.
    seen = np.zeros(len(radius), dtype=np.float32)
    outer = near_the_outside(position, radius, cells=1)
    for direction in product((-1.0, 0.0, 1.0), repeat=3):
        if 0 < np.abs(direction).sum() != 2:
            seen[outer[_nearest(position[outer], radius[outer], np.array(direction), pixel)]] += 1.0
    rank = np.where(seen > 0.0, 20.0 - seen, rank)
    rank[cut] = 0.0
    return np.sort(np.argsort(rank, kind="stable")[:limit])


def near_the_outside(position: Float64Array, radius: Float64Array, cells: int) -> Int64Array:
    """Return the spheres within a few cells of one without centres, (M,), int64: no other is seen."""
    if len(radius) == 0:
        return np.zeros(0, dtype=np.int64)
    size = 2.5 * float(np.median(radius)) + 0.5 * float(radius.max())
    size = max(size, float(np.ptp(position, axis=0).max()) / 300.0)  # no grid is larger than 300 cells cubed
    cell = ((position - position.min(axis=0)) / size).astype(np.int64) + cells
    full = np.zeros(cell.max(axis=0) + 1 + cells, dtype=bool)
    full[tuple(cell.T)] = True
    inner = full
    for _ in range(cells):
        for axis in range(3):  # one after the other: all 26 neighbours
            inner = inner & np.roll(inner, 1, axis) & np.roll(inner, -1, axis)
    return np.flatnonzero(~inner[tuple(cell.T)])


def _nearest(
    position: Float64Array, radius: Float64Array, direction: Float64Array, pixel: float
) -> Int64Array:
    """Return the spheres that come first in each pixel, seen from ``direction``; shape (M,), int64."""
    view = upright_frame(direction / np.linalg.norm(direction))
    flat = position @ view[:2].T
    depth = position @ view[2] + radius
    cell = ((flat - flat.min(axis=0, initial=0.0)) / pixel).astype(np.int64)
    width = int(cell[:, 1].max(initial=0)) + 1
    place = cell[:, 0] * width + cell[:, 1]
    front = np.full(int(place.max(initial=0)) + 1, -np.inf)
    np.maximum.at(front, place, depth)
    return np.flatnonzero(depth == front[place])


def upright_frame(up: Float64Array) -> Float64Array:
    """Return a right-handed frame as rows, its third along ``up``, shape (3, 3), float64; the axes for +z."""
    start = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = start - (start @ up) * up
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(up, right), up])


def _base64(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
