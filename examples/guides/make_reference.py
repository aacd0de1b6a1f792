"""Write reference.md from the schema, the parser and the docstrings: ``python make_reference.py``.

Nothing is said here that packgen does not say itself, so that the page changes with the code; a test holds
the page against what this script makes of today's code.
"""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import re
import types
import typing
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import BaseModel

import exporters
from packgen import bedfile, report
from packgen.arrange import registry
from packgen.arrange.advancing_front import params as front_params
from packgen.bed import Material
from packgen.cli import DESCRIPTION, EPILOG, build_parser
from packgen.cli.clump import CLUMP_EPILOG, build_clump_parser
from packgen.cli.contest import build_contest_parser
from packgen.cli.files import CARVE, CONVERT, DESCRIPTIONS, MEASURE, REPEAT, build_file_parser
from packgen.cli.forecast import build_plan_parser
from packgen.cli.reshape import CARVE_EPILOG, REPEAT_EPILOG, build_carve_parser, build_repeat_parser
from packgen.cli.start import build_init_parser
from packgen.cli.sweep import build_sweep_parser
from packgen.forecast import Forecast, SetForecast, ZoneForecast
from packgen.reading import dump, extxyz, lammps_data, mfix, npz, vtk
from packgen.reading import table as table_of_text
from packgen.scene import document, models, sets, shapes
from packgen.scene import walls as wall_models
from packgen.summary import FIGURES, main_figures
from packgen.summary import summary as summary_of_run
from packgen.units import UNITS
from packgen.validation import results as validation

PAGE = Path(__file__).resolve().parent / "reference.md"

# The kinds of values in packgen.values, by name; one that is missing here stops the script.
KINDS = {
    "Any": "mapping, see `params`",
    "Acceleration": "acceleration > 0 [m/s2]",
    "AutoOrFlag": "auto, true or false",
    "AxisIndex": "0, 1, 2 or x, y, z",
    "BedPath": "file of spheres or result folder, relative to the scene",
    "Count": "whole number > 0",
    "Density": "density > 0 [kg/m3]",
    "Direction": "x, y, z (up), -x, -y, -z, or the vector that points down",
    "FileOrCount": "file, relative to the scene, or a whole number from 1 to 1000",
    "FilePath": "file, relative to the scene",
    "Flag": "true or false",
    "Fraction": "number from 0 to 1",
    "Frequency": "frequency > 0 [Hz]",
    "Fractions": "list of numbers from 0 to 1",
    "InnerFraction": "number between 0 and 1",
    "LeastGap": "number of radii >= 0, a length with its unit, or a mapping, see `gap`",
    "Length": "length [m]",
    "LengthUnit": "m, cm, mm, um, in or ft",
    "Lengths": "list of lengths > 0 [m]",
    "Mass": "mass > 0 [kg]",
    "Name": "name",
    "NonNegative": "number >= 0",
    "NonNegativeLength": "length >= 0 [m]",
    "Period": "time > 0 [s]",
    "Periodic": "list of axes, such as [x, y]",
    "Point": "[x, y, z], lengths [m]",
    "PoissonsRatio": "number from 0 to 0.5",
    "Positive": "number > 0",
    "PositiveLength": "length > 0 [m]",
    "Pressure": "pressure > 0 [Pa]",
    "PrimitiveAxis": "axis, such as z, -x or [1, 0, 1]",
    "RatioOfVoids": "number > 0, or a mapping, see `void_ratio`",
    "Seed": "whole number >= 0",
    "ShareOfSpace": "number between 0 and 1, or a mapping, see `solid_fraction`",
    "SolidVolume": "volume > 0 [m3]",
    "StartFrom": "file of spheres or result folder, or a mapping, see `start_from`",
    "Tile": "auto, or a number >= 20 of largest diameters",
    "Tolerance": "number between 0 and 1",
    "Turning": "random, aligned, or an axis, such as z, -x or [1, 0, 1]",
    "Velocity": "[vx, vy, vz], velocities [m/s]",
    "WholeNumber": "whole number >= 0",
    "str": "text",
}
FIGURE_NAMES = ", ".join(f"`{each}`" for each in FIGURES)
SECTIONS = {
    "BoxSpec": "box",
    "CylinderSpec": "cylinder",
    "ConeSpec": "cone",
    "SphereSpec": "sphere",
    "SliceSpec": "slice",
    "ContainerSpec": "container",
    "LocationSpec": "location",
    "WallSpec": "walls[]",
    "MoveSpec": "move",
    "RotateSpec": "rotate",
    "LinearSpec": "linear",
    "VibrateSpec": "vibrate",
    "StartSpec": "start_from",
    "ZoneSpec": "zones[]",
    "FractionSpec": "solid_fraction",
    "RatioSpec": "void_ratio",
    "GapSpec": "gap",
    "MaterialSpec": "materials.NAME",
    "ValidationSpec": "validation",
    "FillSpec": "params.fill",
    "ParticleSetSpec": "particle_sets[]",
    "ShapeSpec": "shape",
}
OF_SETS = ("ParticleSetSpec", "ShapeSpec")
FILES = (
    ("`bed.npz`", "the spheres as plain arrays, see below"),
    (
        "`manifest.json`, `pieces/`",
        "with `--pieces`, in place of `bed.npz`: an archive of the same arrays a piece, and their list",
    ),
    ("`report.json`", "what was asked and what was reached, see below"),
    ("`report.html`", "the same to look at; not with `--no-report`"),
    ("`NAME/`", "a folder for each `--export NAME`, and for each solver of `--settle` and `--validate`"),
    (
        "`NAME.parts/`",
        "beside it, with `--workers` and `--scheduler`: what is done, for `--resume`; gone in the end",
    ),
    (
        "`SOLVER/settled.*`",
        "with `--settle SOLVER`: the solver's own state of the settled bed, from which it goes on",
    ),
    ("`validation.json`", "with `--validate`: what each solver measured, see below"),
)


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    return (
        "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
        + "\n"
    )


