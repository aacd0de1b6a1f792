"""What is known of a bed beside its spheres: by a scene, or by the provenance that packgen stored with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import EarlierBed, Material, ParticleSet
from packgen.geometry import Container
from packgen.geometry.scaling import scaled_container

if TYPE_CHECKING:
    from packgen.scene import Scene
    from packgen.scene.walls import WallSpec


@dataclass(frozen=True, eq=False, slots=True)
class Known:
    """What the spheres' file may not say.

    Attributes:
        source: Where it is from, for messages; empty: nothing is known.
        particle_sets: The sets.
        materials: The materials, in the order of the decks' types.
        wall_material: Name of the walls' material.
        container: The vessel.
        gravity: Acceleration of gravity [m/s2], shape (3,).
        tolerance: Largest overlap, as a fraction of the smaller radius.
        provenance: Scene, seed and settings.
    """

    source: str = ""
    particle_sets: tuple[ParticleSet, ...] = ()
    materials: tuple[Material, ...] = ()
    wall_material: str = ""
    container: Container | None = None
    gravity: Float64Array | None = None
    tolerance: float | None = None
    provenance: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))


def known_by_scene(scene: Scene, container: Container) -> Known:
    """Return what a scene and its container say."""
    return Known(
        source=f"the scene {scene.path.name}",
        particle_sets=tuple(
            ParticleSet(each.name, each.density, each.material) for each in scene.particle_sets
        ),
        materials=scene.materials,
        wall_material=scene.wall_material,
        container=container,
        gravity=np.asarray(scene.gravity_direction, np.float64) * scene.gravity + 0.0,
        tolerance=scene.tolerance,
        # Not the scene's seed and algorithm: they have not made these spheres.
        provenance={"scene": scene.path.name, "settings": scene.model_dump()},
    )


def known_by_provenance(provenance: Mapping[str, Any], *, meshes: bool = False) -> Known:
    """Return what ``bed.npz`` says of the run that made it; nothing where it has no settings of a scene.

    Walls are known where they were a primitive; the mesh of others is not in the file.

    Args:
        provenance: What it says.
        meshes: Whether to read the mesh of walls from its own file, where that is still there.
    """
    settings = provenance.get("settings")
    if not isinstance(settings, Mapping) or "particle_sets" not in settings:
        return Known()
    try:
        return _known_by_settings(provenance, settings, meshes=meshes)
    except (KeyError, TypeError, ValueError, AttributeError):  # of another version, or by somebody else
        return Known()


def set_names(provenance: Mapping[str, Any]) -> tuple[str, ...]:
    """Return what ``bed.npz`` calls its sets, by their indices; nothing where it does not say."""
    settings = provenance.get("settings")
    sets = settings.get("particle_sets") if isinstance(settings, Mapping) else None
    if not isinstance(sets, list | tuple):
        return ()
    names = [each.get("name") if isinstance(each, Mapping) else None for each in sets]
    found = tuple(each for each in names if isinstance(each, str))
    return found if len(found) == len(names) else ()


def earlier_by_provenance(provenance: Mapping[str, Any]) -> EarlierBed | None:
    """Return which spheres ``bed.npz`` says were there before the others; None where it says nothing."""
    told = provenance.get("start_from")
    if not isinstance(told, Mapping):
        return None
    first, tolerance = told.get("first_zone"), told.get("tolerance")
    sound = isinstance(first, int) and (tolerance is None or isinstance(tolerance, float))
    return EarlierBed(first, tolerance) if sound and isinstance(first, int) else None


def _known_by_settings(provenance: Mapping[str, Any], settings: Mapping[str, Any], *, meshes: bool) -> Known:
    direction = np.asarray(settings["gravity_direction"], np.float64)
    container = _vessel(settings["container"], settings.get("walls", ()), direction, meshes=meshes)
    if container is not None:  # a jammed bed has given its vessel the size that it needs
        container = scaled_container(container, float(provenance.get("jamming", {}).get("factor", 1.0)))
    return Known(
        source="the file's provenance",
        particle_sets=tuple(
            ParticleSet(each["name"], float(each["density"]), each["material"])
            for each in settings["particle_sets"]
        ),
        materials=tuple(Material(**each) for each in settings["materials"]),
        wall_material=settings["wall_material"],
        container=container,
        gravity=direction * float(settings["gravity"]) + 0.0,
        tolerance=provenance.get("settled", {}).get("tolerance", settings["params"].get("tolerance", 1.0e-6)),
        provenance=provenance,
    )


def _vessel(
    settings: Mapping[str, Any], walls: Sequence[Mapping[str, Any]], direction: Float64Array, *, meshes: bool
) -> Container | None:
    mesh = settings.get("path") is not None
    if settings.get("cell") is not None:
        return None  # the spheres' file has its shape
    if (mesh or walls) and not meshes:
        return None
    from packgen.container.load import container_of
    from packgen.scene.models import ContainerSpec

    letters = [axis for axis, wraps in zip("xyz", settings.get("periodic", ()), strict=False) if wraps]
    other = {"periodic"} if mesh else {"units", "shape", "periodic"}
    spec = ContainerSpec.model_validate(
        {name: value for name, value in settings.items() if name not in other}
        | ({"periodic": letters} if letters else {})
    )
    if walls:
        from packgen.container.parts import container_with_parts

        parts = [_part(each) for each in walls]
        return container_with_parts(spec, parts, direction, lambda path: path, lambda _: None)
    return container_of(spec, direction, lambda path: path)


def _part(settings: Mapping[str, Any]) -> WallSpec:
    from packgen.scene.walls import WallSpec

    other = {"units"} if settings.get("path") is None else set()
    return WallSpec.model_validate({name: value for name, value in settings.items() if name not in other})
