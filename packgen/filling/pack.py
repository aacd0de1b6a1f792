"""From a scene and its container to a bed: draws the radii, runs the algorithm, keeps the provenance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from packgen.arrange.crew import Alone, Crew
from packgen.arrange.registry import find
from packgen.arrange.task import Algorithm, Listener, Outcome, Setting, Task, ZoneTask, no_listener
from packgen.arrays import Float64Array
from packgen.bed import Bed, ParticleSet
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.filling.densities import Density, densities, gap_of
from packgen.filling.fit import checked_locations
from packgen.filling.remarks import remarks
from packgen.filling.room import Locations
from packgen.filling.softness import check_softness
from packgen.filling.tiles import in_tiles
from packgen.geometry import Container, Shape, Slice, floor_direction
from packgen.jamming import Jamming
from packgen.portable import cube, length
from packgen.supply.fitting import SumFit
from packgen.supply.supply import Supply
from packgen.version import __version__

if TYPE_CHECKING:
    from packgen.scene import Scene, ZoneSpec

PERIOD_MIN = 4.0
"""Least length of a periodic box, in largest radii."""


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


def pack(
    scene: Scene,
    container: Container,
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
        scene: The scene.
        container: Its container.
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
        SceneError: The bed's weight would squeeze its spheres through each other, and the scene does not say
            ``allow_soft``.
    """
    ready = prepared(
        scene, container, on_progress=on_progress, threads=threads, device=device, warn=warn,
        for_solver=for_solver, crew=crew,
    )  # fmt: skip
    zones = ready.task.zones
    made = ready.algorithm(ready.task)
    outcome = made if isinstance(made, Outcome) else Outcome(made, container)
    spheres = outcome.spheres
    placed = np.bincount(spheres.zone_index, minlength=len(zones)).tolist()
    solid = np.bincount(spheres.zone_index, UNIT_VOLUME * cube(spheres.radius), len(zones)).tolist()
    bed, results = _bed(ready.scene, outcome), zone_results(ready, placed, solid)
    return PackResult(bed, results, (*ready.warnings, *remarks(ready.asked, bed, results)), outcome.jamming)


@dataclass(frozen=True, eq=False, slots=True)
class Prepared:
    """A scene before its first sphere is placed.

    Attributes:
        scene: The scene as it is packed.
        asked: The scene with the amounts that its densities ask for.
        wanted: The solid fraction that each zone asks for; None: none.
        algorithm: What packs it.
        task: What the algorithm is given.
        warnings: A line for each thing that looks wrong.
    """

    scene: Scene
    asked: Scene
    wanted: Sequence[Density | None]
    algorithm: Algorithm
    task: Task
    warnings: tuple[str, ...]


def prepared(
    scene: Scene,
    container: Container,
    *,
    on_progress: Listener | None,
    threads: int | None,
    device: str,
    warn: Callable[[str], None],
    for_solver: bool,
    crew: Crew | None,
) -> Prepared:
    """Draw a scene's spheres and do all else that comes before the first one is placed; see `pack`."""
    _check_device(device)
    scene = in_tiles(scene, shared=crew is not None)
    algorithm = find(getattr(scene.params, "instead", None) or scene.algorithm).load()
    warnings: list[str] = []

    def tell(line: str) -> None:
        warnings.append(line)
        warn(line)

    # A wrong unit makes spheres soft, too: it is told first.
    locations = checked_locations(scene, container, tell)
    asked, wanted = densities(scene, container, locations)
    for line in check_softness(scene, container, for_solver=for_solver):
        tell(line)
    gravity = np.asarray(scene.gravity_direction, float)
    down = floor_direction(gravity, container.periodic)
    down = gravity / length(gravity) if down is None else down
    setting = Setting(container, down, scene.params, threads, device)
    task = _task(asked, setting, locations, on_progress or no_listener, crew or Alone())
    _check_periods(scene, container, task.zones)
    return Prepared(scene, asked, wanted, algorithm, task, tuple(warnings))