def plain(text: str) -> str:
    """Return a docstring's text with its code marked as Markdown does, and null for Python's None."""
    text = re.sub(r"\bNone\b", "null", re.sub(r"\s+", " ", text).strip())
    return re.sub(r"`+([^`]+)`+", r"`\1`", text)


def summary(item: Any) -> str:
    """Return what a docstring says before its sections."""
    return plain(
        re.split(r"\n\s*(?:Attributes|Args|Returns|Raises|Example):+", inspect.getdoc(item) or "")[0]
    )


def attributes(item: type) -> dict[str, str]:
    """Return the meanings that the docstrings of a class and its bases give their attributes."""
    found: dict[str, str] = {}
    for base in reversed(item.__mro__):
        parts = re.split(r"\n\s*Attributes:\n", inspect.cleandoc(base.__doc__ or ""))
        if len(parts) < 2 or base.__module__.split(".")[0] not in {"packgen", "exporters"}:
            continue
        entries = re.split(r"^    (?=\w+:)", parts[1].split("\n\n")[0], flags=re.MULTILINE)
        for entry in filter(str.strip, entries):
            name, meaning = entry.split(":", 1)
            found[name.strip()] = plain(meaning)
    return found


def kind(annotation: str) -> str:
    """Return in words what a key of the scene may hold."""
    annotation = re.sub(r"Annotated\[(.*), \w+\(.*\)\]", r"\1", annotation).replace(" | None", "")
    literal = re.fullmatch(r"Literal\[(.*)\]", annotation)
    if literal:
        return ", ".join(f"`{each.strip()[1:-1]}`" for each in literal[1].split(","))
    many = re.fullmatch(r"tuple\[(\w+), \.\.\.\]|dict\[Name, (\w+)\]", annotation)
    if many:
        one = kind(many[1] or many[2])
        return f"list of {one}" if many[1] else f"mapping of names to {one}"
    if hasattr(shapes, annotation) and annotation not in SECTIONS and annotation not in KINDS:
        return "mapping of lengths, see below"
    if annotation in SECTIONS:
        return f"mapping, see `{SECTIONS[annotation]}`"
    return KINDS[annotation]


def default(field: Any) -> str:
    """Return a key's default as YAML has it; nothing where the key may be left out, ``required`` else."""
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if value is None or value == "" or isinstance(value, (dict, BaseModel)):
        return ""
    if isinstance(value, tuple) and (not value or isinstance(value[0], BaseModel)):
        return ""
    if value in {
        (0.0, 0.0, -1.0),
        (0.0, 0.0, 1.0),
    }:  # down as gravity_axis z says it, and the axis of a primitive
        return "z"
    if isinstance(value, tuple) and all(isinstance(each, bool) for each in value):
        return ""
    return (
        str(value).lower()
        if isinstance(value, bool)
        else str(list(value))
        if isinstance(value, tuple)
        else f"{value:g}"
        if isinstance(value, float)
        else str(value)
    )


