"""VTK's files of points (vtp, vtu, vtk), as packgen, LIGGGHTS and ParaView write them.

Arrays of the points: ``radius`` or ``diameter``, and where there are any ``id``, ``set``, ``type``,
``density``, ``zone``, ``batch``, in capitals or not.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.filefaults import Faults, fault
from packgen.leftovers import SCRATCH, owner
from packgen.reading import vtk_points
from packgen.reading.rows import NUMBER, RULES, SIZE, WHOLE
from packgen.reading.spheres import SphereFile, from_columns

KIND = "VTK file"
WANTED = {"radius": SIZE, "diameter": SIZE, "density": SIZE} | dict.fromkeys(
    ("id", "set", "type", "zone", "batch", "body"), WHOLE
)


def read_vtk(path: Path) -> SphereFile:
    """Read a file of points.

    Raises:
        ReadError: VTK cannot read it, or it has no points or no radii.
    """
    with path.open("rb"):  # VTK itself is silent about files that it cannot open
        points, arrays = _load(path)
    if not len(points):
        raise fault(path, "no points", "one a sphere", remedy="is the file complete?")
    columns = {axis: points[:, index] for index, axis in enumerate("xyz")}
    for name, values in arrays.items():
        plain = name.lower()
        if plain in WANTED and values.shape == (len(points),) and values.dtype.kind in "iuf":
            columns[plain] = values.astype(np.float64)
    if not {"radius", "diameter"} & set(columns):
        there = ", ".join(arrays) or "none"
        raise fault(path, f"the arrays {there} of its points", "radius or diameter as well")
    if "radius" in columns:
        columns.pop("diameter", None)
    faults = Faults(path)
    for name, values in columns.items():
        rule = WANTED.get(name, NUMBER)
        for index in np.flatnonzero(~RULES[rule](values)).tolist():
            faults.add(f"{name} {values[index]:g}", rule, place=f"point {index}")
    faults.check()
    return from_columns(path, KIND, columns)


def _load(path: Path) -> tuple[Float64Array, dict[str, Any]]:
    """Return points (N, 3) and their arrays by name, read by a process of its own."""
    with tempfile.TemporaryDirectory(prefix=f"{SCRATCH}{owner()}-") as folder:
        target = Path(folder) / "points.npz"
        command = [sys.executable, "-P", vtk_points.__file__, str(path.resolve()), str(target)]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
        if done.returncode != 0 or not target.exists():
            raise fault(
                path, "what VTK cannot read as points", f"a whole file of the kind {path.suffix}",
                remedy="is it complete, and of the format that its ending says?",
            )  # fmt: skip
        with np.load(target) as stored:
            names = stored["names"].tolist()
            return stored["points"], {name: stored[f"array_{place}"] for place, name in enumerate(names)}
