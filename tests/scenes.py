"""Scenes written to a folder, packed as the command line does it, and judged by the independent check."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from packgen.check import check_bed
from packgen.container import load_container
from packgen.filling.pack import PackResult, pack
from packgen.geometry import Container
from packgen.scene import Scene, load_scene


def box(low: Any, high: Any) -> dict[str, Any]:
    return {"box": {"min": [float(each) for each in low], "max": [float(each) for each in high]}}


def constant(radius: float) -> dict[str, Any]:
    return {"radius_distribution": "constant", "radius": float(radius)}


def uniform(low: float, high: float) -> dict[str, Any]:
    return {"radius_distribution": "uniform", "radius_min": float(low), "radius_max": float(high)}


def read_scene(folder: Path, container: dict[str, Any], sets: Any, **keys: Any) -> tuple[Scene, Container]:
    """Write a scene file, and load it with its container."""
    sets = [sets] if isinstance(sets, dict) else sets
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump({"container": container, "particle_sets": sets} | keys), encoding="utf-8")
    scene = load_scene(path)
    return scene, load_container(scene)


def run_scene(
    folder: Path, container: dict[str, Any], sets: Any, *, threads: int | None = None, **keys: Any
) -> PackResult:
    """Pack a scene. The bed is within tolerance and no sphere is lost, or this raises."""
    scene, vessel = read_scene(folder, container, sets, **keys)
    result = pack(scene, vessel, threads=threads)
    assert_sound(result)
    return result


def assert_sound(result: PackResult) -> None:
    """Hold a bed against the independent check, and its zones against what they were asked for."""
    check = check_bed(result.bed)
    assert check.within_tolerance, check.faults()
    assert sum(zone.placed for zone in result.zones) == result.bed.count
    for zone in result.zones:
        assert zone.placed >= 0
        assert zone.left_over >= 0
        if zone.asked is not None:
            assert zone.placed + zone.left_over == zone.asked
