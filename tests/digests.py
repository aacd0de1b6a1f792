"""Twelve scenes and the digests of their beds: ``python -m tests.digests`` prints, ``--write`` keeps them.

A bed's digest is that of its bytes: positions, radii, sets, zones and batches. A change that is to leave beds
as they are leaves the digests as they are, on every machine.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from packgen.bed import Bed
from tests.scenes import box, constant, run_scene, uniform

KEPT = Path(__file__).with_suffix(".json")

LOGNORMAL = {"radius_distribution": "lognormal", "radius_median": 0.03, "sigma": 0.4}
NORMAL = {"radius_distribution": "normal", "radius_mean": 0.03, "radius_std_dev": 0.006}
ROSIN_RAMMLER = {
    "radius_distribution": "rosin_rammler", "radius_63": 0.04, "exponent": 2.5,
    "radius_min": 0.02, "radius_max": 0.07,
}  # fmt: skip
SIEVE = {
    "radius_distribution": "sieve", "diameters": [0.04, 0.06, 0.09, 0.12], "passing": [0.0, 0.3, 0.7, 1.0],
}  # fmt: skip

# An L-shaped trough; its corners are exact numbers, so that its file reads alike everywhere.
TROUGH_PROFILE = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5), (0.5, 1.0), (0.0, 1.0))


def trough(folder: Path, depth: float = 0.5) -> dict[str, Any]:
    """Write the trough as an OFF file, not convex, and return it as a container."""
    corners = [(x, y, z) for y in (0.0, depth) for x, z in TROUGH_PROFILE]
    count = len(TROUGH_PROFILE)
    near = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    far = [(a + count, c + count, b + count) for a, b, c in near]
    sides = [((k + 1) % count, k, k + count) for k in range(count)]
    sides += [((k + 1) % count, k + count, (k + 1) % count + count) for k in range(count)]
    faces = [*near, *far, *sides]
    lines = ["OFF", f"{len(corners)} {len(faces)} 0"]
    lines += [" ".join(map(repr, corner)) for corner in corners]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces]
    (folder / "trough.off").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return {"path": "trough.off"}


def _mesh(folder: Path) -> Bed:
    return run_scene(folder, trough(folder), uniform(0.025, 0.04)).bed


SCENES: dict[str, Callable[[Path], Bed]] = {
    "column": lambda at: run_scene(at, box([0, 0, 0], [1, 1, 1]), constant(0.03)).bed,
    "adam": lambda at: (
        run_scene(
            at,
            box([0, 0, 0], [0.8, 0.8, 1]),
            constant(0.1),
            params={"optimizer": "adam", "n_epoch": 100},
            zones=[{"n_particles": 60}],
        ).bed
    ),
    "periodic": lambda at: (
        run_scene(at, {**box([0, 0, 0], [0.8, 0.8, 0.8]), "periodic": ["x", "y"]}, LOGNORMAL).bed
    ),
    "endless": lambda at: (
        run_scene(at, {**box([0, 0, 0], [0.6, 0.6, 0.6]), "periodic": ["x", "y", "z"]}, NORMAL).bed
    ),
    "mesh": _mesh,
    "broad": lambda at: (
        run_scene(
            at,
            {"cylinder": {"radius": 0.3, "height": 1.0}},
            [constant(0.06), constant(0.012)],
            zones=[{"n_particles": 3000, "set_proportions": [0.02, 0.98]}],
        ).bed
    ),
    "zones": lambda at: (
        run_scene(
            at,
            {"cone": {"radius_bottom": 0.1, "radius_top": 0.6, "height": 1.2}},
            [constant(0.04), uniform(0.02, 0.035)],
            zones=[
                {"n_particles": 300, "set_proportions": [1.0, 0.0]},
                {"n_particles": 800, "set_proportions": [0.2, 0.8]},
            ],
        ).bed
    ),
    "tilted": lambda at: (
        run_scene(
            at,
            {"cylinder": {"radius": 0.4, "height": 1.0}},
            ROSIN_RAMMLER,
            gravity_axis=[0.3, -0.2, -1.0],
            zones=[{"mass": 300.0}],
        ).bed
    ),
    "sphere": lambda at: (
        run_scene(at, {"sphere": {"radius": 0.5}}, SIEVE, gravity_axis="-x", zones=[{"volume": 0.2}]).bed
    ),
    "smooth": lambda at: (
        run_scene(
            at,
            {"cylinder": {"radius": 0.25, "height": 0.8, "axis": "y"}},
            {**NORMAL, "material": "glass"},
            gravity_axis="y",
            materials={"glass": {"friction": 0.2}},
            params={"batch_size": 150},
            seed=7,
        ).bed
    ),
    "dispersed": lambda at: (
        run_scene(
            at,
            {**box([0, 0, 0], [0.8, 0.8, 0.8]), "periodic": ["x", "y"]},
            LOGNORMAL | {"radius_min": 0.02, "radius_max": 0.07},
            algorithm="DISPERSED",
            zones=[{"solid_fraction": 0.4, "gap": 0.05}],
        ).bed
    ),
    "jammed": lambda at: (
        run_scene(
            at,
            {**box([0, 0, 0], [0.8, 0.8, 0.8]), "periodic": ["x", "y"]},
            LOGNORMAL | {"radius_min": 0.02, "radius_max": 0.07},
            algorithm="JAMMED",
            params={"certificate": False, "swap": True},
            zones=[{"n_particles": 1000}],
        ).bed
    ),
    "tiles": lambda at: (
        run_scene(
            at,
            {"cylinder": {"radius": 1.6, "height": 0.6}},
            uniform(0.02, 0.035),
            params={"tile": 20},
            zones=[{"n_particles": 8000}],
        ).bed
    ),
}


def digest(bed: Bed) -> str:
    """Return the digest of a bed's spheres."""
    total = hashlib.sha256()
    for array in (bed.position, bed.radius, bed.set_index, bed.zone_index, bed.batch_index):
        total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()[:16]


def digest_of(name: str) -> str:
    """Pack one of the scenes and return the digest of its bed."""
    with tempfile.TemporaryDirectory() as folder:
        return digest(SCENES[name](Path(folder)))


def main(arguments: list[str]) -> None:
    """Print the digests of the scenes named, or of all; with ``--write`` keep them."""
    names = [each for each in arguments if each != "--write"] or list(SCENES)
    found = {name: digest_of(name) for name in names}
    print(json.dumps(found, indent=2))
    if "--write" in arguments:
        KEPT.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