def keys_of(model: type) -> str:
    """Return the table of a mapping of the scene."""
    meaning, annotations = attributes(model), {}
    if model is models.MaterialSpec:  # most of its keys are a material's own attributes
        meaning = attributes(Material) | meaning
    for base in reversed(model.__mro__):
        annotations |= inspect.get_annotations(base)
    rows = [
        (f"`{name}`", kind(annotations[name]), default(field), meaning.get(name, ""))
        for name, field in model.model_fields.items()  # type: ignore[attr-defined]
    ]
    columns = 4 if any(row[3] for row in rows) else 3  # what a class says in one sentence needs no column
    return table(("key", "value", "default", "meaning")[:columns], [row[:columns] for row in rows])


def is_shape(kind: Any) -> bool:
    """Return whether a kind of value is a shape's mapping of lengths."""
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def scene_part() -> Iterator[str]:
    """The scene file."""
    yield "## The scene file\n"
    yield f"{summary(document.SceneFile)}\n"
    yield keys_of(document.SceneFile)
    for name, path in SECTIONS.items():
        if name in OF_SETS:
            continue
        places = (wall_models, models, front_params)
        model = next(getattr(place, name) for place in places if hasattr(place, name))
        yield f"### `{path}`\n\n{summary(model)}\n"
        yield keys_of(model)
    for name in registry.BUILTIN:
        model = registry.find(name).params
        yield f"### `params` of {name}\n\n{summary(model)}\n"
        yield keys_of(model)
    yield f"### `particle_sets[]`\n\n{summary(sets.SetKeys)}\n"
    yield keys_of(sets.SetKeys)
    yield "`radius_distribution`, and the keys that it takes besides:\n"
    rows = []
    of_files = [each for each in sets.SetKeys.__subclasses__() if each.__module__ == sets.__name__]
    for model in of_files:
        own = {
            name: field for name, field in model.model_fields.items() if name not in sets.SetKeys.model_fields
        }
        law = typing.get_args(own.pop("radius_distribution").annotation)[0]
        named = ", ".join(
            f"`{name}`" + ("" if field.is_required() else " (optional)") for name, field in own.items()
        )
        rows.append((f"`{law}`", named, summary(model)))
    yield table(("law", "keys", "meaning"), rows)
    yield f"### `shape`\n\n{summary(shapes.ShapeSpec)}\n"
    yield keys_of(shapes.ShapeSpec)
    yield "Shapes by name, and their lengths; the set's law scales them:\n"
    rows = []
    for name, field in shapes.ShapeSpec.model_fields.items():
        model = next((each for each in typing.get_args(field.annotation) if is_shape(each)), None)
        if model is not None:
            rows.append((f"`{name}`", ", ".join(f"`{key}`" for key in model.model_fields), summary(model)))
    yield table(("shape", "lengths", "meaning"), rows)
    yield "Units that a value may carry, the SI unit first:\n"
    yield table(
        ("quantity", "units"),
        [(name, ", ".join(f"`{each}`" for each in units)) for name, units in UNITS.items() if units],
    )


def arguments_of(parser: argparse.ArgumentParser) -> list[tuple[str, str]]:
    """Return a row for each argument of a parser."""
    rows = []
    for action in parser._actions:
        if isinstance(action, argparse._HelpAction):
            continue
        shown = f"{'/'.join(action.choices)}" if action.choices else str(action.metavar or "")
        names = ", ".join(f"`{each}`" for each in action.option_strings) or f"`{action.metavar}`"
        value = f" `{shown}`" if shown and action.option_strings and action.nargs != 0 else ""
        rows.append((names + value, action.help or ""))
    return rows


