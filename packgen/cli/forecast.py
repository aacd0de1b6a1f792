"""``packgen plan SCENE``: what the bed will be like, before it is made."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from packgen.cli.ending import Ending
from packgen.cli.names import refuse_unreadable
from packgen.cli.options import add_changes, command_parser
from packgen.cli.run import warn
from packgen.cli.screen import say, say_json, table
from packgen.errors import PackgenError, PackingError

if TYPE_CHECKING:
    from packgen.forecast import Forecast
    from packgen.scene import Scene

PAGE = "plan.html"
DESCRIPTION = "Tell what the bed of a scene will be like, and what will be missed; nothing is packed."
EPILOG = """exit codes: 0 all that is asked for will fit; 1 something will be missed, and the last lines say
what; 2 wrong input, nothing written"""


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """The options of ``packgen plan``.

    Attributes:
        scene: The scene file.
        changes: Values in place of the scene's, each ``KEY=VALUE``.
        output: The page.
        page: Whether to write it.
        json: Whether to show the plan as JSON.
    """

    scene: Path
    changes: tuple[str, ...] = ()
    output: Path = Path(PAGE)
    page: bool = True
    json: bool = False


def build_plan_parser() -> argparse.ArgumentParser:
    """Return the parser of ``packgen plan``."""
    parser = command_parser("plan", DESCRIPTION, EPILOG)
    parser.add_argument("scene", metavar="SCENE", type=Path, help="scene file (YAML)")
    add_changes(parser)
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=Path,
        default=Path(PAGE),
        help="page to write (default: plan.html)",
    )
    parser.add_argument("--no-page", action="store_true", help="write no page")
    parser.add_argument("--json", action="store_true", help="show the plan as a JSON object")
    return parser


def run_plan_command(_command: str, arguments: Sequence[str], ending: Ending) -> int:
    """Run ``packgen plan``.

    Args:
        _command: Its name; there is but one.
        arguments: What follows it.
        ending: Told when the page is written.

    Returns:
        The exit code: 1 where something will be missed.

    Raises:
        PackgenError: A run of the scene would be refused.
    """
    parsed = build_plan_parser().parse_args(arguments)
    options = PlanOptions(parsed.scene, tuple(parsed.set), parsed.output, not parsed.no_page, parsed.json)
    refuse_unreadable([options.output.name])
    if options.page:
        _check_page(options.output)
    from packgen.scene import load_scene

    scene = load_scene(options.scene, options.changes)
    found = _forecast(scene)
    from packgen.forecast.telling import as_data, rows

    page = _write(options.output, scene, found) if options.page else None
    code = int(bool(found.missed))
    ending.done(code, "nothing was written" if page is None else f"the plan is in {page}")
    if options.json:
        say_json({"exit_code": code, **as_data(found, scene), "page": None if page is None else str(page)})
    else:
        say(table(rows(found)), sys.stdout)
        if page is not None:
            say(f"written: {page}", sys.stdout)
    for line in found.warnings:
        warn(line)
    for line in found.missed:
        say(f"packgen: will be missed: {line}", sys.stderr)
    return code


def _check_page(page: Path) -> None:
    """Refuse a page that cannot be written, or is somebody else's.

    Raises:
        PackgenError: It is one.
    """
    if page.is_dir():
        raise PackgenError(f"{page}: found a folder, expected the name of a file to write; give it with -o")
    if not page.parent.is_dir():
        raise PackgenError(f"{page}: found no folder {page.parent}, expected one that is there; make it")
    if page.exists() and b'name="generator" content="packgen' not in page.read_bytes()[:1000]:
        raise PackgenError(f"{page}: exists and is no page of packgen; choose another file with -o")


def _forecast(scene: Scene) -> Forecast:
    """Return the forecast of a scene; what was mended of its container comes first."""
    from dataclasses import replace

    from packgen.cli.run import explained
    from packgen.container import load_container
    from packgen.forecast import forecast, remedies

    said: list[str] = []
    with explained(said):
        container = load_container(scene, said.append)
        mended = tuple(said)
        try:
            found = forecast(scene, container, said.append)
        except PackingError as error:
            raise PackingError("\n".join([str(error), *remedies(scene, container)])) from error
    return replace(found, warnings=(*mended, *found.warnings))


def _write(page: Path, scene: Scene, found: Forecast) -> Path:
    from packgen.forecast.costs import RULE
    from packgen.forecast.telling import rows
    from packgen.page.plan import plan_html

    text = plan_html(scene.path.stem, found, rows(found), RULE)
    partial = page.with_name(f".{page.name}.unfinished")
    try:
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, page)
    finally:
        partial.unlink(missing_ok=True)
    return page
