"""``packgen carve`` and ``packgen repeat``: beds made of beds, checked and measured like those from files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.ending import Ending
from packgen.cli.files import CARVE, DESCRIPTIONS, REPEAT, FileOptions, add_source, add_tolerance, options_of
from packgen.cli.judge import Changed, judge_file
from packgen.cli.options import add_formats, add_results, command_parser, whole
from packgen.errors import PackgenError
from packgen.units import LENGTHS

if TYPE_CHECKING:  # a wrong option must not wait for scipy
    from packgen.bed import Bed
    from packgen.reading import SphereFile

SOURCE_INDEX, WALLS = "source_index.npy", "walls.stl"
CARVE_EPILOG = f"""which spheres: --inside MESH keeps those whose whole body is inside the closed mesh, by its
exact triangles; with --touching also those that it cuts. --outside MESH keeps those whose whole body is
outside; with --touching also those that it cuts. So --inside and --outside --touching share out all spheres,
and so do --outside and --inside --touching. A sphere that only touches the mesh is not cut; nor is one that
is in it by no more than the tolerance. A clump is kept or left as a whole.

results: as of packgen measure. The spheres are numbered anew, in the order that they had; {SOURCE_INDEX} has
the number, from 0, of each in FILE (by rising id, where it has ids). The walls: inside, the mesh; outside,
those of the bed with the mesh as an inner wall; in {WALLS}, for --container. With --touching, and outside of
a mesh in a bed that wraps around, those of the bed: spheres cross the mesh, or a box cannot have it.

exit codes: 0 done and within tolerance; 1 written, but the bed has faults or a deck is missing;
2 wrong input, nothing written; 130 interrupted, nothing written"""
REPEAT_EPILOG = """results: as of packgen measure. The spheres come copy by copy, x fastest; those of the
first copy keep their numbers. All contacts across the seams are checked.

exit codes: 0 done and within tolerance; 1 written, but the bed has faults or a deck is missing;
2 wrong input, nothing written; 130 interrupted, nothing written"""


@dataclass(frozen=True, slots=True)
class CarveOptions:
    """What ``packgen carve`` takes beside what all commands for files do.

    Attributes:
        mesh: The mesh.
        units: Unit of its lengths.
        inside: Whether the part inside is kept; else the part outside.
        touching: Whether spheres that the mesh cuts are kept too.
    """

    mesh: Path
    units: str
    inside: bool
    touching: bool


def run_reshape_command(command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run ``packgen carve`` or ``packgen repeat``.

    Args:
        command: Which one.
        arguments: What follows it.
        ending: Told when the results are in place.

    Returns:
        The exit code.

    Raises:
        PackgenError: The file, the mesh, the scene or an option is wrong.
    """
    if command == CARVE:
        options, cut = carve_options(arguments)
        return judge_file(options, ending, _Carve(cut), inputs=(cut.mesh,))
    options, counts = repeat_options(arguments)
    return judge_file(options, ending, _Repeat(counts))


def carve_options(arguments: Sequence[str]) -> tuple[FileOptions, CarveOptions]:
    """Return what follows ``carve``.

    Raises:
        PackgenError: Options do not go together, or there is no such mesh.
    """
    given = vars(build_carve_parser().parse_args(arguments))
    inside = given["inside"] is not None
    mesh = given["inside"] if inside else given["outside"]
    if not mesh.is_file():
        option = "--inside" if inside else "--outside"
        raise PackgenError(f"{option}: found {mesh}, expected a file of a closed mesh")
    options = _named(options_of(CARVE, given), "carved")
    return options, CarveOptions(mesh, given["mesh_units"] or "m", inside, given["touching"])


def repeat_options(arguments: Sequence[str]) -> tuple[FileOptions, tuple[int, int, int]]:
    """Return what follows ``repeat``.

    Raises:
        PackgenError: Options do not go together.
    """
    given = vars(build_repeat_parser().parse_args(arguments))
    x, y, z = given["counts"]
    return _named(options_of(REPEAT, given), "repeated"), (x, y, z)


