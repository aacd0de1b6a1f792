"""Scenes and beds of the benchmarks: columns on a square base, from mappings as a scene file has them."""

from __future__ import annotations

import json
import math
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed, ParticleSet
from packgen.container import load_container
from packgen.filling.pack import pack
from packgen.geometry import Container
from packgen.scene import Scene, load_scene

WIDTH = 2.0  # m, the paper's column
RADIUS = 0.03  # m, its spheres
YOUNGS_MODULUS = 1.0e8  # Pa; softer beds compress by percents and hide their overlaps
DENSITY = 2500.0  # kg/m3
FRICTION = 0.5
LOOSEST = 0.5  # solid fraction that any bed reaches: what the height of a column is chosen by


def sphere_volume(radius: float) -> float:
    """Return the volume [m3] of a sphere of some radius [m]."""
    return 4.0 / 3.0 * math.pi * radius**3


def column_height(spheres: int, *, width: float, radius: float, fraction: float) -> float:
    """Return the height [m] of a column on a square base that equal spheres fill to a solid fraction."""
    return spheres * sphere_volume(radius) / (fraction * width**2)


def column_document(
    spheres: int,
    *,
    seed: int,
    params: dict[str, Any] | None = None,
    width: float = WIDTH,
    radius: float = RADIUS,
    sizes: dict[str, Any] | None = None,
    friction: float = FRICTION,
) -> dict[str, Any]:
    """Return a scene, as its file would say it: a number of spheres in a column higher than they need.

    Args:
        spheres: How many.
        seed: The scene's seed.
        params: The scene's ``params``.
        width: Side of the square base [m].
        radius: Radius of a sphere of mean volume [m]; chooses the height.
        sizes: Keys of the particle set; None: equal spheres of ``radius``.
        friction: Coefficient of friction.
    """
    height = column_height(spheres, width=width, radius=radius, fraction=LOOSEST) + 12.0 * radius
    return {
        "container": {"box": {"min": [0, 0, 0], "max": [width, width, height]}},
        "seed": seed,
        "params": params or {},
        "particle_sets": [
            {"density": DENSITY, **(sizes or {"radius_distribution": "constant", "radius": radius})}
        ],
        "materials": {"ore": {"youngs_modulus": YOUNGS_MODULUS, "friction": friction}},
        "zones": [{"n_particles": spheres, "set_proportions": [1.0]}],
    }


def read_scene(document: dict[str, Any]) -> tuple[Scene, Container]:
    """Return the scene that a mapping describes, through the reader of scene files, and its container."""
    with tempfile.TemporaryDirectory(prefix="packgen_") as folder:
        path = Path(folder) / "benchmark.yaml"
        path.write_text(json.dumps(document), encoding="utf-8")  # JSON is YAML
        scene = load_scene(path)
    return scene, load_container(scene)


def arrange(document: dict[str, Any], *, threads: int | None = None) -> tuple[Bed, float]:
    """Return the bed of a scene and the wall time [s] of its arrangement alone."""
    scene, container = read_scene(document)
    start = time.perf_counter()
    bed = pack(scene, container, threads=threads).bed
    return bed, time.perf_counter() - start


def bed_of(position: Float64Array, radius: Float64Array, *, width: float, height: float) -> Bed:
    """Return spheres that came from elsewhere as a bed, to be judged by the same code.

    Args:
        position: Centres [m], shape (N, 3).
        radius: Radii [m], shape (N,).
        width: Side of the column's square base [m].
        height: Height of the column [m].
    """
    document = column_document(1, seed=0, width=width, radius=float(radius.mean()))
    document["container"]["box"]["max"][2] = height
    scene, container = read_scene(document)
    nothing = np.zeros(len(radius), np.int32)
    sets = tuple(ParticleSet(each.name, each.density, each.material) for each in scene.particle_sets)
    gravity = np.asarray(scene.gravity_direction, float) * scene.gravity
    return Bed(
        position, radius, nothing, nothing, nothing, sets, scene.materials, scene.wall_material, container,
        gravity, None,
    )  # fmt: skip


def with_spheres(bed: Bed, position: Float64Array, radius: Float64Array) -> Bed:
    """Return a bed with other positions [m], shape (N, 3), and radii [m], shape (N,)."""
    return replace(bed, position=position, radius=radius, tolerance=None)
