"""``bed.npz``: the spheres of a bed as plain arrays that any numpy reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int32Array
from packgen.bed import Bed
from packgen.bodies import Bodies, bodies_of_arrays, body_arrays

COLUMNS = ("position", "radius", "set_index", "zone_index", "batch_index")


def save_bed(bed: Bed, path: Path) -> None:
    """Write a bed's arrays; equal beds give equal files, byte for byte.

    Keys: ``position`` (N, 3) float64 [m]; ``radius`` (N,) float64 [m]; ``set_index``, ``zone_index``,
    ``batch_index`` (N,) int32; ``provenance``, JSON text; ``body_index`` (N,) int32, the body of each sphere,
    only where spheres belong together in bodies: without it each sphere is its own; ``cell`` (3, 3) float64
    [m], the vectors of a periodic cell of any shape as rows, from the origin, only where the bed is in one.
    Where shape and place of the bodies are known, with a row a body: ``body_position`` (M, 3) float64, the
    centre of mass [m]; ``body_orientation`` (M, 4) float64, a unit quaternion w, x, y, z; ``body_template``
    (M,) int32, the place in ``templates``, -1 of a single sphere; ``body_scale`` (M,) float64, the factor on
    the template's lengths, of a single sphere its radius [m]; ``templates``, JSON text: name, spheres (x, y,
    z, r about the centre of mass), volume, inertia and place of each.

    Args:
        bed: The bed.
        path: File to write.

    Raises:
        OSError: The file cannot be written.
    """
    arrays: dict[str, Any] = {
        "position": bed.position,
        "radius": bed.radius,
        "set_index": bed.set_index,
        "zone_index": bed.zone_index,
        "batch_index": bed.batch_index,
        "provenance": np.array(json.dumps(plain(bed.provenance), sort_keys=True)),
    }
    if bed.body_index is not None:
        arrays["body_index"] = bed.body_index
    if bed.container.cell is not None:
        arrays["cell"] = bed.container.cell
    if bed.bodies is not None:
        arrays |= body_arrays(bed.bodies)
    np.savez(path, **arrays)


@dataclass(frozen=True, eq=False, slots=True)
class Columns:
    """The columns of a ``bed.npz``.

    Attributes:
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        set_index: Particle set of each sphere, shape (N,), int32.
        zone_index: Zone of each sphere, shape (N,), int32.
        batch_index: Batch of each sphere, shape (N,), int32.
        body_index: Body of each sphere, shape (N,), int32; None: each sphere is a body.
        cell: Vectors of a periodic cell of any shape as rows [m], shape (3, 3); None: the bed is in none.
        bodies: Shape, place and orientation of each body; None: not known.
    """

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    zone_index: Int32Array
    batch_index: Int32Array
    body_index: Int32Array | None = None
    cell: Float64Array | None = None
    bodies: Bodies | None = field(default=None, kw_only=True)


def load_columns(path: Path) -> Columns:
    """Read the columns of a ``bed.npz``.

    Args:
        path: The file.

    Raises:
        OSError: The file cannot be read.
        KeyError: A column is missing.
        ValueError: The file is not one of numpy's.
        EOFError: The file ends too early.
    """
    with np.load(path) as stored:
        columns = {name: stored[name] for name in COLUMNS}
        return Columns(
            **columns,
            body_index=stored.get("body_index"),
            cell=stored.get("cell"),
            bodies=bodies_of_arrays(stored),
        )


def plain(value: Any) -> Any:
    """Return settings as JSON holds them: dicts, lists, strings, numbers; paths become text."""
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(each) for each in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)
