"""Other programmes that fill the box of the table, where they are installed.

Each function gets the radii, the lengths of a box whose corner is the origin and a seed, and returns centres
(N, 3), radii (N,) and the lengths of the box that they are in, in metres. What it needs is imported, or
started, inside of it.
"""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array

Made = tuple[Float64Array, Float64Array, Float64Array]

YADE = """
import json
from yade import pack
asked = json.load(open("asked.json"))
radius = asked["radius"]
middle = 0.5 * (min(radius) + max(radius))
cloud = pack.SpherePack()
cloud.makeCloud((0, 0, 0), asked["extent"], rMean=middle, rRelFuzz=(max(radius) - middle) / middle,
    num=len(radius), seed=asked["seed"] + 1)
json.dump([[*centre, r] for centre, r in cloud], open("found.json", "w"))
"""


@dataclass(frozen=True, slots=True)
class Peer:
    """Another programme.

    Attributes:
        name: What the table calls it.
        may_change: What it changes of what is asked.
        make: Makes a bed.
        is_there: Whether it is installed.
    """

    name: str
    may_change: str
    make: Callable[[Float64Array, Float64Array, int], Made]
    is_there: bool


def spheropack(radius: Float64Array, extent: Float64Array, seed: int) -> Made:
    """Return the spheres of spheropack, an event-driven Lubachevsky-Stillinger: as dense as they jam.

    It multiplies all radii by one factor; they get their size back here, and the box changes with them.
    """
    import spheropack as peer

    found = peer.pack(
        radii=radius, container=peer.Box(tuple(extent), periodic=False), density="max", growth_rate=0.1,
        seed=seed,
    )  # fmt: skip
    factor = float(radius.sum() / np.asarray(found.radii).sum())
    return np.asarray(found.positions) * factor, np.asarray(found.radii) * factor, extent * factor


def yade_cloud(radius: Float64Array, extent: Float64Array, seed: int) -> Made:
    """Return a cloud of YADE's ``makeCloud``: random places without overlaps, sizes even over a span."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        asked = {"radius": radius.tolist(), "extent": extent.tolist(), "seed": seed}
        (place / "asked.json").write_text(json.dumps(asked))
        (place / "cloud.py").write_text(YADE)
        subprocess.run(["yade", "-n", "-x", "cloud.py"], cwd=place, capture_output=True, check=True)
        rows = np.array(json.loads((place / "found.json").read_text()))
    return rows[:, :3], rows[:, 3], extent


PEERS = (
    Peer(
        "spheropack", "container", spheropack,
        is_there=importlib.util.find_spec("spheropack") is not None,
    ),
    Peer("YADE makeCloud", "radii, count", yade_cloud, is_there=shutil.which("yade") is not None),
)  # fmt: skip
