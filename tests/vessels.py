"""Vessels of plants, filled and let go in LIGGGHTS: ``python -m tests.vessels`` prints what each bed is like.

The core of a bed is what lies two diameters away from every wall and from the bed's top; it is compared with
the core of a cylinder that the same spheres fill.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from scipy.stats import qmc

from exporters import liggghts
from packgen.bed import Bed
from packgen.check import check_bed
from packgen.check.walls import shape_clearance
from packgen.measure.volumes import mean_diameter
from packgen.validation import Limits, validate
from tests import container_meshes as meshes
from tests.scenes import constant, run_scene

RADIUS = 0.04
SIZES: dict[str, dict[str, Any]] = {
    "constant": constant(RADIUS),
    "lognormal": {
        "radius_distribution": "lognormal", "radius_median": 0.037, "sigma": 0.25,
        "radius_min": 0.024, "radius_max": 0.067,
    },
}  # fmt: skip
REFERENCE = {"cylinder": {"radius": 0.5, "height": 1.6}}
CORE_MARGIN = 2.0  # mean diameters
POINTS = 2**16
NEAREST = 24
LIMITS = Limits(free_fall_times=3.0, work_budget=1.0e9)


def cyclone() -> trimesh.Trimesh:
    """A cyclone's body, open at its top, with the vortex finder as a sheet whose rims both lie in the bed."""
    body = [(0.0, 0.0), (0.2, 0.0), (0.5, 0.9), (0.5, 1.7)]
    angle = 2.0 * math.pi * np.arange(32) / 32
    rings = [np.column_stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), np.full(32, z)]) for z in (0.9, 1.4)]
    here, there = np.arange(32), (np.arange(32) + 1) % 32
    faces = [np.column_stack([here, there, there + 32]), np.column_stack([here, there + 32, here + 32])]
    finder = trimesh.Trimesh(np.concatenate(rings), np.concatenate(faces), process=False)
    return meshes.joined(meshes.revolved(body), finder)


def scaled(mesh: trimesh.Trimesh, factor: float) -> trimesh.Trimesh:
    mesh.apply_scale(factor)
    return mesh


VESSELS: dict[str, Callable[[], trimesh.Trimesh | dict[str, Any]]] = {
    "U-bend pipe": lambda: meshes.u_bend(open_top=True),
    "cyclone body": cyclone,
    "torus": meshes.torus,
    "hopper with insert": lambda: scaled(meshes.hopper(open_top=True), 0.6),
    "tank with baffles": lambda: scaled(meshes.tank(open_top=True), 0.6),
    "kiln along y": lambda: {"cylinder": {"radius": 0.5, "height": 2.5, "axis": "y"}},
}


@dataclass(frozen=True)
class Outcome:
    """What became of a vessel: see ``HEAD``."""

    facets: int
    spheres: int
    overlap: float
    wall_overlap: float
    outside: int
    core: float
    core_share: float
    lost: int
    force: float
    displacement: float


HEAD = (
    "vessel", "sizes", "facets", "spheres", "overlap / r", "in wall / r", "outside", "core",
    "less cylinder's", "core's share", "lost", "force / W", "displacement / r",
)  # fmt: skip


def bed_of(container: trimesh.Trimesh | dict[str, Any], sizes: str, **keys: Any) -> Bed:
    """The bed that fills a container; it is within tolerance, or this raises."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        if not isinstance(container, dict):
            container = {"path": meshes.saved(container, folder)}
        return run_scene(folder, container, SIZES[sizes], **keys).bed


def core_fraction(bed: Bed) -> tuple[float, float]:
    """Solid fraction of the core, by evenly spread points, and the core's share of the container."""
    margin = CORE_MARGIN * mean_diameter(bed.radius)
    low, high = bed.container.bounds
    points = low + (high - low) * qmc.Sobol(3, scramble=False).random(POINTS)
    top = np.quantile(bed.position[:, 2] + bed.radius, 0.97)
    points = points[points[:, 2] < top - margin]
    inside = shape_clearance(bed.container.shape, points, np.full(len(points), margin))
    points = points[inside >= margin * (1.0 - 1e-9)]
    distance, index = cKDTree(bed.position).query(points, k=NEAREST)
    solid = (distance < bed.radius[index]).any(axis=1)
    share = len(points) / POINTS * float(np.prod(high - low)) / bed.container.volume
    return float(solid.mean()), share


def outcome(name: str, sizes: str) -> Outcome:
    """Fill a vessel and let its bed go in LIGGGHTS."""
    keys = {"zones": [{"n_particles": 2500}]} if name == "kiln along y" else {}
    bed = bed_of(VESSELS[name](), sizes, **keys)
    check, (core, share) = check_bed(bed), core_fraction(bed)
    with tempfile.TemporaryDirectory() as scratch:
        liggghts.write(bed, Path(scratch), liggghts.Options())
        judged = validate(bed, Path(scratch), solver="liggghts", limits=LIMITS)
    run = judged.gravity_run
    return Outcome(
        len(bed.container.surface.faces), bed.count, check.overlap_max, check.wall_overlap_max,
        check.outside_count, core, share, len(run.lost), judged.step_zero.force_max, run.displacement_mean,
    )  # fmt: skip


def main() -> None:
    """Print a line a vessel."""
    print(*HEAD, sep=" | ", flush=True)
    for sizes in SIZES:
        reference, share = core_fraction(bed_of(REFERENCE, sizes))
        print(f"cylinder | {sizes} | core {reference:.4f}, {share:.2f} of it", flush=True)
        for name in VESSELS:
            if len(sys.argv) > 1 and name not in sys.argv[1:]:
                continue
            it = outcome(name, sizes)
            print(
                name, sizes, it.facets, it.spheres, f"{it.overlap:.1e}", f"{it.wall_overlap:.1e}", it.outside,
                f"{it.core:.4f}", f"{it.core - reference:+.4f}", f"{it.core_share:.2f}", it.lost,
                f"{it.force:.2g}", f"{it.displacement:.3f}", sep=" | ", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    main()
