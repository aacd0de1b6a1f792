"""The sets and materials of a scene that goes on from a bed: those of that bed come first.

A set of the bed and one of the scene are one where they have the same name. Materials are the scene's where
it states them, else those of the file; none is made up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from packgen.bed import Bed, Material, ParticleSet
from packgen.distributions import Constant, Distribution, Uniform
from packgen.errors import SceneError
from packgen.scene import SetKeys
from packgen.values import PositiveLength

if TYPE_CHECKING:
    from packgen.scene import Scene, ZoneSpec

SAME_DENSITY = 1.0e-5  # relative: files have six digits


class EarlierSet(SetKeys):
    """A set that only the bed has: no sphere of it is drawn. Its least and largest radius [m] are told."""

    radius_distribution: Literal["earlier"] = "earlier"
    radius_min: PositiveLength
    radius_max: PositiveLength

    def _build(self) -> Distribution:
        if self.radius_min == self.radius_max:
            return Constant(self.radius_min)
        return Uniform(self.radius_min, self.radius_max)


def with_earlier_sets(scene: Scene, bed: Bed, warn: Callable[[str], None]) -> Scene:
    """Return a scene with the sets of a bed that it goes on from, first and in their order.

    Args:
        scene: The scene.
        bed: The bed; its sets have densities and materials.
        warn: Called with a line for each material that the scene states otherwise than the bed.

    Raises:
        SceneError: A set of the scene has the name of one of the bed's, and another density or material; a
            line each.
    """
    own = {each.name: each for each in scene.particle_sets}
    _refuse_other_sets(scene, bed.particle_sets)
    present = np.unique(bed.set_index).tolist()
    sets = tuple(
        own.get(each.name) or _earlier_set(each, bed, index)
        for index, each in enumerate(bed.particle_sets)
        if each.name in own or index in present
    )
    names = [each.name for each in sets]
    sets += tuple(each for each in scene.particle_sets if each.name not in names)
    used = {each.material for each in sets} | {scene.wall_material}
    materials = _materials(scene, bed, used, warn)
    zones = tuple(_reordered(zone, scene.particle_sets, sets) for zone in scene.zones)
    return replace(scene, particle_sets=sets, materials=materials, zones=zones)


def set_index_in(scene: Scene, bed: Bed) -> np.ndarray:
    """Return the set of each sphere of a bed among those of a scene, by name, shape (N,), int32."""
    names = [each.name for each in scene.particle_sets]
    place = [names.index(each.name) if each.name in names else -1 for each in bed.particle_sets]
    return np.array(place, np.int32)[bed.set_index]


def _refuse_other_sets(scene: Scene, earlier: Sequence[ParticleSet]) -> None:
    known, faults = {each.name: each for each in earlier}, []
    for index, each in enumerate(scene.particle_sets):
        other = known.get(each.name)
        if other is None:
            continue
        path = f"particle_sets[{index}]"
        if abs(other.density - each.density) > SAME_DENSITY * each.density:
            faults.append(
                f"{scene.named(path)}: found {each.name} with {each.density:g} kg/m3, expected "
                f"{other.density:g} as in start_from; give the new set a name of its own"
            )
        elif other.material != each.material:
            faults.append(
                f"{scene.named(path)}: found {each.name} of material {each.material}, expected "
                f"{other.material} as in start_from; give the new set a name of its own"
            )
    if faults:
        raise SceneError(faults)


def _earlier_set(each: ParticleSet, bed: Bed, index: int) -> EarlierSet:
    radius = bed.radius[bed.set_index == index]
    return EarlierSet(
        name=each.name, density=each.density, material=each.material,
        radius_min=float(radius.min()), radius_max=float(radius.max()),
    )  # fmt: skip


def _materials(scene: Scene, bed: Bed, used: set[str], warn: Callable[[str], None]) -> tuple[Material, ...]:
    """Return the materials, those of the bed that are used first."""
    of_scene, of_bed = ({each.name: each for each in group} for group in (scene.materials, bed.materials))
    chosen: dict[str, Material] = {}
    for name in [*of_bed, *of_scene]:
        if name in of_bed and (name not in used or not scene.marked.states(("materials", name))):
            if name in used:
                chosen[name] = of_bed[name]
            continue
        if name in of_bed and of_bed[name] != of_scene[name]:
            other = _differences(of_scene[name], of_bed[name])
            warn(f"{scene.named(f'materials.{name}')}: {other} in start_from; what the scene says counts")
        chosen[name] = of_scene[name]
    return tuple(chosen.values())


def _differences(one: Material, other: Material) -> str:
    names = [each.name for each in fields(Material)]
    pairs = [(name, getattr(one, name), getattr(other, name)) for name in names]
    return ", ".join(f"found {name} {mine:g}, {its:g}" for name, mine, its in pairs if mine != its)


def _reordered(zone: ZoneSpec, before: Sequence[SetKeys], after: Sequence[SetKeys]) -> ZoneSpec:
    share: Mapping[str, Any] = {
        each.name: part for each, part in zip(before, zone.set_proportions, strict=True)
    }
    return zone.model_copy(update={"set_proportions": tuple(share.get(each.name, 0.0) for each in after)})
