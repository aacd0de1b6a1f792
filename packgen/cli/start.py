"""``packgen init`` and ``packgen schema``: a scene to start from, and what editors know of scenes."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from packgen.cli.ending import Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import command_parser, length
from packgen.cli.screen import say
from packgen.errors import PackgenError
from packgen.units import LENGTHS

INIT, SCHEMA = "init", "schema"


@dataclass(frozen=True, slots=True)
class StartOptions:
    """The options of ``packgen init``.

    Attributes:
        kind: ``box``, ``tube``, or the path of a mesh.
        output: The scene file; None: named after the kind.
        units: Unit of the mesh; None: a guess.
        radius: Radius of the spheres [m]; None: one that suits.
        force: Whether a file that is there is overwritten.
    """

    kind: str
    output: Path | None = None
    units: str | None = None
    radius: float | None = None
    force: bool = False

    @property
    def target(self) -> Path:
        """The scene file."""
        return self.output or Path(f"{Path(self.kind).stem}.yaml")


def build_init_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen init``."""
    parser = command_parser(INIT, "Write a commented scene that runs as it is.")
    parser.add_argument("kind", metavar="KIND", help="box, tube, or the path of a mesh such as vessel.stl")
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help="scene file (default: KIND.yaml, here)"
    )
    parser.add_argument("--units", choices=tuple(LENGTHS), help="unit of the mesh (default: a guess)")
    parser.add_argument("--radius", metavar="LENGTH", type=length, help="radius of the spheres, such as 5mm")
    parser.add_argument("--force", action="store_true", help="overwrite a file that is there")
    return parser


def build_schema_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen schema``."""
    return command_parser(SCHEMA, "Show the JSON Schema of scenes, for editors.")


def run_start_command(command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run one of the two commands.

    Args:
        command: ``init`` or ``schema``.
        arguments: What follows it.
        ending: Told what is written.

    Returns:
        The exit code.

    Raises:
        PackgenError: There is no such mesh, or the file is there already.
    """
    if command == SCHEMA:
        build_schema_parser().parse_args(arguments)
        say(schema_text().rstrip("\n"), sys.stdout)
        return 0
    parsed = build_init_parser().parse_args(arguments)
    return _init(StartOptions(parsed.kind, parsed.output, parsed.units, parsed.radius, parsed.force), ending)


def schema_text() -> str:
    """Return the JSON Schema of scenes as text."""
    from packgen.scene.schema import scene_schema

    return json.dumps(scene_schema(), indent=2, ensure_ascii=False) + "\n"


def _init(options: StartOptions, ending: Ending) -> int:
    target = options.target
    refuse_unreadable([target.name])
    _refuse_existing(target, force=options.force)
    from packgen.scene.schema import SCHEMA_NAME
    from packgen.starter import starter_scene

    found = starter_scene(options.kind, target, units=options.units, radius=options.radius)
    schema = target.parent / SCHEMA_NAME
    target.write_text(found.text, encoding="utf-8")
    ending.done(0, f"the scene is {target}")
    for line in found.remarks:
        say(f"packgen: {line}", sys.stderr)
    written = [target]
    if not schema.exists() or _is_ours(schema):
        schema.write_text(schema_text(), encoding="utf-8")
        written.append(schema)
    else:
        say(
            f"packgen: {schema} is not packgen's and stays as it is: editors may misjudge the scene",
            sys.stderr,
        )
    for path in written:
        say(f"written: {path}", sys.stdout)
    return 0


def _refuse_existing(target: Path, *, force: bool) -> None:
    if target.is_dir():
        raise PackgenError(f"{target}: found a folder, expected the name of a file to write; give it with -o")
    if target.exists() and not force:
        raise PackgenError(
            f"{target}: is there already; choose another file with -o, or overwrite it by --force"
        )
    if not target.parent.is_dir():
        raise PackgenError(f"{target}: found no folder {target.parent}, expected one that is there; make it")


def _is_ours(schema: Path) -> bool:
    """Return whether a file is a schema that packgen wrote."""
    return schema.is_file() and b'"$comment": "packgen' in schema.read_bytes()[:400]
