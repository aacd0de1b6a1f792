"""Draw a bed cut in half, coloured by radius: ``python examples/picture.py furnace examples/furnace.png``."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pyvista

BACKGROUND, COLOURS = "white", "viridis"


def draw(folder: Path, picture: Path, width: int = 1000, height: int = 1400) -> None:
    """Draw the half of a bed that lies behind its middle, seen from the front.

    Args:
        folder: Result folder of packgen.
        picture: PNG file to write.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].
    """
    with np.load(folder / "bed.npz") as bed:
        position, radius = bed["position"], bed["radius"]
    depth = position[:, 1] - np.median(position[:, 1])
    top = position[:, 2] > np.quantile(position[:, 2], 0.88)  # seen from above
    seen = (depth >= 0.0) & ((depth < 8.0 * radius.max()) | top)  # the rest is hidden behind these
    cloud = pyvista.PolyData(position[seen])
    cloud["radius [m]"] = radius[seen]
    cloud["diameter"] = 2.0 * radius[seen]
    ball = pyvista.Sphere(radius=0.5, theta_resolution=16, phi_resolution=16)
    plotter = pyvista.Plotter(off_screen=True, window_size=[width, height])
    plotter.set_background(BACKGROUND)
    plotter.add_mesh(
        cloud.glyph(geom=ball, scale="diameter", orient=False),
        scalars="radius [m]",
        cmap=COLOURS,
        smooth_shading=True,
        scalar_bar_args={"color": "black", "vertical": True, "fmt": "%.3f"},
    )
    plotter.enable_parallel_projection()
    plotter.view_xz()
    plotter.camera.elevation = 12.0
    plotter.camera.zoom(1.3)
    plotter.screenshot(picture)
    plotter.close()


def main() -> None:
    """Read the command line and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="result folder of packgen")
    parser.add_argument("picture", type=Path, help="PNG file to write")
    options = parser.parse_args()
    draw(options.folder, options.picture)


if __name__ == "__main__":
    main()
