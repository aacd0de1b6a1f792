"""Writes a bed in pieces from spheres that come in any order of places, some at a time.

Spheres wait in a file a piece, to which rows are added; in the end each becomes an archive of numpy. So no
more than some spheres and one piece are held.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from packgen.arrays import Float64Array, Int32Array
from packgen.bed import Bed, Census
from packgen.census import count_spheres
from packgen.pieces.bed import NAMES, PieceBed
from packgen.pieces.grid import Grid
from packgen.pieces.manifest import MANIFEST, Manifest, Piece

FOLDER = "pieces"
HELD_MAX = 250_000  # spheres that wait in memory: 11 MB
ROW = np.dtype([
    ("position", np.float64, (3,)), ("radius", np.float64), ("set_index", np.int32), ("zone_index", np.int32),
    ("batch_index", np.int32),
])  # fmt: skip


class PieceWriter:
    """Takes spheres and leaves their pieces in a folder.

    Args:
        folder: The folder, which exists; the pieces come into a folder in it.
        grid: The space of each piece.
        sets: Number of particle sets.

    Attributes:
        count: Number of spheres so far.
    """

    def __init__(self, folder: Path, grid: Grid, sets: int) -> None:
        self.count = 0
        self._folder, self._grid, self._sets = folder, grid, sets
        self._held: list[NDArray[Any]] = []
        self._waiting = 0
        (folder / FOLDER).mkdir()

    def add(
        self,
        position: Float64Array,
        radius: Float64Array,
        set_index: Int32Array,
        zone_index: Int32Array,
        batch_index: Int32Array,
    ) -> None:
        """Take spheres: centres [m], shape (N, 3), radii [m] and where they belong, int32, (N,) each."""
        rows = np.empty(len(radius), ROW)
        columns = (position, radius, set_index, zone_index, batch_index)
        for name, values in zip(NAMES, columns, strict=True):
            rows[name] = values
        self._held.append(rows)
        self._waiting += len(rows)
        self.count += len(rows)
        if self._waiting >= HELD_MAX:
            self._put_away()

    def finish(self) -> tuple[tuple[Piece, ...], Census]:
        """Make the pieces of all spheres; return them in their order, and the census of all spheres."""
        self._put_away()
        pieces, number, census = [], 0, _nothing(self._sets)
        for box in range(len(self._grid.boxes)):
            waiting = self._path(box, "rows")
            if not waiting.exists():
                continue
            rows = np.fromfile(waiting, ROW)
            path = self._path(box, "npz")
            with path.open("wb") as file:
                arrays: dict[str, Any] = {name: np.ascontiguousarray(rows[name]) for name in NAMES}
                np.savez(file, **arrays)
                file.flush()
                os.fsync(file.fileno())
            waiting.unlink()
            own = count_spheres(rows["position"], rows["radius"], rows["set_index"], self._sets)
            census = census.join(own)
            low, high = ((float(x), float(y), float(z)) for x, y, z in (own.low, own.high))
            pieces.append(Piece(f"{FOLDER}/{path.name}", number, len(rows), low, high))
            number += len(rows)
        return tuple(pieces), census

    def _put_away(self) -> None:
        """Add the spheres that wait to the files of their pieces."""
        rows = np.concatenate([np.empty(0, ROW), *self._held])
        self._held, self._waiting = [], 0
        box = self._grid.number(rows["position"])
        order = np.argsort(box, kind="stable")
        numbers, first = np.unique(box[order], return_index=True)
        for number, own in zip(numbers.tolist(), np.split(order, first[1:]), strict=False):
            with self._path(number, "rows").open("ab") as file:
                file.write(rows[own].tobytes())

    def _path(self, box: int, suffix: str) -> Path:
        x, y, z = np.unravel_index(box, self._grid.shape)
        return self._folder / FOLDER / f"piece_{x:04d}_{y:04d}_{z:04d}.{suffix}"


def _nothing(sets: int) -> Census:
    return count_spheres(np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.int32), sets)


def in_pieces(bed: Bed, folder: Path, *, spheres: int | None = None) -> PieceBed:
    """Write a bed in pieces, manifest and all; the spheres' numbers become those of the pieces.

    Args:
        bed: The bed, of spheres that belong to no bodies, in a vessel that does not wrap around.
        folder: The folder, which exists.
        spheres: Spheres of a piece, about; None: `packgen.pieces.grid.SPHERES`.

    Returns:
        The bed in pieces.

    Raises:
        ValueError: The vessel wraps around, or spheres belong to bodies.
    """
    if any(bed.container.periodic) or bed.body_index is not None:
        raise ValueError("in_pieces: found a vessel that wraps around, or bodies, expected walls and spheres")
    volume = 4.0 / 3.0 * np.pi * float((bed.radius**3).mean())
    sized = {} if spheres is None else {"spheres": spheres}
    grid = Grid.over(bed.container.bounds, volume, float(bed.radius.max()), **sized)
    return collected([bed], bed, folder, grid)


def collected(parts: Iterable[Bed], head: Bed, folder: Path, grid: Grid) -> PieceBed:
    """Write spheres that come as beds in pieces, manifest and all.

    Args:
        parts: The spheres.
        head: A bed that has all else.
        folder: The folder, which exists.
        grid: The space of each piece.

    Returns:
        The bed in pieces.
    """
    writer = PieceWriter(folder, grid, len(head.particle_sets))
    for each in parts:
        writer.add(each.position, each.radius, each.set_index, each.zone_index, each.batch_index)
    pieces, census = writer.finish()
    Manifest(pieces, census, head.provenance).write(folder / MANIFEST)
    return PieceBed(
        folder, pieces, census, head.particle_sets, head.materials, head.wall_material, head.container,
        head.gravity, head.tolerance, head.provenance,
    )  # fmt: skip
