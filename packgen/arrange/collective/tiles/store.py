"""What units hand on: files of a folder, each written whole under the name of its unit.

A unit that runs twice writes the same files. So the unit of a process that has ended runs again in another
one, and a run that was interrupted goes on from what is there. Each unit leaves two files: the spheres that
no layer can reach any more, with its report, and the blocks that it worked in. The latter are removed once no
unit will read them. A file has its name only once it is on the disk: a machine that goes down leaves no unit
that counts as done and is not.
"""

from __future__ import annotations

import os
import pickle
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.collective.tiles.layout import Block, Unit
from packgen.arrange.collective.tiles.stock import Stock, no_draw
from packgen.arrange.collective.tiles.unit import TileTask
from packgen.arrange.spheres import Spheres
from packgen.arrays import Float64Array
from packgen.errors import ReadError
from packgen.supply.supply import Draw

ROW = np.dtype(
    [
        ("position", np.float64, (3,)),
        ("radius", np.float64),
        ("set_index", np.int32),
        ("batch_index", np.int32),
    ]
)
"""A sphere at rest, 40 bytes."""

TASK = "task.pickle"

DAMAGED = (EOFError, KeyError, ValueError, TypeError, zipfile.BadZipFile, zlib.error)
"""What NumPy raises at a file that is not the one that was written."""

Rows = NDArray[Any]
"""Spheres at rest, dtype ``ROW``, shape (N,)."""


class UnitReport(NamedTuple):
    """What a unit reports.

    Attributes:
        gained: Spheres that are at rest now, fewer those that were before.
        thrown_back: Spheres that found no place.
        buried: Spheres that no layer can reach any more.
    """

    gained: int
    thrown_back: int
    buried: int