def file_part() -> Iterator[str]:
    """Beds from files."""
    yield f"## Beds from files\n\n`packgen measure FILE`: {DESCRIPTIONS[MEASURE]}\n"
    measures, converts = (arguments_of(build_file_parser(each)) for each in (MEASURE, CONVERT))
    yield table(("argument", "meaning"), measures)
    yield f"`packgen convert FILE`: {DESCRIPTIONS[CONVERT]}\n"
    yield "It takes the same arguments but `--tolerance`, and:\n"
    yield table(("argument", "meaning"), [row for row in converts if row not in measures])
    parts = ((CARVE, build_carve_parser(), CARVE_EPILOG), (REPEAT, build_repeat_parser(), REPEAT_EPILOG))
    known = {*measures, *converts}
    for name, parser, epilog in parts:
        yield f"`packgen {name}`: {DESCRIPTIONS[name]}\n"
        yield "It takes the arguments of `measure` and `convert`, `FILE` may be a result folder, and:\n"
        yield table(
            ("argument", "meaning"),
            [row for row in arguments_of(parser) if row not in known and row[0] != "`FILE`"],
        )
        for paragraph in epilog.split("\n\n")[:-1]:  # the last one has the exit codes
            yield f"{paragraph[0].upper()}{plain(paragraph[1:])}\n"
    yield "Files that are read:\n"
    readers = (npz, table_of_text, lammps_data, dump, vtk, extxyz, mfix)
    yield table(("format",), [(plain((each.__doc__ or "").split("\n\n")[0]),) for each in readers])


def clump_part() -> Iterator[str]:
    """Clumps."""
    parser = build_clump_parser()
    yield "## Clumps\n"
    yield f"`packgen clump MESH`: {(parser.description or '').split(' A scene of that name')[0]}\n"
    yield table(("argument", "meaning"), arguments_of(parser))
    for paragraph in CLUMP_EPILOG.split("\n\n")[:-1]:  # the last one has the exit codes
        yield f"{paragraph[0].upper()}{plain(paragraph[1:])}\n"


def ahead_part() -> Iterator[str]:
    """What comes before runs, and many of them."""
    yield "## Before a run, and many runs\n"
    for name, parser in (
        ("plan SCENE", build_plan_parser()),
        ("init KIND", build_init_parser()),
        ("sweep SCENE", build_sweep_parser()),
        ("contest SCENE", build_contest_parser()),
    ):
        yield f"`packgen {name}`: {(parser.description or '').split(' A scene of that name')[0]}\n"
        yield table(("argument", "meaning"), arguments_of(parser))
    yield "`packgen schema`: Show the JSON Schema of scenes, for editors.\n"
    yield "### `packgen plan --json`\n\nBeside scene, algorithm, seed, version, `exit_code` and `page`:\n"
    rows = []
    for prefix, item in (("", Forecast), ("zones[].", ZoneForecast)):
        skipped = {"container", "up", "zones", "sets", "cost", "locations", "factor"}
        rows += [(f"`{prefix}{key}`", said) for key, said in attributes(item).items() if key not in skipped]
    rows += [
        ("`sphere_count`, `mass`, `solid_fraction`", "The same of all zones together."),
        ("`sets[]`", summary(SetForecast)),
        ("`container`", f"`name`, `size` [m], `volume` [m3], and `factor`. {attributes(Forecast)['factor']}"),
        ("`seconds`, `memory`, `rule`", "Time [s] and memory [bytes], and by what rule."),
    ]
    yield table(("key", "meaning"), rows)
    yield f"### `--json` and `sweep.csv`\n\n`--json` of a run: {returned(summary_of_run)}\n"
    yield f"The main figures: {FIGURE_NAMES}. {returned(main_figures)}\n"
    yield "`sweep.csv` has them after `folder`, the keys and `exit_code`, and `message` at last.\n"


def returned(function: Any) -> str:
    """Return what a docstring says that a function returns."""
    found = re.search(r"Returns:\n(.*?)(\n\n|\Z)", inspect.getdoc(function) or "", re.DOTALL)
    return plain(found[1]) if found else ""


def command_part() -> Iterator[str]:
    """The command line."""
    yield f"## The command\n\n{DESCRIPTION}\n"
    yield table(("argument", "meaning"), arguments_of(build_parser()))
    others, codes = EPILOG.split("exit codes:")
    commands = [
        re.split(r"\s{2,}", line.strip(), maxsplit=1) for line in others.splitlines()[1:] if line.strip()
    ]
    yield table(("other command", "meaning"), [(f"`{name}`", meaning) for name, meaning in commands])
    yield "Exit codes:\n"
    yield table(("code", "meaning"), [tuple(each.strip().split(" ", 1)) for each in codes.split(";")])  # type: ignore[misc]


