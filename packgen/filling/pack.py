"""From a scene and its container to a bed: draws the radii, runs the algorithm, keeps the provenance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrange.crew import Alone, Crew
from packgen.arrange.registry import find
from packgen.arrange.spheres import Spheres, no_spheres
from packgen.arrange.task import Listener, Outcome, Setting, Task, ZoneTask, no_listener
from packgen.bed import Bed, ParticleSet
from packgen.container.load import load_container
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.filling.densities import Density, densities, gap_of
from packgen.filling.earlier import Earlier, earlier_bed
from packgen.filling.fit import checked_locations
from packgen.filling.periods import check_periods
from packgen.filling.remarks import remarks
from packgen.filling.room import Locations
from packgen.filling.softness import check_softness
from packgen.filling.tiles import in_tiles
from packgen.geometry import Container, Shape, Slice, floor_direction
from packgen.jamming import Jamming
from packgen.portable import cube, length
from packgen.scene.load import Scene, load_scene
from packgen.supply.fitting import SumFit
from packgen.supply.supply import Supply
from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.scene import ZoneSpec


@dataclass(frozen=True, slots=True)
class ZoneResult:
    """The outcome of a zone.

    Attributes:
        asked: Spheres asked for; None: until full.
        placed: Spheres placed.
        left_over: Spheres drawn but not placed.
        locations: What bounds the zone beside the container.
        counts: Spheres drawn of each set; None where ``asked`` is None.
        fit: How closely the spheres drawn add up to the volume or mass asked for; None: none was asked for.
        solid_fraction_asked: Solid fraction asked for, of all of the zone; None: none was.
        solid_fraction: The one reached; None: none was asked for.
    """

    asked: int | None
    placed: int
    left_over: int
    locations: tuple[Shape | Slice, ...] = ()
    counts: tuple[int, ...] | None = None
    fit: SumFit | None = None
    solid_fraction_asked: float | None = None
    solid_fraction: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class PackResult:
    """The bed, what became of each zone, a line for each thing that looks wrong, and how it is jammed."""

    bed: Bed
    zones: tuple[ZoneResult, ...]
    warnings: tuple[str, ...] = ()
    jamming: Jamming | None = None

    def _repr_html_(self) -> str:
        """Return verdict and page, which notebooks show."""
        from packgen.notebook import bed_html

        return bed_html(self.bed, self.zones, self.warnings, self.jamming)


def pack(
    scene: Scene | Path | str | Mapping[str, Any],
    container: Container | None = None,
    *,
    on_progress: Listener | None = None,
    threads: int | None = None,
    device: str = "cpu",
    warn: Callable[[str], None] = lambda _: None,
    for_solver: bool = False,
    crew: Crew | None = None,
) -> PackResult:
    """Fill the container as the scene says.

    Args:
        scene: The scene; or its file; or what that would say, as a mapping.
        container: Its container; None: the one that the scene names.
        on_progress: Called after each batch.
        threads: Threads to use; None: the algorithm's choice. The bed does not depend on it.
        device: ``cpu``, or ``cuda`` for the plain torch form of the loops.
        warn: Called before the first sphere is placed, with a line for each thing that looks wrong.
        for_solver: Whether a solver will get the bed: the Young's modulus that spheres have where the scene
            states none then counts as well, when their softness is judged.
        crew: Processes that share the work: the bed is then made in tiles. None: this one does all of it, and
            the bed has tiles only where the scene's ``params`` say so.

    Returns:
        The bed, the outcome of each zone, and what looks wrong: what ``warn`` was told, zones that nothing
        holds, and those whose sets or sums are not as asked for.

    Raises:
        PackingError: Nothing can be placed, or a location or an amount makes no sense.
        GeometryError: The container that the scene names cannot be read.
        SceneError: The scene says what none can; or the bed's weight would squeeze its spheres through each
            other, and it does not say ``allow_soft``.
    """
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
    algorithm = find(getattr(scene.params, "instead", None) or scene.algorithm).load()

    # A wrong unit makes spheres soft, too: it is told first.
    locations = checked_locations(scene, container, tell)
    earlier = earlier_bed(scene, container, tell)
    asked, wanted = densities(scene, container, locations)
    for line in check_softness(scene, container, for_solver=for_solver):
        tell(line)
    gravity = np.asarray(scene.gravity_direction, float)
    down = floor_direction(gravity, container.periodic)
    down = gravity / length(gravity) if down is None else down
    setting = Setting(container, down, scene.params, threads, device)
    if earlier is not None:
        asked, scene = earlier.joined(asked), earlier.scene
    task = _task(asked, setting, locations, on_progress or no_listener, crew or Alone(), earlier)
    zones = task.zones
    check_periods(
        scene, container, max(float(each.gap.half(np.array(each.supply.radius_max))) for each in zones)
    )
    made = algorithm(task)
    outcome = made if isinstance(made, Outcome) else Outcome(made, container)
    bed, results = _bed(scene, outcome, earlier), _results(outcome.spheres, zones, wanted)
    return PackResult(bed, results, (*warnings, *remarks(asked, bed, results)), outcome.jamming)


def _task(
    scene: Scene,
    setting: Setting,
    locations: Sequence[Locations],
    on_progress: Listener,
    crew: Crew,
    earlier: Earlier | None,
) -> Task:
    """Draw the spheres of all zones; each zone has randomness of its own."""
    first, *of_supplies = np.random.SeedSequence(scene.seed).spawn(len(scene.zones) + 1)
    # The first zone goes on with the seed of the whole, so that a scene of one zone has one source.
    seeds = [first, *first.spawn(len(scene.zones) - 1)]
    before = no_spheres() if earlier is None else earlier.spheres
    loose_count = len(before) if earlier is not None and earlier.loose else 0
    zones = []
    for index, zone in enumerate(scene.zones):
        supply = Supply(zone, scene.particle_sets, np.random.default_rng(of_supplies[index]))
        mark, friction = scene.mark(f"zones[{index}]"), _friction(scene, zone)
        own, gap = locations[index], gap_of(zone)
        task = ZoneTask(index, mark, own, supply, friction, seeds[index], setting, gap, loose_count)
        zones.append(task)
    return Task(setting, tuple(zones), np.random.default_rng(first), on_progress, crew, before)


def _results(
    spheres: Spheres, zones: Sequence[ZoneTask], wanted: Sequence[Density | None]
) -> tuple[ZoneResult, ...]:
    placed = np.bincount(spheres.zone_index, minlength=len(zones)).tolist()
    solid = np.bincount(spheres.zone_index, UNIT_VOLUME * cube(spheres.radius), len(zones)).tolist()
    return tuple(
        ZoneResult(
            zone.supply.asked,
            placed[zone.index],
            zone.supply.drawn_count - placed[zone.index],
            zone.locations,
            None if zone.supply.counts is None else tuple(zone.supply.counts.tolist()),
            zone.supply.fit,
            None if density is None else density.fraction,
            None if density is None else solid[zone.index] / density.room,
        )
        for zone, density in zip(zones, wanted, strict=True)
    )


def _friction(scene: Scene, zone: ZoneSpec) -> float:
    """Return the friction of the smoothest spheres of a zone."""
    of_material = {each.name: each.friction for each in scene.materials}
    shares = zip(scene.particle_sets, zone.set_proportions, strict=True)
    return min(of_material[each.material or ""] for each, share in shares if share > 0.0)


def _check_device(device: str) -> None:
    if device in {"cpu", "torch"}:
        return
    import torch

    if not torch.cuda.is_available():
        raise PackingError(
            f"--device {device}: torch finds no such device; leave --device out to use the CPU"
        )


def _bed(scene: Scene, outcome: Outcome, earlier: Earlier | None) -> Bed:
    spheres = outcome.spheres
    sets = tuple(ParticleSet(each.name, each.density, each.material) for each in scene.particle_sets)
    provenance: dict[str, Any] = {
        "packgen": __version__,
        "scene": scene.path.name,
        "seed": scene.seed,
        "algorithm": scene.algorithm,
        "settings": scene.model_dump(),
    }
    if earlier is not None:
        provenance["start_from"] = earlier.told
    if outcome.jamming is not None:
        provenance["jamming"] = asdict(outcome.jamming)
    return Bed(
        spheres.position, spheres.radius, spheres.set_index, spheres.zone_index, spheres.batch_index,
        sets, scene.materials, scene.wall_material, outcome.container,
        np.asarray(scene.gravity_direction, float) * scene.gravity + 0.0,  # no negative zeros
        scene.tolerance,
        provenance,
        spheres.body_index,
        None if earlier is None else earlier.mark,
    )  # fmt: skip
