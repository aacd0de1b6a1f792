"""Still pictures of a bed, drawn by pyvista in a process of its own.

Without a display and without a software renderer VTK does not raise but ends its process, and a bed that took
hours must not end with it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from packgen.errors import PackgenError

PICTURES = ("bed.png", "bed_half.png")  # the whole bed; the half behind its middle
TIME_MAX = 600.0  # seconds


def write_pictures(folder: Path) -> tuple[Path, ...]:
    """Draw the bed of a result folder, whole and cut in half.

    Args:
        folder: Where ``bed.npz`` is and the pictures go.

    Returns:
        The pictures.

    Raises:
        PackgenError: Nothing could be drawn; the folder is as before.
    """
    partial = [folder / f".unfinished.{name}" for name in PICTURES]
    command = [sys.executable, "-m", "packgen.page.render", str(folder / "bed.npz"), *map(str, partial)]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=TIME_MAX, check=False)
        if run.returncode != 0:
            raise PackgenError(f"no pictures: {why_nothing_drawn(run)}")
        drawn = tuple(folder / name for name in PICTURES)
        for source, target in zip(partial, drawn, strict=True):
            os.replace(source, target)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PackgenError(f"no pictures: {error}") from error
    finally:
        for path in partial:
            path.unlink(missing_ok=True)
    return drawn


def why_nothing_drawn(run: subprocess.CompletedProcess[str]) -> str:
    """Return in words why the drawing process failed."""
    if run.returncode < 0:  # ended by a signal
        return (
            "VTK found nothing to draw with, neither a display nor EGL nor OSMesa; install one, "
            "on Debian: apt-get install libegl1 libgl1-mesa-dri"
        )
    lines = run.stderr.strip().splitlines()
    return lines[-1] if lines else f"the drawing process ended with code {run.returncode}"