def _task(
    scene: Scene, setting: Setting, locations: Sequence[Locations], on_progress: Listener, crew: Crew
) -> Task:
    """Draw the spheres of all zones; each zone has randomness of its own."""
    first, *of_supplies = np.random.SeedSequence(scene.seed).spawn(len(scene.zones) + 1)
    # The first zone goes on with the seed of the whole, so that a scene of one zone has one source.
    seeds = [first, *first.spawn(len(scene.zones) - 1)]
    zones = []
    for index, zone in enumerate(scene.zones):
        supply = Supply(zone, scene.particle_sets, np.random.default_rng(of_supplies[index]))
        mark, friction = scene.mark(f"zones[{index}]"), _friction(scene, zone)
        zones.append(
            ZoneTask(index, mark, locations[index], supply, friction, seeds[index], setting, gap_of(zone))
        )
    return Task(setting, tuple(zones), np.random.default_rng(first), on_progress, crew)


def zone_results(ready: Prepared, placed: Sequence[int], solid: Sequence[float]) -> tuple[ZoneResult, ...]:
    """Return the outcome of each zone, by its number of spheres and their solid volume [m3]."""
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
        for zone, density in zip(ready.task.zones, ready.wanted, strict=True)
    )


def _friction(scene: Scene, zone: ZoneSpec) -> float:
    """Return the friction of the smoothest spheres of a zone."""
    of_material = {each.name: each.friction for each in scene.materials}
    shares = zip(scene.particle_sets, zone.set_proportions, strict=True)
    return min(of_material[each.material or ""] for each, share in shares if share > 0.0)


def _check_periods(scene: Scene, container: Container, zones: Sequence[ZoneTask]) -> None:
    """Refuse a periodic box so short that a sphere meets another one twice."""
    if not any(container.periodic):
        return
    place = f"{scene.mark('container.periodic')}: container.periodic"
    lengths = container.bounds[1] - container.bounds[0]
    fitted = getattr(scene.params, "fits_container", False)  # then the algorithm knows how long it becomes
    least = PERIOD_MIN * max(float(zone.gap.half(np.array(zone.supply.radius_max))) for zone in zones)
    faults = [
        f"{place}: found a box of {lengths[axis]:.4g} m along {'xyz'[axis]}, expected at least "
        f"{least:.4g} m, two diameters of the largest sphere, so that none meets another one twice; "
        f"make it longer or leave {'xyz'[axis]} out"
        for axis in np.flatnonzero(container.periodic)
        if lengths[axis] < least and not fitted
    ]
    unsupported = getattr(scene.params, "unsupported", None)
    faults += [
        f"{scene.mark(path)}: {path}: {text}"
        for path, text in ([] if unsupported is None else unsupported(container))
    ]
    if faults:
        raise PackingError("\n".join(faults))


def _check_device(device: str) -> None:
    if device in {"cpu", "torch"}:
        return
    import torch

    if not torch.cuda.is_available():
        raise PackingError(
            f"--device {device}: torch finds no such device; leave --device out to use the CPU"
        )


def _bed(scene: Scene, outcome: Outcome) -> Bed:
    spheres = outcome.spheres
    provenance = provenance_of(scene)
    if outcome.jamming is not None:
        provenance["jamming"] = asdict(outcome.jamming)
    return Bed(
        spheres.position, spheres.radius, spheres.set_index, spheres.zone_index, spheres.batch_index,
        sets_of(scene), scene.materials, scene.wall_material, outcome.container, gravity_of(scene),
        scene.tolerance,
        provenance,
        spheres.body_index,
    )  # fmt: skip


def sets_of(scene: Scene) -> tuple[ParticleSet, ...]:
    """Return the particle sets of a scene, as a bed has them."""
    return tuple(ParticleSet(each.name, each.density, each.material) for each in scene.particle_sets)


def gravity_of(scene: Scene) -> Float64Array:
    """Return the acceleration of gravity of a scene [m/s2], shape (3,)."""
    # No negative zeros.
    return np.asarray(np.asarray(scene.gravity_direction, float) * scene.gravity + 0.0)


def provenance_of(scene: Scene) -> dict[str, Any]:
    """Return what a bed says of the scene that it was made from."""
    return {
        "packgen": __version__,
        "scene": scene.path.name,
        "seed": scene.seed,
        "algorithm": scene.algorithm,
        "settings": scene.model_dump(),
    }
