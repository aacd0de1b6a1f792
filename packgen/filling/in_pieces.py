"""From a scene and its container to a bed in pieces: packed by tiles, and never in memory as a whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.arrange.crew import Crew
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Listener
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.filling.pack import (
    ZoneResult,
    gravity_of,
    provenance_of,
    sets_of,
    zone_results,
)
from packgen.filling.prepared import prepared
from packgen.filling.remarks import remarks_in_pieces
from packgen.geometry import Container
from packgen.jamming import Jamming
from packgen.pieces import MANIFEST, Manifest, PieceBed, PieceWriter
from packgen.pieces.grid import SPHERES, Grid
from packgen.search import Search

if TYPE_CHECKING:
    from packgen.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class PiecesResult:
    """A bed in pieces, and the rest of what `packgen.filling.pack.PackResult` has."""

    bed: PieceBed
    zones: tuple[ZoneResult, ...]
    warnings: tuple[str, ...] = ()
    jamming: Jamming | None = None
    search: Search | None = None


def pack_in_pieces(
    scene: Scene,
    container: Container,
    folder: Path,
    *,
    crew: Crew,
    on_progress: Listener | None = None,
    threads: int | None = None,
    warn: Callable[[str], None] = lambda _: None,
    for_solver: bool = False,
    spheres: int = SPHERES,
) -> PiecesResult:
    """Fill the container as the scene says, as `packgen.filling.pack.pack` does with the same crew.

    Args:
        scene: The scene.
        container: Its container.
        folder: Where the pieces and their manifest come; it exists.
        crew: Who does the work.
        on_progress: Called after each unit of a layer.
        threads: Threads to use.
        warn: Called before the first sphere is placed, with a line for each thing that looks wrong.
        for_solver: Whether a solver will get the bed.
        spheres: Spheres of a piece, about.

    Raises:
        PackingError: The scene cannot be divided, or nothing can be placed.
        SceneError: The bed's weight would squeeze its spheres through each other.
    """
    ready = prepared(
        scene, container, on_progress=on_progress, threads=threads, device="cpu", warn=warn,
        for_solver=for_solver, crew=crew,
    )  # fmt: skip
    task = ready.task()
    [zone, *_] = task.zones
    grid = Grid.over(container.bounds, zone.supply.mean_volume, zone.supply.radius_max, spheres)
    writer = PieceWriter(folder, grid, len(scene.particle_sets))

    def put_away(some: Spheres) -> None:
        writer.add(some.position, some.radius, some.set_index, some.zone_index, some.batch_index)

    ready.algorithm(replace(task, sink=put_away))
    if writer.count == 0:
        raise PackingError(
            f"{zone.place}: not one sphere fits; expected a larger container or smaller spheres"
        )
    pieces, census = writer.finish()
    provenance = provenance_of(ready.scene)
    Manifest(pieces, census, provenance).write(folder / MANIFEST)
    scene = ready.scene
    bed = PieceBed(
        folder, pieces, census, sets_of(scene), scene.materials, scene.wall_material, container,
        gravity_of(scene), scene.tolerance, provenance,
    )  # fmt: skip
    results = zone_results(ready, task, [census.count], [UNIT_VOLUME * float(sum(census.cube_sum))])
    return PiecesResult(bed, results, (*ready.warnings, *remarks_in_pieces(ready.asked, bed, results)))
