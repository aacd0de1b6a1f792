"""A bed from a file: read, check, measure, write. A function a stage, as for a run of a scene."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from packgen.cli.ending import Ending
from packgen.cli.exports import Format, check_formats, check_whole, outlook_of_bed, write_decks
from packgen.cli.files import FileOptions, file_options
from packgen.cli.names import refuse_unreadable
from packgen.cli.plan import find_formats
from packgen.cli.run import conclude, explained
from packgen.cli.screen import say
from packgen.cli.stopwatch import Stopwatch
from packgen.cli.visuals import composer, write_looks
from packgen.errors import PackgenError
from packgen.resultfolder import ResultFolder
from packgen.stopping import held

if TYPE_CHECKING:  # a wrong option must not wait for scipy
    from exporters.protocol import Place
    from packgen.arrays import Int64Array
    from packgen.bed import AnyBed, Bed
    from packgen.geometry import Container
    from packgen.reading import SphereFile
    from packgen.report import Measures
    from packgen.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Changed:
    """What became of a bed that was read.

    Attributes:
        bed: The bed now.
        ids: What the file calls each of its spheres, shape (N,); None: it has no ids.
        notes: A line for each thing that was done, for the summary.
    """

    bed: AnyBed
    ids: Int64Array | None
    notes: tuple[str, ...] = ()


class Change(Protocol):
    """What makes another bed of one that was read."""

    @property
    def stage(self) -> str:
        """What the stage is called in the report's times."""

    def __call__(self, spheres: SphereFile, bed: Bed, folder: Path, said: list[str], /) -> Changed:
        """Return the other bed; files about it go into ``folder``, warnings into ``said``."""


@dataclass(frozen=True, slots=True)
class _Judged:
    """What was found of a bed: the measures, the faults by name, the warnings, and what is not measured."""

    measures: Measures
    named: tuple[str, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...] = ()


