"""A scene before its first sphere is placed: what it asks for, what looks wrong, and the task it makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrange.crew import Alone, Crew
from packgen.arrange.registry import find
from packgen.arrange.spheres import no_spheres
from packgen.arrange.task import Algorithm, Listener, Setting, Task, ZoneTask, no_listener
from packgen.arrange.traits import traits_of
from packgen.container.load import load_container
from packgen.errors import PackingError
from packgen.filling.clumps import check_clumps, slenderness_of
from packgen.filling.compacted import Aim, aim_of, falls, friction_of
from packgen.filling.densities import Density, densities, gap_of
from packgen.filling.earlier import Earlier, earlier_bed
from packgen.filling.fit import check_beside, checked_locations
from packgen.filling.periods import check_periods
from packgen.filling.room import Locations
from packgen.filling.softness import check_softness
from packgen.filling.tiles import in_tiles
from packgen.geometry import Container, floor_direction
from packgen.portable import length
from packgen.scene.load import Scene, load_scene
from packgen.supply.supply import Supply


@dataclass(frozen=True, eq=False, slots=True)
class Prepared:
    """A scene before its first sphere is placed.

    Attributes:
        scene: The scene as it is packed.
        asked: The scene with the amounts that its densities ask for.
        wanted: The solid fraction that each zone asks for; None: none.
        aim: How dense its bed is to be under gravity; None: friction decides.
        algorithm: What packs it.
        setting: What all of its zones share.
        locations: What bounds each zone beside the container.
        earlier: The bed that it goes on from; None: it does not.
        crew: Who does the work.
        on_progress: Called after each batch.
        warnings: A line for each thing that looks wrong.
    """

    scene: Scene
    asked: Scene
    wanted: Sequence[Density | None]
    aim: Aim | None
    algorithm: Algorithm
    setting: Setting
    locations: Sequence[Locations]
    earlier: Earlier | None
    crew: Crew
    on_progress: Listener
    warnings: tuple[str, ...]

    def task(self, core_fraction: float | None = None, number: int = 0) -> Task:
        """Draw the spheres of all zones; each zone has randomness of its own.

        Args:
            core_fraction: See ``ZoneTask``.
            number: How many beds of this scene were packed before, none of them as dense as asked.

        Raises:
            PackingError: A periodic box is too short for the spheres.
        """
        scene = self.asked
        first, *of_supplies = np.random.SeedSequence(scene.seed).spawn(len(scene.zones) + 1)
        # The first zone goes on with the seed of the whole, so that a scene of one zone has one source.
        seeds = [first, *first.spawn(len(scene.zones) - 1)]
        before = no_spheres() if self.earlier is None else self.earlier.spheres
        loose_count = len(before) if self.earlier is not None and self.earlier.loose else 0
        forms = tuple(each.form for each in scene.particle_sets)
        forms = forms if any(form is not None for form in forms) else ()
        zones = []
        for index, zone in enumerate(scene.zones):
            supply = Supply(zone, scene.particle_sets, np.random.default_rng(of_supplies[index]))
            mark, friction = scene.mark(f"zones[{index}]"), friction_of(scene, zone)
            zones.append(
                ZoneTask(
                    index, mark, self.locations[index], supply, friction, seeds[index], self.setting,
                    gap_of(zone), core_fraction, loose_count, forms,
                )
            )  # fmt: skip
        widest = max(float(each.gap.half(np.array(each.supply.radius_max))) for each in zones)
        check_periods(self.scene, self.setting.container, slenderness_of(self.scene) * widest)
        tell = _of_try(self.on_progress, number)
        rng = np.random.default_rng(first)
        return Task(self.setting, tuple(zones), rng, tell, self.crew, earlier=before)


def prepared(
    scene: Scene | Path | str | Mapping[str, Any],
    container: Container | None,
    *,
    on_progress: Listener | None,
    threads: int | None,
    device: str,
    warn: Callable[[str], None],
    for_solver: bool,
    crew: Crew | None,
) -> Prepared:
    """Do all that comes before a scene's first sphere is placed; see ``packgen.filling.pack.pack``."""
    _check_device(device)
    warnings: list[str] = []

    def tell(line: str) -> None:
        warnings.append(line)
        warn(line)

    if isinstance(scene, Path | str | Mapping):
        scene = load_scene(scene)
    if container is None:
        container = load_container(scene, tell)
    scene = in_tiles(scene, shared=crew is not None)
    algorithm = find(traits_of(scene.params).instead or scene.algorithm).load()
    # A wrong unit makes spheres soft, too: it is told first.
    check_clumps(scene, container, device)
    locations = checked_locations(scene, container, tell)
    plain, aim = aim_of(scene, container, locations)
    earlier = earlier_bed(scene, container, tell)
    asked, wanted = densities(plain, container, locations)
    if earlier is not None:
        check_beside(scene, container, earlier.spheres.radius)
    for line in check_softness(scene, container, earlier, for_solver=for_solver):
        tell(line)
    if aim is not None and (falling := falls(aim, friction_of(scene, scene.zones[0]))) is not None:
        tell(falling)
    gravity = np.asarray(scene.gravity_direction, float)
    down = floor_direction(gravity, container.periodic)
    down = gravity / length(gravity) if down is None else down
    setting = Setting(container, down, scene.params, threads, device)
    if earlier is not None:
        asked, scene = earlier.joined(asked), earlier.scene
    return Prepared(
        scene, asked, wanted, aim, algorithm, setting, locations, earlier, crew or Alone(),
        on_progress or no_listener, tuple(warnings),
    )  # fmt: skip


def _of_try(listener: Listener, number: int) -> Listener:
    """Return a listener that hears which bed is packed, the first one being 0."""
    if number == 0:
        return listener
    return lambda progress: listener(replace(progress, stage=f"{progress.stage}, bed {number + 1}"))


def _check_device(device: str) -> None:
    if device in {"cpu", "torch"}:
        return
    import torch

    if not torch.cuda.is_available():
        raise PackingError(
            f"--device {device}: torch finds no such device; leave --device out to use the CPU"
        )
