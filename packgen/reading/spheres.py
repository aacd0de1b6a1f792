"""What a file says of spheres: positions and radii, and as much more as it knows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bodies import Bodies
from packgen.filefaults import Faults, fault

INT32_MAX = 2**31 - 1


@dataclass(frozen=True, eq=False, slots=True)
class Cell:
    """A box that wraps around, or a periodic cell of any shape.

    Attributes:
        bounds: Lower and upper corner [m], shape (2, 3).
        periodic: Along which axes it wraps around.
        vectors: Vectors of the cell as rows [m], from the origin, shape (3, 3); None: it is a box.
    """

    bounds: Float64Array
    periodic: tuple[bool, bool, bool]
    vectors: Float64Array | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Groups:
    """Which spheres belong together.

    Attributes:
        number: Number of each sphere's group, shape (N,), int64.
        kind: What the number is: ``set``, index of a particle set; ``type``, a solver's type, from 1;
            ``name``, place in ``names``.
        names: Names by number; empty where the file has none.
    """

    number: Int64Array
    kind: str
    names: tuple[str, ...] = ()

    def label(self, number: int) -> str:
        """Return what a group is called."""
        return self.names[number] if self.names else f"{self.kind}_{number}"


@dataclass(frozen=True, eq=False, slots=True)
class SphereFile:
    """The spheres of a file; lengths in metres. What the file does not say is None.

    Attributes:
        path: The file.
        format: What it is, in words.
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        id: What the file calls each sphere, shape (N,), int64; None: it stands on its place, from 0.
        groups: Sets or types.
        density: Density of each sphere [kg/m3], shape (N,), float64.
        zone_index: Zone of each sphere, shape (N,), int32.
        batch_index: Batch of each sphere, shape (N,), int32.
        body_index: Body of each sphere, shape (N,), int32.
        bodies: Shape, place and orientation of each body, by ``body_index``.
        cell: The box that wraps around, where one does.
        digits: How many digits the positions have, at most.
        provenance: Version, scene, seed and settings of a bed that packgen made.
    """

    path: Path
    format: str
    position: Float64Array
    radius: Float64Array
    id: Int64Array | None = None
    groups: Groups | None = None
    density: Float64Array | None = None
    zone_index: Int32Array | None = None
    batch_index: Int32Array | None = None
    body_index: Int32Array | None = None
    bodies: Bodies | None = None
    cell: Cell | None = None
    digits: int | None = None
    provenance: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def count(self) -> int:
        """Number of spheres."""
        return len(self.radius)

    def scaled(self, scale: float) -> SphereFile:
        """Return the spheres of a file whose unit of length is ``scale`` metres."""
        if scale == 1.0:
            return self
        cell = self.cell
        if cell is not None:
            vectors = None if cell.vectors is None else scale * cell.vectors
            cell = Cell(scale * cell.bounds, cell.periodic, vectors)
        bodies = None if self.bodies is None else self.bodies.scaled(scale)
        position, radius = scale * self.position, scale * self.radius
        return replace(self, position=position, radius=radius, bodies=bodies, cell=cell)


def from_columns(path: Path, kind: str, columns: Mapping[str, Float64Array], **known: Any) -> SphereFile:
    """Return the spheres of columns that have been read.

    Args:
        path: The file.
        kind: What it is, in words.
        columns: ``x``, ``y``, ``z``; ``radius`` or ``diameter``; and what else there is of ``id``, ``set``,
            ``type``, ``density``, ``zone``, ``batch``, ``body``; each of shape (N,), float64.
        known: More attributes of `SphereFile`.

    Returns:
        The spheres, in the order of their ids where there are any.

    Raises:
        ReadError: An id comes twice, or a number is too large.
    """
    columns = dict(columns)
    ids = columns["id"].astype(np.int64) if "id" in columns else None
    if ids is not None and (ids[1:] <= ids[:-1]).any():
        order = np.argsort(ids, kind="stable")
        columns = {name: values[order] for name, values in columns.items()}
        groups = known.get("groups")
        if groups is not None:
            known["groups"] = replace(groups, number=groups.number[order])
        ids = ids[order]
        _refuse_twice(path, ids)
    radius = columns["radius"] if "radius" in columns else columns["diameter"] / 2.0
    for name in ("set", "type"):
        if name in columns and "groups" not in known:
            known["groups"] = Groups(columns[name].astype(np.int64), name)
    for name in ("zone", "batch", "body"):
        if name in columns:
            known[f"{name}_index"] = _int32(path, name, columns[name])
    position = np.stack([columns[axis] for axis in "xyz"], axis=1)
    return SphereFile(path, kind, position, radius, id=ids, density=columns.get("density"), **known)


def _refuse_twice(path: Path, ids: Int64Array) -> None:
    twice = np.flatnonzero(ids[1:] == ids[:-1])
    faults = Faults(path)
    for value in np.unique(ids[twice]).tolist():
        faults.add(f"id {value} more than once", "each sphere once")
    faults.check()


def _int32(path: Path, name: str, values: Float64Array) -> Int32Array:
    if len(values) and not (values.min() >= 0 and values.max() <= INT32_MAX):
        raise fault(path, f"{name} numbers from {values.min():g} to {values.max():g}", f"0 to {INT32_MAX}")
    return values.astype(np.int32)