def _named(options: FileOptions, ending: str) -> FileOptions:
    """Return options with the file that a result folder stands for, and a result folder of its own."""
    file, name = options.file, options.file.stem
    if file.is_dir() and (file / "bed.npz").exists():
        file, name = file / "bed.npz", file.resolve().name
    return replace(options, file=file, output=options.output or Path(f"{name}_{ending}"))


def build_carve_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen carve``."""
    parser = command_parser(CARVE, DESCRIPTIONS[CARVE], CARVE_EPILOG)
    _add_file(parser)
    side = parser.add_mutually_exclusive_group(required=True)
    side.add_argument(
        "--inside",
        metavar="MESH",
        type=Path,
        help="keep the spheres whose whole body is inside this closed mesh",
    )
    side.add_argument(
        "--outside", metavar="MESH", type=Path, help="keep those whose whole body is outside of it"
    )
    parser.add_argument("--touching", action="store_true", help="keep those that the mesh cuts too")
    parser.add_argument("--mesh-units", choices=tuple(LENGTHS), help="unit of the mesh (default: m)")
    _add_rest(parser, "carved")
    return parser


def build_repeat_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen repeat``."""
    parser = command_parser(REPEAT, DESCRIPTIONS[REPEAT], REPEAT_EPILOG)
    _add_file(parser)
    parser.add_argument(
        "counts", metavar="N", type=whole(1), nargs=3,
        help="copies along x, y and z; 1 along an axis along which the bed does not wrap around",
    )  # fmt: skip
    _add_rest(parser, "repeated")
    return parser


def _add_file(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="file of spheres, of any format, or result folder of packgen"
    )


def _add_rest(parser: argparse.ArgumentParser, ending: str) -> None:
    add_source(parser)
    add_formats(parser, "format")
    add_tolerance(parser)
    threads = "threads of the measures (default: as many as cores are free to packgen)"
    add_results(parser, f"file, with _{ending} behind it", threads)


@dataclass(frozen=True, slots=True)
class _Carve:
    """Keeps a part of a bed."""

    options: CarveOptions
    stage: str = CARVE

    def __call__(self, spheres: SphereFile, bed: Bed, folder: Path, said: list[str], /) -> Changed:
        """Return the part; write which spheres it has, and its walls."""
        import numpy as np

        from exporters.walls.stl import write_stl
        from packgen.container import closed_mesh
        from packgen.reshape.carve import Cut, carve_bed

        option = "--inside" if self.options.inside else "--outside"
        mesh = closed_mesh(self.options.mesh, self.options.units, option, said.append)
        carved = carve_bed(bed, Cut(mesh, self.options.inside, self.options.touching))
        said.extend(carved.notes)
        np.save(folder / SOURCE_INDEX, carved.source_index)
        if carved.bed.container is not bed.container:
            surface = carved.bed.container.surface
            write_stl(folder / WALLS, surface.vertices[surface.faces])
        ids = None if spheres.id is None else spheres.id[carved.source_index]
        kept = f"kept: {carved.bed.count:,} of {bed.count:,} spheres"
        return Changed(carved.bed, ids, (kept, carved.walls))


@dataclass(frozen=True, slots=True)
class _Repeat:
    """Puts copies of a bed side by side."""

    counts: tuple[int, int, int]
    stage: str = REPEAT

    def __call__(self, _spheres: SphereFile, bed: Bed, _folder: Path, _said: list[str], /) -> Changed:
        """Return the copies as one bed."""
        from packgen.reshape.repeat import repeat_bed

        found = repeat_bed(bed, self.counts)
        copies = " x ".join(map(str, self.counts))
        notes = [f"copies: {copies} of {bed.count:,} spheres are {found.bed.count:,}"]
        if max(self.counts) > 1:
            notes.append(
                f"seams: {found.seam_contacts:,} contacts between copies, {found.contacts:,} for each copy; "
                f"largest overlap {max(found.worst_overlap, 0.0):.3g} of the smaller radius"
            )
        return Changed(found.bed, None, tuple(notes))
