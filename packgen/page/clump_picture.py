"""A still picture of a clump: its spheres in the mesh of the body; drawn in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.errors import PackgenError
from packgen.page.picture import TIME_MAX, why_nothing_drawn

SIZE = (1500, 750)  # pixels
VIEWS = ((1.0, -1.6, 0.7), (-1.3, 1.2, 0.9))  # from where the body is looked at
BODY, SPHERES = "#d0d0d0", "viridis"


def write_clump_picture(
    path: Path, spheres: Float64Array, vertices: Float64Array | None, faces: Int64Array | None
) -> None:
    """Draw a clump.

    Args:
        path: PNG file to write.
        spheres: Centres and radii [m], shape (N, 4).
        vertices: Corners of the body's mesh in the same frame [m], shape (V, 3); null: there is none.
        faces: Its facets, shape (F, 3); null: there is none.

    Raises:
        PackgenError: Nothing could be drawn.
    """
    try:
        with tempfile.TemporaryDirectory() as folder:
            data, drawn = Path(folder) / "clump.npz", Path(folder) / "clump.png"
            none = np.empty((0, 3))
            np.savez(
                data,
                spheres=spheres,
                vertices=none if vertices is None else vertices,
                faces=none.astype(np.int64) if faces is None else faces,
            )
            command = [sys.executable, "-m", "packgen.page.clump_picture", str(data), str(drawn)]
            run = subprocess.run(command, capture_output=True, text=True, timeout=TIME_MAX, check=False)
            if run.returncode != 0:
                raise PackgenError(f"no picture: {why_nothing_drawn(run)}")
            path.write_bytes(drawn.read_bytes())
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PackgenError(f"no picture: {error}") from error


def draw(data: Path, picture: Path) -> None:
    """Draw what `write_clump_picture` has laid down."""
    import pyvista

    with np.load(data) as stored:
        spheres, vertices, faces = stored["spheres"], stored["vertices"], stored["faces"]
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(SIZE), shape=(1, 2), border=False)
    for side, view in enumerate(VIEWS):
        plotter.subplot(0, side)
        plotter.set_background("white")
        cloud = pyvista.PolyData(spheres[:, :3])
        cloud["diameter"], cloud["radius [m]"] = 2.0 * spheres[:, 3], spheres[:, 3]
        ball = pyvista.Icosphere(radius=0.5, nsub=4 if len(spheres) <= 200 else 3)
        bar = {
            "color": "black",
            "fmt": "%.2g",
            "n_labels": 3,
            "width": 0.5,
            "position_x": 0.25,
            "position_y": 0.01,
        }
        shown = cloud.glyph(geom=ball, scale="diameter", orient=False)
        looks = {
            "scalars": "radius [m]",
            "cmap": SPHERES,
            "smooth_shading": True,
            "show_scalar_bar": side == 1,
        }
        plotter.add_mesh(shown, scalar_bar_args=bar, **looks)
        if len(faces):
            mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
            plotter.add_mesh(mesh, color=BODY, opacity=0.25)
        plotter.enable_parallel_projection()
        plotter.view_vector(view, viewup=(0.0, 0.0, 1.0))
        plotter.camera.zoom(1.15)
    plotter.screenshot(picture)
    plotter.close()


if __name__ == "__main__":
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        # Else VTK tries X first, in vain, and warns.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    draw(*map(Path, sys.argv[1:]))
