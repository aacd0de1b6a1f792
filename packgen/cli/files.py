"""Beds from files: what ``packgen measure``, ``convert``, ``carve`` and ``repeat`` take, as typed values."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from packgen.cli.options import add_formats, add_results, command_parser, names_in, share
from packgen.errors import PackgenError
from packgen.units import LENGTHS, to_si

MEASURE, CONVERT, CARVE, REPEAT = "measure", "convert", "carve", "repeat"

DESCRIPTIONS = MappingProxyType(
    {
        MEASURE: "Check and measure a bed of spheres from a file, wherever it comes from.",
        CONVERT: "Write a bed of spheres from a file, wherever it comes from, in other formats.",
        CARVE: "Keep the part of a bed inside or outside a closed mesh: a core sample, a tunnel, a borehole.",
        REPEAT: "Put copies of a bed that wraps around side by side, along the axes along which it does.",
    }
)
EPILOG = """files: bed.npz, csv and text (columns named, or x y z r), data files and dumps of LIGGGHTS and
LAMMPS, text of YADE, vtp, vtu, vtk, extended XYZ, particle_input.dat of MFiX, manifest.json of a bed in
pieces, which is never held as a whole

exit codes: 0 done and within tolerance; 1 written, but the bed has faults or a deck is missing;
2 wrong input, nothing written; 130 interrupted, nothing written"""


@dataclass(frozen=True, slots=True)
class FileOptions:
    """The options that all these commands have.

    Attributes:
        file: The file of spheres.
        pieces: Whether it is the manifest of a bed in pieces.
        scene: Scene that says sets, materials, walls and gravity; None: none does.
        container: Mesh of the walls; None: the scene's walls, or those that the file knows.
        container_units: Unit of the mesh.
        units: Unit of the file's lengths; None: metres, unless they look wrong.
        step: Step of a dump; None: the last one.
        density: Densities [kg/m3] by name of the set; "" stands for all that are not known.
        export: Names of the formats to write, each once.
        export_option: Options of exporters, each ``NAME.KEY=VALUE``.
        templates: Folder whose deck templates replace packgen's own; None: none does.
        tolerance: Largest overlap, as a fraction of the smaller radius; None: the scene's, or 1e-6.
        judged: Whether overlaps count as faults.
        output: The result folder; None: named after the file.
        threads: Threads of the measures; None: as many as cores are free.
        force: Whether a folder with foreign files is set aside.
        picture: Whether to draw the bed.
        page: Whether to make ``report.html``.
        quiet: Whether to leave out the summary.
    """

    file: Path
    pieces: bool = False
    scene: Path | None = None
    container: Path | None = None
    container_units: str = "m"
    units: str | None = None
    step: int | None = None
    density: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    export: tuple[str, ...] = ()
    export_option: tuple[str, ...] = ()
    templates: Path | None = None
    tolerance: float | None = None
    judged: bool = True
    output: Path | None = None
    threads: int | None = None
    force: bool = False
    picture: bool = False
    page: bool = True
    quiet: bool = False

    @property
    def target(self) -> Path:
        """The result folder."""
        if self.output is not None:
            return self.output
        if not self.pieces:
            return Path(self.file.stem)
        # The folder of the pieces may be in this one, under its own name.
        return Path(f"{self.file.resolve().parent.name}_{MEASURE if self.judged else CONVERT}")


def file_options(command: str, arguments: Sequence[str]) -> FileOptions:
    """Return what follows ``measure`` or ``convert``.

    Raises:
        PackgenError: Options do not go together.
    """
    return options_of(command, vars(build_file_parser(command).parse_args(arguments)))


def options_of(command: str, given: Mapping[str, Any]) -> FileOptions:
    """Return the options that all commands have, from what the parser of one of them gives.

    Raises:
        PackgenError: Options do not go together.
    """
    export = names_in(given.get("export", ()))
    if command == CONVERT and not export:
        raise PackgenError("--export: found no format, expected one, such as --export liggghts")
    if given["scene"] is not None and given["container"] is not None:
        raise PackgenError("--container: found beside --scene, whose container counts; leave one of them out")
    if given["container_units"] is not None and given["container"] is None:
        raise PackgenError(
            "--container-units: found without --container, expected the mesh whose unit it is; "
            "--units is for the file of spheres"
        )
    from packgen.pieces import is_manifest

    pieces = is_manifest(given["file"])
    if pieces and command in {CARVE, REPEAT}:
        raise PackgenError(
            f"{given['file']}: found a bed in pieces, expected one in a single file; `packgen convert` makes "
            "a csv file of it"
        )
    if pieces:
        _refuse_with_pieces(given["step"], given["units"], picture=given["picture"])
    return FileOptions(
        file=given["file"],
        pieces=pieces,
        scene=given["scene"],
        container=given["container"],
        container_units=given["container_units"] or "m",
        units=given["units"],
        step=given["step"],
        density=MappingProxyType(dict(given["density"])),
        export=export,
        export_option=tuple(given.get("export_option", ())),
        templates=given.get("templates"),
        tolerance=given.get("tolerance"),
        judged=command != CONVERT,
        output=given["output"],
        threads=given["threads"],
        force=given["force"],
        picture=given["picture"],
        page=not given["no_report"],
        quiet=given["quiet"],
    )


def _refuse_with_pieces(step: int | None, units: str | None, *, picture: bool) -> None:
    """Refuse options that are for other files."""
    options = (("--step", step is not None), ("--units", units is not None), ("--picture", picture))
    for name, found in options:
        if found:
            raise PackgenError(f"{name}: found with a bed in pieces, expected none; leave it out")


def build_file_parser(command: str) -> argparse.ArgumentParser:
    """Return the parser of ``packgen measure`` or ``packgen convert``."""
    parser = command_parser(command, DESCRIPTIONS[command], EPILOG)
    parser.add_argument("file", metavar="FILE", type=Path, help="file of spheres")
    add_source(parser)
    if command == CONVERT:
        add_formats(parser, "format")
    else:
        add_tolerance(parser)
    add_results(parser, "file", "threads of the measures (default: as many as cores are free to packgen)")
    return parser


def add_source(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what a file of spheres does not."""
    units = tuple(LENGTHS)
    parser.add_argument(
        "--scene", metavar="SCENE", type=Path, help="scene that says sets, materials, walls and gravity"
    )
    parser.add_argument("--container", metavar="MESH", type=Path, help="mesh of the walls, without a scene")
    parser.add_argument("--container-units", choices=units, help="unit of that mesh (default: m)")
    parser.add_argument(
        "--units", choices=units, help="unit of the file's lengths (default: m, refused where it looks wrong)"
    )
    parser.add_argument(
        "--step",
        metavar="N",
        type=int,
        help="step of a dump or an XYZ file of several (default: the last one)",
    )
    parser.add_argument(
        "--density",
        metavar="[SET=]VALUE",
        type=_density,
        action="append",
        default=[],
        help="density of a set, or of all whose density is not known, such as 2500 or steel=7.8g/cm3; "
        "may be repeated",
    )


def add_tolerance(parser: argparse.ArgumentParser) -> None:
    """Add the option that says which overlaps are faults."""
    parser.add_argument(
        "--tolerance",
        metavar="SHARE",
        type=share,
        help="largest overlap that is no fault, in smaller radii (default: that of the scene, else 1e-6)",
    )


def _density(text: str) -> tuple[str, float]:
    """Return the name of a set, empty for all, and a density [kg/m3]."""
    name, _, value = text.rpartition("=")
    try:
        density = to_si(value, "density")
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"found {value!r}, expected {error}") from error
    if not 0.0 < density < float("inf"):
        raise argparse.ArgumentTypeError(f"found {value!r}, expected a density greater than 0")
    return name.strip(), density