def parts_of(hint: Any) -> tuple[type | None, str]:
    """Return the dataclass inside a type, if there is one, and the brackets that its place in JSON has."""
    if dataclasses.is_dataclass(hint):
        return typing.cast("type", hint), ""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is tuple and arguments[-1] is Ellipsis:
        inner = parts_of(arguments[0])
        return (inner[0], "[]" + inner[1]) if inner[0] else (None, "")
    if origin in {typing.Union, types.UnionType}:
        for each in arguments:
            if parts_of(each)[0]:
                return parts_of(each)
    return None, ""


def json_rows(item: type, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Return a row for each key that a dataclass has as JSON, the keys of what it holds after their own."""
    meaning, hints = attributes(item), typing.get_type_hints(item)
    for field in dataclasses.fields(item):
        inner, brackets = parts_of(hints[field.name])
        path = f"{prefix}{field.name}{brackets}"
        said = meaning.get(field.name, "")
        if inner and not attributes(inner):
            said = f"{said} {summary(inner)}".strip()
        yield f"`{path}`", said
        if inner:
            yield from json_rows(inner, f"{path}.")


def properties(item: type, names: tuple[str, ...], prefix: str) -> Iterator[tuple[str, str]]:
    """Return rows for properties that are written beside the fields."""
    for name in names:
        yield f"`{prefix}{name}`", summary(getattr(item, name))


def result_part() -> Iterator[str]:
    """What a run leaves."""
    yield "## The result folder\n"
    yield table(("file", "content"), list(FILES))
    keys = re.search(r"Keys: (.*?)\n\n", inspect.getdoc(bedfile.save_bed) or "", re.DOTALL)
    yield f"`bed.npz`: {plain(keys[1]) if keys else ''}\n"
    yield "### `report.json`\n\nLengths in metres, overlaps and gaps as fractions of the smaller radius.\n"
    # The file has its keys in another order than the class.
    rows = sorted(json_rows(report.Report), key=lambda row: report.KEYS.index(re.split(r"\W", row[0])[1]))
    place = 1 + max(index for index, row in enumerate(rows) if row[0].startswith("`overlap."))
    rows[place:place] = properties(report.Check, ("within_tolerance",), "overlap.")
    yield table(("key", "meaning"), rows)
    yield "### `validation.json`\n\n`W` is the mean weight of a sphere, `r` its mean radius.\n"
    rows = [
        ("`passed`", "Whether every solver kept every limit."),
        ("`errors`", "Solvers that failed, and how."),
    ]
    solver = "solvers.NAME."
    rows += [(f"`{solver}passed`", summary(validation.SolverReport.passed))]
    rows += [(f"`{solver}missed`", summary(validation.SolverReport.missed))]
    for name, said in json_rows(validation.SolverReport, solver):
        if name != f"`{solver}solver`":
            rows.append((name, said))
        if name == f"`{solver}step_zero.worst_outside`":
            rows += properties(validation.StepZero, ("force_max",), f"{solver}step_zero.")
        if name == f"`{solver}gravity_run.height_change`":
            rows.append((f"`{solver}gravity_run.lost_count`", "Number of spheres that were lost."))
            rows += properties(validation.GravityRun, ("sinking_rest", "judged"), f"{solver}gravity_run.")
    yield table(("key", "meaning"), rows)


def exporter_part() -> Iterator[str]:
    """The exporters and their options."""
    yield "## Exporters\n\nOptions are given as `--export-option NAME.KEY=VALUE`.\n"
    rows = []
    for name, module in exporters.BUILTIN.items():
        found = import_module(module)
        options = attributes(found.Options)
        fields = getattr(found.Options, "model_fields", {})
        said = [f"`{key}`: {options.get(key, '')}" for key in fields if key != "templates"]
        rows.append((f"`{name}`", plain((found.__doc__ or "").split("\n\n")[0]), "<br>".join(said)))
    yield table(("name", "writes", "options"), rows)


def reference() -> str:
    """Return the text of the page."""
    parts = [
        "# Reference\n\nWritten by `make_reference.py` from the schema, the parser and the docstrings. "
        "How to use it all: [the tutorial](../README.md).\n",
        *scene_part(),
        *command_part(),
        *ahead_part(),
        *file_part(),
        *clump_part(),
        *result_part(),
        *exporter_part(),
    ]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
