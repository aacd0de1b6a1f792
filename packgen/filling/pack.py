"""From a scene and its container to a bed: draws the radii, runs the algorithm, keeps the provenance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from packgen.arrange.crew import Crew
from packgen.arrange.spheres import in_rows, rows_of_bodies
from packgen.arrange.task import Listener, Outcome, Task
from packgen.arrange.traits import traits_of
from packgen.arrays import Float64Array
from packgen.bed import Bed, ParticleSet
from packgen.distributions import UNIT_VOLUME
from packgen.filling.compacted import SLACK, as_dense
from packgen.filling.prepared import Prepared, prepared
from packgen.filling.remarks import remarks
from packgen.geometry import Container, Shape, Slice
from packgen.jamming import Jamming
from packgen.portable import cube
from packgen.scene.load import Scene
from packgen.search import Search
from packgen.supply.fitting import SumFit
from packgen.version import __version__

ROUNDING = 1.0e-9
"""Part of the space by which a coverage may be missed."""


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
        solid_fraction_asked: Solid fraction asked for, of all of the zone, or of its bed or that bed's core
            where it is under gravity; None: none was.
        solid_fraction: The one reached; None: none was asked for, or the bed is too small for a core.
        slack: Largest difference of the two that is no miss; None: whole spheres decide that.
    """

    asked: int | None
    placed: int
    left_over: int
    locations: tuple[Shape | Slice, ...] = ()
    counts: tuple[int, ...] | None = None
    fit: SumFit | None = None
    solid_fraction_asked: float | None = None
    solid_fraction: float | None = None
    slack: float | None = None


@dataclass(frozen=True, eq=False, slots=True)
class PackResult:
    """The bed, what became of each zone, what looks wrong, line by line, and how it is jammed or found."""

    bed: Bed
    zones: tuple[ZoneResult, ...]
    warnings: tuple[str, ...] = ()
    jamming: Jamming | None = None
    search: Search | None = None

    def _repr_html_(self) -> str:
        """Return verdict and page, which notebooks show."""
        from packgen.notebook import bed_html

        return bed_html(self.bed, self.zones, self.warnings, self.jamming, self.search)


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
    ready = prepared(
        scene, container, on_progress=on_progress, threads=threads, device=device, warn=warn,
        for_solver=for_solver, crew=crew,
    )  # fmt: skip
    if ready.aim is None:
        made, reached = _made(ready), None
    else:
        made, reached = as_dense(ready.aim, partial(_made, ready))
    each, zones = rows_of_bodies(made.outcome.spheres), made.task.zones
    placed = np.bincount(each.zone_index, minlength=len(zones)).tolist()
    solid = np.bincount(each.zone_index, UNIT_VOLUME * cube(each.radius), len(zones)).tolist()
    results = zone_results(ready, made.task, placed, solid)
    if ready.aim is not None:
        asked = ready.aim.asked
        results = (
            replace(results[0], solid_fraction_asked=asked, solid_fraction=reached, slack=SLACK),
        )  # fmt: skip
    coverage = traits_of(ready.setting.settings).coverage
    if coverage is not None:
        reached = min(sum(solid) / ready.setting.container.volume, coverage)
        last = replace(results[-1], solid_fraction_asked=coverage, solid_fraction=reached, slack=ROUNDING)
        results = (*results[:-1], last)
    warnings = (*ready.warnings, *remarks(ready.asked, made.bed, results))
    return PackResult(made.bed, results, warnings, made.outcome.jamming, made.outcome.search)


class _Made(NamedTuple):
    """What an algorithm has made of a task."""

    task: Task
    outcome: Outcome
    bed: Bed


def _made(ready: Prepared, core_fraction: float | None = None, number: int = 0) -> _Made:
    """Pack a bed; see ``Prepared.task``."""
    task = ready.task(core_fraction, number)
    arranged = ready.algorithm(task)
    outcome = arranged if isinstance(arranged, Outcome) else Outcome(arranged, task.container)
    return _Made(task, outcome, _bed(ready, outcome))


def zone_results(
    ready: Prepared, task: Task, placed: Sequence[int], solid: Sequence[float]
) -> tuple[ZoneResult, ...]:
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
        for zone, density in zip(task.zones, ready.wanted, strict=True)
    )


def _bed(ready: Prepared, outcome: Outcome) -> Bed:
    scene, earlier, spheres = ready.scene, ready.earlier, in_rows(outcome.spheres)
    provenance = provenance_of(scene)
    if earlier is not None:
        provenance["start_from"] = earlier.told
    if outcome.jamming is not None:
        provenance["jamming"] = asdict(outcome.jamming)
    if outcome.search is not None:
        provenance["search"] = asdict(outcome.search)
    return Bed(
        spheres.position, spheres.radius, spheres.set_index, spheres.zone_index, spheres.batch_index,
        sets_of(scene), scene.materials, scene.wall_material, outcome.container, gravity_of(scene),
        scene.tolerance,
        provenance,
        spheres.body_index,
        None if earlier is None else earlier.mark,
        spheres.bodies,
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