def run_file_command(command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run ``packgen measure`` or ``packgen convert``.

    Args:
        command: Which one.
        arguments: What follows it.
        ending: Told when the results are in place.

    Returns:
        The exit code.

    Raises:
        PackgenError: The file, the scene or an option is wrong.
    """
    return judge_file(file_options(command, arguments), ending)


def judge_file(
    options: FileOptions, ending: Ending, change: Change | None = None, *, inputs: tuple[Path, ...] = ()
) -> int:
    """Read a bed, make another one of it where that is asked, check it, measure it and write it.

    Args:
        options: The options.
        ending: Told when the results are in place.
        change: What makes another bed of the one that was read.
        inputs: More files that the command reads.

    Returns:
        The exit code.

    Raises:
        PackgenError: The file, the scene or an option is wrong.
    """
    from packgen.reading import refuse_no_file, refuse_unknown

    refuse_no_file(options.file)
    formats = find_formats(options.export, options.export_option, options.templates)
    refuse_unreadable([options.target.resolve().name])
    watch = Stopwatch()
    kept = [each for each in (options.file, options.scene, options.container, *inputs) if each is not None]
    folder = ResultFolder(options.target, force=options.force, keep=tuple(kept))
    with folder:
        said: list[str] = []
        with watch.stage("read"), explained(said):
            spheres, bed, place = _read(options, said)
        changed = _changed(change, spheres, bed, folder.path, said, watch)
        bed = changed.bed
        refuse_unknown(options.file, bed, {need for each in formats.values() for need in each.exporter.NEEDS})
        if options.pieces:
            check_whole(formats, bed.count)
        if formats:
            check_formats(formats, outlook_of_bed(bed, place))
        judged = _judge(changed, options, said, watch)
        folder.notes += judged.notes
        unwritten = _write(bed, formats, folder, watch)
        compose = composer(
            judged.measures, bed.provenance, watch,
            missed=(*judged.named, *unwritten), warnings=judged.warnings,
        )  # fmt: skip
        report = write_looks(
            bed, compose, folder.path, folder.target.name, watch,
            page=options.page, picture=options.picture,
        )  # fmt: skip
        code = int(bool(report.missed))
        with held():
            folder.commit()
            ending.done(code, f"the bed is in {folder.target}")
    if not options.quiet:
        for line in changed.notes:
            say(line, sys.stdout)
    conclude(report, folder, quiet=options.quiet)
    return code


def _changed(
    change: Change | None,
    spheres: SphereFile | None,
    bed: AnyBed,
    folder: Path,
    said: list[str],
    watch: Stopwatch,
) -> Changed:
    """Make another bed of one that was read, where that is asked; it is asked of none in pieces."""
    from packgen.bed import Bed

    if change is None or spheres is None or not isinstance(bed, Bed):
        return Changed(bed, None if spheres is None else spheres.id)
    with watch.stage(change.stage), explained(said):
        return change(spheres, bed, folder, said)


def _read(options: FileOptions, said: list[str]) -> tuple[SphereFile | None, AnyBed, Place]:
    """Return the file's spheres, the bed with all that is known of it, and where values of its scene are.

    Raises:
        PackgenError: The file is not what it claims, or does not fit the scene.
    """
    from packgen.reading import complete_bed, read_pieces, read_spheres, rounding_remark

    scene, container = _load(options, said)
    place: Place = (lambda _location: str(options.file)) if scene is None else scene.marked.place
    if options.pieces:
        pieces = read_pieces(options.file, container, scene=scene, density=options.density, warn=said.append)
        return None, replace(pieces, tolerance=_tolerance(options, pieces.tolerance)), place
    spheres = read_spheres(options.file, step=options.step, units=options.units)
    bed = complete_bed(
        spheres, container, scene=scene, density=options.density, units=options.units, warn=said.append
    )
    bed = replace(bed, tolerance=_tolerance(options, bed.tolerance))
    remark = rounding_remark(spheres, bed.tolerance)
    if remark is not None:
        said.append(remark)
    return spheres, bed, place


def _tolerance(options: FileOptions, of_bed: float | None) -> float | None:
    """Return the largest overlap that is no fault; None: none is one."""
    if not options.judged:
        return None
    return of_bed if options.tolerance is None else options.tolerance


def _load(options: FileOptions, said: list[str]) -> tuple[Scene | None, Container | None]:
    """Return the scene and the container that the command line names."""
    from packgen.container import load_container, mesh_container

    if options.scene is not None:
        from packgen.scene import load_scene

        scene = load_scene(options.scene)
        return scene, load_container(scene, said.append)
    if options.container is None:
        return None, None
    if not options.container.is_file():
        raise PackgenError(f"--container: found {options.container}, expected a file of a mesh")
    return None, mesh_container(options.container, options.container_units, "--container", said.append)


def _judge(changed: Changed, options: FileOptions, said: Sequence[str], watch: Stopwatch) -> _Judged:
    """Check and measure the bed."""
    import numpy as np

    from packgen.bed import Bed
    from packgen.check import check_bed, wall_clearance
    from packgen.check.naming import named_faults
    from packgen.measure.order import WALL_REACH
    from packgen.report import measure_bed

    bed = changed.bed
    if not isinstance(bed, Bed):
        return _judge_pieces(bed, said, watch)
    with watch.stage("check"):
        clearance = wall_clearance(bed.container, bed.position, WALL_REACH * bed.radius)
        # Walls that are not known are not judged; near the box in their place a bed is not the bed's own.
        judged = clearance if bed.container.walls_known else np.full(bed.count, np.inf)
        check = check_bed(bed, judged)
        named = () if check.within_tolerance else named_faults(bed, judged, changed.ids)
    with watch.stage("measure"):
        measures = measure_bed(bed, check=check, clearance=clearance, threads=options.threads)
    return _Judged(measures, named, tuple(said))


def _judge_pieces(bed: AnyBed, said: Sequence[str], watch: Stopwatch) -> _Judged:
    """Check and measure a bed in pieces."""
    from packgen.pieces import PieceBed
    from packgen.report_in_pieces import check_pieces, faults_in_pieces, left_out, measure_pieces

    assert isinstance(bed, PieceBed)
    with watch.stage("check"):
        check = check_pieces(bed)
        named = () if check.within_tolerance or check.invalid_count else faults_in_pieces(bed)
    with watch.stage("measure"):
        return _Judged(measure_pieces(bed, check), named, tuple(said), (left_out(),))


def _write(
    bed: AnyBed, formats: Mapping[str, Format], folder: ResultFolder, watch: Stopwatch
) -> tuple[str, ...]:
    """Write the bed, and in each format; return a line for each one that could not be written."""
    from packgen.bed import Bed
    from packgen.bedfile import save_bed

    if isinstance(bed, Bed):  # pieces stay where they are
        with watch.stage("write"):
            save_bed(bed, folder.path / "bed.npz")
    with watch.stage("export"):
        return write_decks(bed, folder.path, formats)
