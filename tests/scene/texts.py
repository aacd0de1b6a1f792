"""Scenes written as text, loaded or refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from packgen.errors import SceneError
from packgen.scene import Scene, load_scene

BOX = "container: {box: {min: [0, 0, 0], max: [2, 2, 2]}}\n"
SETS = "particle_sets:\n  - {radius_distribution: uniform, radius_min: 0.05, radius_max: 0.08}\n"


def load(folder: Path, text: str) -> Scene:
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    for name in ("cone.stl", "sphere.stl"):
        (folder / name).touch()
    return load_scene(path)


def problems(folder: Path, text: str) -> list[str]:
    """Return the faults without the folder."""
    with pytest.raises(SceneError) as caught:
        load(folder, text)
    return [each.replace(str(folder) + "/", "") for each in caught.value.problems]
