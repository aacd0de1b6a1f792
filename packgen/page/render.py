"""Draws the pictures of a bed: ``python -m packgen.page.render bed.npz whole.png half.png``."""

from __future__ import annotations

import json
import math
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.page.spheres import (
    Spheres,
    depth_of_bodies,
    near_the_outside,
    read_spheres,
    upright_frame,
)

HEIGHT_MAX, WIDTH_MAX, SIZE_MIN = 1400, 1600, 700  # pixels
ELEVATION = math.radians(12.0)  # of the camera
BEHIND = 10.0  # largest radii behind the cut that are seen through its gaps
TRIANGLES_MAX = 4_000_000  # of all spheres together: about 0.5 GB
KINDS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442", "#777777")


def draw(spheres: Spheres, names: list[str], picture: Path, *, half: bool) -> None:
    """Draw a bed at true size, seen from the front and a little from above.

    Args:
        spheres: The spheres.
        names: Names of the particle sets; spheres are coloured by set where there are several, else by
            radius, equal spheres by batch, and bodies of several spheres by body. Those of one set that are
            equal and came at once have one colour.
        picture: PNG file to write.
        half: Whether the particles with centres in front of the bed's middle are left out, clumps as wholes.
    """
    import pyvista

    position = spheres.position @ upright_frame(spheres.up).T
    radius = spheres.radius
    low, high = -np.ones(3), np.ones(3)
    if len(radius):
        low = (position - radius[:, None]).min(axis=0)
        high = (position + radius[:, None]).max(axis=0)
    extent, position = high - low, position - 0.5 * (low + high)
    seen = _seen(position, radius, depth_of_bodies(position, spheres.body_index), half=half)
    # What the picture plane holds: the bed's height and, seen from above, its depth.
    tall = extent[2] * math.cos(ELEVATION) + extent[1] * math.sin(ELEVATION)
    wide = 1.35 * extent[0]  # with room for the legend
    scale = min(HEIGHT_MAX / (1.06 * tall), WIDTH_MAX / wide)
    size = [max(round(scale * wide), SIZE_MIN), max(round(scale * 1.06 * tall), SIZE_MIN)]
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    if len(seen):
        _add_spheres(plotter, spheres, names, position, seen)
    plotter.enable_parallel_projection()
    away = 3.0 * float(np.linalg.norm(extent))
    plotter.camera.position = (0.0, -away * math.cos(ELEVATION), away * math.sin(ELEVATION))
    plotter.camera.focal_point = (0.0, 0.0, 0.0)
    plotter.camera.up = (0.0, 0.0, 1.0)
    plotter.camera.parallel_scale = 0.5 * size[1] / scale
    plotter.camera.clipping_range = (0.01 * away, 3.0 * away)
    plotter.screenshot(picture)
    plotter.close()


def _seen(position: Float64Array, radius: Float64Array, depth: Float64Array, *, half: bool) -> np.ndarray:
    """Return the spheres that may be seen, as indices; deeper ones would cost time and never show."""
    outer = np.zeros(len(radius), dtype=bool)
    outer[near_the_outside(position, radius, cells=2)] = True
    if not half:
        return np.flatnonzero(outer)
    near_cut = depth < BEHIND * radius.max(initial=0.0) + np.max(np.abs(depth - position[:, 1]), initial=0.0)
    return np.flatnonzero((depth >= 0.0) & (outer | near_cut))


def _add_spheres(
    plotter: Any, spheres: Spheres, names: list[str], position: Float64Array, seen: np.ndarray
) -> None:
    """Add the seen spheres to a scene, with a legend of their colours."""
    import pyvista

    cloud = pyvista.PolyData(position[seen])
    cloud["diameter"] = 2.0 * spheres.radius[seen]
    facets = int(np.clip(math.sqrt(TRIANGLES_MAX / (2.0 * len(seen))), 8, 32))
    ball = pyvista.Sphere(radius=0.5, theta_resolution=facets, phi_resolution=facets)
    bar = {"color": "black", "vertical": True, "position_x": 0.85, "position_y": 0.25, "height": 0.5}
    kinds = np.unique(spheres.set_index)
    looks: dict[str, Any]
    one_size = np.ptp(spheres.radius) <= 1e-9 * spheres.radius.max()
    if len(kinds) == 1 and spheres.body_index is not None:
        cloud["colour"] = _rgb(np.unique(spheres.body_index, return_inverse=True)[1][seen])
        looks = {"scalars": "colour", "rgb": True}
    elif len(kinds) > 1 or (one_size and np.ptp(spheres.batch_index) == 0):
        cloud["colour"] = _rgb(spheres.set_index[seen])
        looks = {"scalars": "colour", "rgb": True}
        for line, each in enumerate(reversed(kinds)):  # VTK's own legend cuts long names off
            name = names[each] if each < len(names) else f"set {each}"
            place = (0.015, 0.01 + 0.025 * line)
            plotter.add_text(
                name, position=place, viewport=True, font_size=14, color=KINDS[each % len(KINDS)]
            )
    else:
        title = "batch" if one_size else "radius [m]"
        values = spheres.batch_index if one_size else spheres.radius
        cloud[title] = values[seen].astype(np.float64)
        bar |= {"fmt": "%.0f" if one_size else "%.3g"}
        looks = {
            "scalars": title,
            "cmap": "viridis",
            "clim": [values.min(), values.max()],
            "scalar_bar_args": bar,
        }
    shown = cloud.glyph(geom=ball, scale="diameter", orient=False)
    plotter.add_mesh(shown, smooth_shading=True, **looks)


def _rgb(kind: np.ndarray) -> np.ndarray:
    """Return the colours of kinds, (N, 3), uint8."""
    table = np.array([[int(colour[at : at + 2], 16) for at in (1, 3, 5)] for colour in KINDS], dtype=np.uint8)
    colours: np.ndarray = table[kind % len(KINDS)]
    return colours


def main(arguments: list[str]) -> None:
    """Draw both pictures of a ``bed.npz``."""
    bed, whole, half = map(Path, arguments)
    with np.load(bed) as stored:
        settings = json.loads(str(stored["provenance"])).get("settings", {})
    spheres = read_spheres(bed, settings.get("gravity_direction"))
    names = [each["name"] for each in settings.get("particle_sets", [])]
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        # Else VTK tries X first, in vain, and warns.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    draw(spheres, names, whole, half=False)
    draw(spheres, names, half, half=True)


if __name__ == "__main__":
    main(sys.argv[1:])
