"""The options of exporters, as the command line gives them: ``--export-option NAME.KEY=VALUE``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from packgen.errors import ExportError


def export_settings(
    exporters: Mapping[str, Any], given: Sequence[str], templates: Path | None
) -> dict[str, Any]:
    """Return the options of each exporter.

    Args:
        exporters: The exporters of this run by name.
        given: Texts ``NAME.KEY=VALUE``; the last one of a key counts.
        templates: The user's templates, for exporters that have any.

    Raises:
        ExportError: A text is none of that form, or names what is not exported or no option, or its value is
            wrong; all of them at once.
    """
    values: dict[str, dict[str, Any]] = {name: {} for name in exporters}
    problems = []
    for text in given:
        place, equals, value = text.partition("=")
        name, dot, key = place.strip().partition(".")
        if not (equals and dot and key):
            problems.append(f"--export-option: found {text!r}, expected NAME.KEY=VALUE")
        elif name not in values:
            exported = ", ".join(exporters) or "nothing"
            problems.append(
                f"--export-option: found {text!r}, but {exported} is exported; add --export {name}"
            )
        else:
            values[name][key] = value.strip()
    settings = {}
    for name, exporter in exporters.items():
        if templates is not None and "templates" in getattr(exporter.Options, "model_fields", {}):
            values[name]["templates"] = templates.resolve()
        try:
            settings[name] = exporter.Options(**values[name])
        except (ValueError, TypeError) as error:  # pydantic's is a ValueError; a plug-in's may be another
            problems += [f"--export-option: {name}{line}" for line in _faults(error)]
    if problems:
        raise ExportError("\n".join(problems))
    return settings


def _faults(error: Exception) -> list[str]:
    """Return what follows an exporter's name in one line for each wrong option, or for options that clash."""
    errors = getattr(error, "errors", None)
    if errors is None:
        return [f".{error}"]
    return [
        f".{'.'.join(map(str, each['loc']))}: found {each['input']!r}, {each['msg']}"
        if each["loc"]
        else f": {each['msg'].removeprefix('Value error, ')}"
        for each in errors()
    ]
