"""``packgen clump``: the spheres of a rigid clump, from the mesh of a stone or a parametric shape."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from packgen.cli.ending import Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import command_parser, length, share, whole
from packgen.cli.screen import say, say_json, table
from packgen.errors import PackgenError
from packgen.units import LENGTHS

if TYPE_CHECKING:  # a wrong option must not wait for numba
    from packgen.clumps import Clump, Wanted

SHAPE_SIZES = {
    "dumbbell": "radius, distance",
    "rod": "radius, length",
    "tetrapod": "radius, arm",
    "ring": "radius, thickness",
    "cylinder": "radius, height",
    "ellipsoid": "x, y, z",
    "cube": "side, edge",
}
DESCRIPTION = (
    "Fill the closed mesh of a stone, or a shape, with the spheres of a rigid clump; write rows x y z r with "
    "the body's volume, centre and inertia, as CLUMP, LIGGGHTS and Chrono read them."
)
CLUMP_EPILOG = f"""shapes, and their sizes for --set: {
    "; ".join(f"{name} ({sizes})" for name, sizes in SHAPE_SIZES.items())
}. A mesh of such a name is ./ring.

results: FILE, and beside it FILE's name with .json: the properties of the body and of the union of the
    spheres,
and the errors. The origin is the body's centre of mass, the axes are those of the mesh. Volume and inertia
in the file are the body's: of the spheres' sum they would count overlaps several times.

exit codes: 0 done; 1 written, but an error asked for was not reached; 2 wrong input, nothing written;
130 interrupted, nothing written"""


@dataclass(frozen=True, slots=True)
class ClumpOptions:
    """The options of ``packgen clump``.

    Attributes:
        source: A mesh, or the name of a shape.
        units: Unit of the mesh.
        sizes: Lengths of the shape [m].
        spheres: Number of spheres at most; None: not said.
        volume_error: Error of the volume to be reached; None: any.
        surface_error: Error of the surface to be reached; None: any.
        least_radius: Least radius [m].
        equal: Whether all spheres have one radius.
        best_fit: Whether spheres may stick out.
        output: The file; None: named after the source.
        picture: Whether a picture is drawn.
        force: Whether files that are there are overwritten.
        as_json: Whether the report is shown as JSON.
    """

    source: str
    units: str | None = None
    sizes: dict[str, float] = field(default_factory=dict)
    spheres: int | None = None
    volume_error: float | None = None
    surface_error: float | None = None
    least_radius: float = 0.0
    equal: bool = False
    best_fit: bool = False
    output: Path | None = None
    picture: bool = False
    force: bool = False
    as_json: bool = False

    @property
    def is_shape(self) -> bool:
        """Whether the source is the name of a shape."""
        return self.source in SHAPE_SIZES

    @property
    def target(self) -> Path:
        """The file of the spheres."""
        return self.output or Path(f"{Path(self.source).stem}.csv")

    @property
    def files(self) -> tuple[Path, ...]:
        """All files that are written."""
        beside = [".json"] + [".png"] * self.picture
        return (self.target, *(self.target.with_suffix(each) for each in beside))


def build_clump_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen clump``."""
    parser = command_parser("clump", DESCRIPTION, CLUMP_EPILOG)
    add = parser.add_argument
    add("source", metavar="MESH", help="closed mesh (STL, PLY, OBJ, OFF ...), or the name of a shape")
    add("--spheres", metavar="N", type=whole(1), help="number of spheres at most")
    add(
        "--volume-error", metavar="E", type=share,
        help="add spheres until the volume that they miss or put outside is at most this share of the body's",
    )  # fmt: skip
    add(
        "--surface-error", metavar="E", type=share,
        help="add spheres until all of the surface is nearer to them than this share of the diameter",
    )  # fmt: skip
    add(
        "--least-radius",
        metavar="LENGTH",
        type=length,
        default=0.0,
        help="least radius of a sphere, such as 0.2mm",
    )
    add("--equal", action="store_true", help="spheres of one radius, the best one")
    add(
        "--best-fit", action="store_true",
        help="spheres may stick out: the union has the body's volume and centre, and least is misplaced",
    )  # fmt: skip
    add("--units", choices=tuple(LENGTHS), help="unit of the mesh (default: m)")
    add(
        "--set", metavar="SIZE=LENGTH", type=_size, action="append", default=[],
        help="a size of the shape, such as radius=2mm; may be repeated",
    )  # fmt: skip
    add(
        "-o", "--output", metavar="FILE", type=Path,
        help="file of the spheres: .csv has commas, as Chrono wants them, others blanks, as LIGGGHTS does "
        "(default: the name of the mesh or shape, .csv)",
    )  # fmt: skip
    add("--picture", action="store_true", help="draw the clump in a .png beside the file")
    add("--force", action="store_true", help="overwrite files that are there")
    add("--json", action="store_true", help="show the report as a JSON object")
    return parser


def clump_options(arguments: Sequence[str]) -> ClumpOptions:
    """Return what follows ``clump``.

    Raises:
        PackgenError: Options do not go together, or there is no such mesh.
    """
    given = vars(build_clump_parser().parse_args(arguments))
    sizes, as_json = dict(given.pop("set")), given.pop("json")
    options = ClumpOptions(**given, sizes=sizes, as_json=as_json)
    _refuse(options)
    return options