@dataclass(frozen=True, slots=True)
class Store:
    """The folder of a run's units; all processes that work on it must see it.

    What reads a unit's files raises a ``ReadError`` where one is damaged, or gone: a disk was full, or a
    machine went down before it had written all.

    Attributes:
        folder: The folder, which exists.
    """

    folder: Path

    def write_task(self, task: TileTask) -> None:
        """Write what all units share."""
        self._whole(TASK, lambda file: pickle.dump(task, file))

    def task(self) -> TileTask:
        """Return what all units share."""
        path = self.folder / TASK
        return _task(path, path.stat().st_mtime_ns)

    def write_supply(self, number: int, draw: Draw) -> None:
        """Write the spheres that are dealt to the tiles in a round."""
        self._whole(f"round_{number}_radius.npy", lambda file: np.save(file, draw.radius))
        self._whole(f"round_{number}_set.npy", lambda file: np.save(file, draw.set_index))

    def dealt(self, number: int, begin: int, end: int) -> Stock:
        """Return a tile's spheres of a round, none of them handed out."""
        radius = np.load(self.folder / f"round_{number}_radius.npy", mmap_mode="r")
        set_index = np.load(self.folder / f"round_{number}_set.npy", mmap_mode="r")
        return Stock(radius[begin:end], set_index[begin:end], 0, no_draw())

    def read_stock(self, unit: Unit, dealt: Stock) -> Stock:
        """Return a tile's spheres of a round as a unit has left them."""
        with self._stored(_bed_name(unit)) as stored:
            carried = Draw(stored["carried_radius"], stored["carried_set"])
            return Stock(dealt.radius, dealt.set_index, int(stored["cursor"]), carried)

    def read_blocks(self, unit: Unit, blocks: Sequence[Block]) -> list[tuple[Rows, Float64Array]]:
        """Return spheres and buried tops of some blocks as a unit has left them; nothing else is read."""
        with self._stored(_state_name(unit)) as stored:
            return [(stored[_member("rows", each)], stored[_member("tops", each)]) for each in blocks]

    def write_blocks(self, unit: Unit, blocks: dict[Block, tuple[Rows, Float64Array]]) -> None:
        """Write spheres and buried tops of the blocks that a unit worked in."""
        arrays: dict[str, Any] = {}
        for block, (rows, tops) in blocks.items():
            arrays[_member("rows", block)], arrays[_member("tops", block)] = rows, tops
        self._whole(_state_name(unit), lambda file: np.savez(file, **arrays))

    def finish(self, unit: Unit, buried: Rows, stock: Stock, report: UnitReport) -> None:
        """Write a unit's buried spheres, its spheres to come and its report: it is done then."""
        arrays: dict[str, Any] = {
            "rows": buried,
            "cursor": np.int64(stock.cursor),
            "carried_radius": stock.carried.radius,
            "carried_set": stock.carried.set_index,
            "report": np.array(report, np.int64),
        }
        self._whole(_bed_name(unit), lambda file: np.savez(file, **arrays))

    def report(self, unit: Unit) -> UnitReport | None:
        """Return what a unit has reported; None: it is not done."""
        if not (self.folder / _bed_name(unit)).exists():
            return None
        with self._stored(_bed_name(unit)) as stored:
            return UnitReport(*stored["report"].tolist())

    def buried(self, unit: Unit) -> Rows:
        """Return the spheres that a unit has put away."""
        with self._stored(_bed_name(unit)) as stored:
            rows: Rows = stored["rows"]
            return rows

    def forget(self, unit: Unit) -> None:
        """Remove the blocks of a unit that no other will read."""
        (self.folder / _state_name(unit)).unlink(missing_ok=True)

    @contextmanager
    def _stored(self, name: str) -> Iterator[Any]:
        """Open a file of arrays.

        Raises:
            ReadError: It is damaged, or not there.
        """
        path = self.folder / name
        remedy = f"remove {self.folder} and begin anew, without --resume"
        try:
            with np.load(path) as stored:
                yield stored
        except FileNotFoundError:
            raise ReadError(f"{path}: found no such part of the bed, expected one; {remedy}") from None
        except DAMAGED as error:
            reason = " ".join(str(error).split())
            raise ReadError(
                f"{path}: found a damaged part of the bed, expected a whole one: {reason}; {remedy}"
            ) from error

    def _whole(self, name: str, write: Any) -> None:
        """Write a file that is there as a whole or not at all."""
        descriptor, scratch = tempfile.mkstemp(dir=self.folder, prefix=".")
        try:
            # A full disk may be told of only where the file is closed.
            with open(descriptor, "wb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
            os.replace(scratch, self.folder / name)
        except BaseException:
            os.unlink(scratch)
            raise


@lru_cache(maxsize=1)
def _task(path: Path, _changed: int) -> TileTask:
    """Return what all units share; it is read once a process."""
    with path.open("rb") as file:
        task: TileTask = pickle.load(file)
        return task


def _bed_name(unit: Unit) -> str:
    return f"layer_{unit.layer:05d}_tile_{unit.u:04d}_{unit.v:04d}.npz"


def _state_name(unit: Unit) -> str:
    return f"layer_{unit.layer:05d}_tile_{unit.u:04d}_{unit.v:04d}.state.npz"


def _member(kind: str, block: Block) -> str:
    return f"{kind}_{block.u}_{block.v}"


def rows_of(spheres: Spheres) -> Rows:
    """Return spheres as rows."""
    rows = np.empty(len(spheres), ROW)
    for name in ROW.names or ():
        rows[name] = getattr(spheres, name)
    return rows


def spheres_of(rows: Sequence[Rows], zone_index: int) -> Spheres:
    """Return rows as spheres of a zone."""
    count = sum(map(len, rows))
    position = np.concatenate([np.empty((0, 3)), *(each["position"] for each in rows)])
    columns = [
        np.concatenate([np.empty(0, ROW[name]), *(each[name] for each in rows)])
        for name in ("radius", "set_index", "batch_index")
    ]
    return Spheres(position, columns[0], columns[1], np.full(count, zone_index, np.int32), columns[2])
