"""A bed in pieces, read piece by piece: what is known of it as a whole, and its spheres a part at a time."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed, Census, Container, Head, Material, ParticleSet
from packgen.bedfile import Columns, load_columns
from packgen.errors import ReadError
from packgen.part import Part
from packgen.pieces.manifest import Piece, read_manifest

NAMES = ("position", "radius", "set_index", "zone_index", "batch_index")
NO_NUMBERS = np.zeros(0, np.int32)
NOTHING = Columns(np.zeros((0, 3)), np.zeros(0), NO_NUMBERS, NO_NUMBERS, NO_NUMBERS)
DAMAGED = (EOFError, KeyError, ValueError, TypeError, zipfile.BadZipFile, zlib.error)
GATHERED_MAX = 1_000_000
"""Spheres of a bed that steps which know no pieces may have at once: 44 MB."""


@dataclass(frozen=True, eq=False, slots=True)
class PieceBed(Head):
    """A bed whose spheres are in files; see `packgen.bed.Bed` for what is not told here.

    Attributes:
        folder: Where the files are.
        pieces: The files, in the order of their spheres' numbers.
        census: Numbers, sizes and places of all spheres in short.
        particle_sets: The sets.
        materials: The materials.
        wall_material: Name of the walls' material.
        container: The vessel, which does not wrap around.
        gravity: Acceleration of gravity [m/s2], shape (3,), float64.
        tolerance: Largest overlap asked for.
        provenance: Version, scene, seed, effective settings.
    """

    folder: Path
    pieces: tuple[Piece, ...]
    census: Census
    particle_sets: tuple[ParticleSet, ...]
    materials: tuple[Material, ...]
    wall_material: str
    container: Container
    gravity: Float64Array
    tolerance: float | None = 1.0e-6
    provenance: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    _boxes: Float64Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        boxes = np.array([(each.low, each.high) for each in self.pieces]).reshape(-1, 2, 3)
        object.__setattr__(self, "_boxes", boxes)

    @property
    def count(self) -> int:
        """Number of spheres."""
        return self.census.count

    def chunks(self) -> Iterator[Bed]:
        """Yield the spheres of each piece as a bed of their own.

        Raises:
            ReadError: A file is not there, or not the one that was written.
        """
        for piece in self.pieces:
            yield self.bed_of([self._columns(piece)])

    def some(self, pieces: Iterable[Piece]) -> Iterator[tuple[int, Bed]]:
        """Yield the spheres of some pieces, as `chunks` does, each with the number of its first sphere."""
        for piece in pieces:
            yield piece.offset, self.bed_of([self._columns(piece)])

    def parts(self, reach: float) -> Iterator[Part]:
        """Yield each piece with all spheres whose centres are near to one of its own.

        Args:
            reach: How near, along each axis [m].

        Raises:
            ReadError: A file is not there, or not the one that was written.
        """
        for piece in self.pieces:
            yield self.part(piece, reach)

    def part(self, piece: Piece, reach: float) -> Part:
        """Return a piece with all spheres whose centres are near to one of its own; see `parts`."""
        low, high = np.array(piece.low) - reach, np.array(piece.high) + reach
        found, numbers = [self._columns(piece)], [piece.offset + np.arange(piece.count)]
        for other in self._meeting(low, high):
            if other is piece:
                continue
            columns = self._columns(other)
            near = _inside(columns.position, low, high)
            if near.any():
                found.append(_chosen(columns, near))
                numbers.append(other.offset + np.flatnonzero(near))
        return Part(self.bed_of(found), piece.count, np.concatenate(numbers))

    def in_box(self, low: Float64Array, high: Float64Array) -> tuple[Columns, Int64Array]:
        """Return the columns of the spheres with centres in a box, and their numbers, (N,), rising."""
        found, numbers = [], [np.zeros(0, np.int64)]
        for piece in self._meeting(low, high):
            columns = self._columns(piece)
            near = _inside(columns.position, low, high)
            found.append(_chosen(columns, near))
            numbers.append(piece.offset + np.flatnonzero(near))
        return joined(found), np.concatenate(numbers)

    def every(self, step: int) -> Bed:
        """Return the spheres whose numbers are multiples of a step, in their order."""
        found = []
        for piece in self.pieces:
            first = -piece.offset % step
            if first < piece.count:
                found.append(_chosen(self._columns(piece), slice(first, None, step)))
        return self.bed_of(found)

    def gathered(self) -> Bed:
        """Return the whole bed."""
        return self.every(1)

    def bed_of(self, parts: Sequence[Columns], chosen: Int64Array | None = None) -> Bed:
        """Return spheres, or those of some places among them, as a bed that has all else of this one."""
        columns = joined(parts)
        found = columns if chosen is None else _chosen(columns, chosen)
        return Bed(
            found.position, found.radius, found.set_index, found.zone_index, found.batch_index,
            self.particle_sets, self.materials, self.wall_material, self.container, self.gravity,
            self.tolerance, self.provenance,
        )  # fmt: skip

    def _meeting(self, low: Float64Array, high: Float64Array) -> list[Piece]:
        """Return the pieces that have spheres in a box, maybe."""
        meets = ((self._boxes[:, 0] <= high) & (self._boxes[:, 1] >= low)).all(axis=1)
        return [self.pieces[place] for place in np.flatnonzero(meets).tolist()]

    def _columns(self, piece: Piece) -> Columns:
        return read_piece(self.folder / piece.file, piece.count, len(self.particle_sets))


def read_piece(path: Path, count: int, sets: int) -> Columns:
    """Read the columns of a piece.

    Args:
        path: Its file.
        count: How many spheres it has.
        sets: How many sets they are of at most.

    Raises:
        ReadError: The file is not there, or not the one that was written.
    """
    try:
        columns = load_columns(path)
    except FileNotFoundError:
        raise ReadError(f"{path}: found no such piece of the bed, expected one; make the bed anew") from None
    except DAMAGED as error:
        reason = " ".join(str(error).split())
        raise ReadError(
            f"{path}: found a damaged piece ({reason}), expected a whole one; make the bed anew"
        ) from error
    fits = [getattr(columns, name).shape for name in NAMES] == [(count, 3), *[(count,)] * 4]
    if not fits or columns.set_index.min() < 0 or columns.set_index.max() >= sets:
        raise ReadError(
            f"{path}: found other spheres than the manifest says, expected {count:,} of its sets; make the "
            "bed anew"
        )
    return columns


def read_gathered(path: Path) -> Columns:
    """Read the columns of a whole bed in pieces by its manifest.

    Raises:
        ReadError: It cannot be read, or has too many spheres to be gathered.
    """
    manifest = read_manifest(path)
    census = manifest.census
    if census.count > GATHERED_MAX:
        raise ReadError(
            f"{path}: found a bed in pieces of {census.count:,} spheres, expected at most {GATHERED_MAX:,}"
        )
    pieces = [read_piece(path.parent / each.file, each.count, len(census.counts)) for each in manifest.pieces]
    return joined(pieces)


def joined(parts: Sequence[Columns]) -> Columns:
    """Return the spheres of several columns in those of one."""
    return Columns(*(np.concatenate([getattr(each, name) for each in parts or [NOTHING]]) for name in NAMES))


def _chosen(columns: Columns, chosen: BoolArray | Int64Array | slice) -> Columns:
    # A view would keep the whole piece.
    return Columns(*(getattr(columns, name)[chosen].copy() for name in NAMES))


def _inside(position: Float64Array, low: Float64Array, high: Float64Array) -> BoolArray:
    return np.asarray(((position >= low) & (position <= high)).all(axis=1))