def _refuse(options: ClumpOptions) -> None:
    """Refuse options that do not go together.

    Raises:
        PackgenError: They do not.
    """
    name = options.source
    limits = (options.spheres, options.volume_error, options.surface_error)
    if options.is_shape and options.units is not None:
        raise PackgenError(f"--units: found {name}, which has its lengths by --set, expected a mesh")
    if not options.is_shape and options.sizes:
        raise PackgenError(f"--set: found the mesh {name}, expected a shape: {', '.join(SHAPE_SIZES)}")
    if not options.is_shape and not Path(name).is_file():
        raise PackgenError(
            f"clump: found no file {name}, expected a closed mesh or a shape: {', '.join(SHAPE_SIZES)}"
        )
    if all(each is None for each in limits) and name not in {"dumbbell", "rod", "tetrapod", "ring"}:
        raise PackgenError(
            "clump: found no limit, expected --spheres N, --volume-error E or --surface-error E"
        )
    if options.volume_error is not None and options.surface_error is not None:
        raise PackgenError("--surface-error: found --volume-error as well, expected one of them")
    if options.surface_error is not None and (options.equal or options.best_fit):
        other = "--equal" if options.equal else "--best-fit"
        raise PackgenError(f"{other}: found --surface-error as well, expected --spheres or --volume-error")
    _refuse_files(options)


def _refuse_files(options: ClumpOptions) -> None:
    """Refuse files that cannot be written.

    Raises:
        PackgenError: One cannot.
    """
    for path in options.files:
        if not options.is_shape and path.resolve() == Path(options.source).resolve():
            raise PackgenError(f"-o: found {path}, which is the mesh, expected another file")
        if path == options.target and path.suffix in {".json", ".png"}:
            raise PackgenError(f"-o: found {path}, expected the name of a table, such as {path.stem}.csv")
        if path.is_dir():
            raise PackgenError(
                f"{path}: found a folder, expected the name of a file to write; give it with -o"
            )
        if path.exists() and not options.force:
            raise PackgenError(
                f"{path}: is there already; choose another file with -o, or overwrite it by --force"
            )
        if not path.parent.is_dir():
            raise PackgenError(f"{path}: found no folder {path.parent}, expected one that is there; make it")


def run_clump_command(_command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run ``packgen clump``.

    Args:
        _command: Its name.
        arguments: What follows it.
        ending: Told what is written.

    Returns:
        The exit code.

    Raises:
        PackgenError: The mesh or an option is wrong.
    """
    options = clump_options(arguments)
    refuse_unreadable([options.target.name])
    clump = _made(options)
    from packgen.clumps import write_template
    from packgen.clumps.report import fit_content, fit_rows

    content = fit_content(clump.template, clump.fit, _source(options))
    content["missed"] = list(clump.missed)
    write_template(options.target, clump.template)
    options.files[1].write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    code = 1 if clump.missed else 0
    ending.done(code, f"the clump is {options.target}")
    undrawn = _draw(options, clump)
    if options.as_json:
        say_json(content)
    else:
        of = "mesh" if clump.surface is not None else "union"
        say(table(fit_rows(clump.template, clump.fit, of)), sys.stdout)
        for path in options.files[: 2 if undrawn else None]:
            say(f"written: {path}", sys.stdout)
    for line in (*clump.missed, *undrawn):
        say(f"packgen: {line}", sys.stderr)
    return 1 if undrawn else code


def _made(options: ClumpOptions) -> Clump:
    """Make the clump."""
    from packgen.clumps import make_clump, shape_of

    source = shape_of(options.source, options.sizes) if options.is_shape else Path(options.source)

    def warn(text: str) -> None:
        say(f"packgen: {text}", sys.stderr)

    clump = make_clump(
        source, _wanted(options), name=options.target.stem, units=options.units or "m", warn=warn
    )
    asked = options.spheres
    if (
        asked is not None
        and clump.template.count < asked
        and options.volume_error is options.surface_error is None
    ):
        warn(f"{asked} spheres asked for, {clump.template.count} already cover all that can be told apart")
    return clump


def _wanted(options: ClumpOptions) -> Wanted | None:
    """Return what is asked for; None: nothing."""
    from packgen.clumps import Wanted

    nothing = ClumpOptions(options.source)
    names = ("spheres", "volume_error", "surface_error", "least_radius", "equal", "best_fit")
    given: dict[str, Any] = {name: getattr(options, name) for name in names}
    if given == {name: getattr(nothing, name) for name in names}:
        return None
    if options.is_shape and all(given[name] is None for name in names[:3]):
        raise PackgenError(f"clump: {options.source}: found no number of spheres, expected --spheres N")
    return Wanted(**given)


def _source(options: ClumpOptions) -> dict[str, Any]:
    """Return what was asked for as plain data."""
    asked = asdict(options)
    skipped = ("output", "picture", "force", "as_json") + (("units",) if options.is_shape else ("sizes",))
    return {key: value for key, value in asked.items() if key not in skipped}


def _draw(options: ClumpOptions, clump: Clump) -> tuple[str, ...]:
    """Draw the clump where a picture is wanted; return why there is none."""
    if not options.picture:
        return ()
    from packgen.page.clump_picture import write_clump_picture

    surface, place = clump.surface, clump.template.place
    try:
        write_clump_picture(
            options.files[-1],
            clump.template.spheres,
            None if surface is None else surface.vertices - place,
            None if surface is None else surface.faces,
        )
    except PackgenError as error:
        return (str(error),)
    return ()


def _size(text: str) -> tuple[str, float]:
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected SIZE=LENGTH, such as radius=2mm")
    return name.strip(), length(value)
