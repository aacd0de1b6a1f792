"""``bed.npz``, as packgen writes it, or any archive of numpy with ``position`` and ``radius``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int32Array
from packgen.bodies import Bodies, bodies_of_arrays, has_members
from packgen.filefaults import Faults, fault
from packgen.reading.known import set_names
from packgen.reading.rows import NUMBER, RULES, SIZE, WHOLE
from packgen.reading.spheres import Cell, Groups, SphereFile
from packgen.reading.tilted import cell_of

INDICES = ("set_index", "zone_index", "batch_index", "body_index")
REMEDY = "is the file complete?"


def read_npz(path: Path) -> SphereFile:
    """Read an archive of numpy.

    Raises:
        ReadError: It is none, or an array is missing, of another shape, or holds what no bed does.
        OSError: The file cannot be read.
    """
    arrays = _load(path)
    faults = Faults(path)
    missing = [name for name in ("position", "radius") if name not in arrays]
    if missing:
        there = ", ".join(arrays) or "nothing"
        raise fault(path, f"the arrays {there}", f"{' and '.join(missing)} as well")
    count = len(np.atleast_1d(arrays["radius"]))
    for name in ("position", "radius", *INDICES):
        if name in arrays:
            shape = (count, 3) if name == "position" else (count,)
            _check(faults, name, arrays[name], shape)
    if "cell" in arrays:
        _check(faults, "cell", arrays["cell"], (3, 3))
    faults.check()
    if count == 0:
        raise fault(path, "no spheres", "at least one")
    index = {name: arrays[name].astype(np.int32, copy=False) for name in INDICES if name in arrays}
    provenance = _provenance(arrays.get("provenance"))
    bodies = _bodies(path, arrays, index.get("body_index"))
    return SphereFile(
        path,
        "numpy archive",
        np.ascontiguousarray(arrays["position"], np.float64),
        np.ascontiguousarray(arrays["radius"], np.float64),
        groups=_groups(index.get("set_index"), set_names(provenance)),
        zone_index=index.get("zone_index"),
        batch_index=index.get("batch_index"),
        body_index=index.get("body_index"),
        cell=_cell(path, arrays.get("cell")),
        bodies=bodies,
        provenance=provenance,
    )


def _cell(path: Path, stored: Any) -> Cell | None:
    """Return the periodic cell of any shape that is stored; None: there is none.

    Raises:
        ReadError: Its vectors do not lie as they have to.
    """
    if stored is None:
        return None
    vectors = np.ascontiguousarray(stored, np.float64)
    if (vectors != np.tril(vectors)).any() or not (np.diag(vectors) > 0.0).all():
        raise fault(path, f"the cell {vectors.tolist()}", "a lower triangle, positive along its diagonal")
    return cell_of(vectors)


def _groups(index: Int32Array | None, names: tuple[str, ...]) -> Groups | None:
    """Return the sets of spheres, with their names where all of them have one."""
    if index is None:
        return None
    return Groups(index.astype(np.int64), "set", names if index.max() < len(names) else ())


def _bodies(path: Path, arrays: Mapping[str, Any], body_index: Int32Array | None) -> Bodies | None:
    """Return the bodies that are stored, whose rows are the numbers of ``body_index``.

    Raises:
        ReadError: They are not sound, or not those of the spheres.
    """
    try:
        bodies = bodies_of_arrays(arrays)
    except ValueError as error:
        raise fault(path, str(error), "bodies as packgen stores them", remedy=REMEDY) from error
    if bodies is None:
        return None
    if body_index is None or not has_members(bodies, body_index):
        raise fault(path, f"{len(bodies)} bodies that are not those of body_index", "a row a body")
    return bodies


def _load(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file, np.load(file) as stored:
            return {name: stored[name] for name in stored.files}
    except OSError:
        raise
    except Exception as error:  # zip, zlib, numpy and pickle have errors of their own
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise fault(path, f"no archive of numpy ({reason})", "a bed.npz", remedy=REMEDY) from error


def _check(faults: Faults, name: str, values: Any, shape: tuple[int, ...]) -> None:
    """Note an array of another shape or kind, or each of its values that no bed has."""
    whole = name in INDICES
    if values.shape != shape:
        faults.add(f"shape {values.shape}", str(shape), place=name)
        return
    if values.dtype.kind not in ("iu" if whole else "iuf"):
        faults.add(f"numbers of type {values.dtype}", "int32" if whole else "float64", place=name)
        return
    rule = SIZE if name == "radius" else WHOLE if whole else NUMBER
    flat: Float64Array = values if values.dtype == np.float64 else values.astype(np.float64)
    sound = RULES[rule](flat)
    if whole:
        sound &= (values >= 0) & (values < 2**31)
        rule = f"{WHOLE} from 0 on"
    for place in np.argwhere(~sound).tolist():
        faults.add(f"{values[tuple(place)]}", rule, place=f"{name}[{', '.join(map(str, place))}]")


def _provenance(stored: Any) -> Mapping[str, Any]:
    """Return the provenance that is stored as JSON text; nothing where there is none of that form."""
    try:
        found = json.loads(str(stored)) if stored is not None else {}
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
