"""What all decks share: templates, the text that may stand in a comment, and the checks of a bed.

The templates are Jinja2 files in one folder a solver. They place values; arithmetic is done in Python, and
rows of spheres are written in Python (``exporters.shared.lammps_data``).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from jinja2 import ChoiceLoader, Environment, FileSystemLoader, StrictUndefined, TemplateError
from pydantic import BaseModel, ConfigDict

from exporters.protocol import ALL_NEEDS
from exporters.shared.clumps import refuse_clumps
from packgen.bed import AnyBed, numbered
from packgen.errors import ExportError

COMMENT_LENGTH_MAX = 100


class DeckOptions(BaseModel):
    """Options of every exporter that fills templates.

    Attributes:
        templates: A folder of the user's own templates, laid out as ours (``liggghts/in.bed.j2``); a template
            that is found there is taken instead of ours.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    templates: Path | None = None


def template_root() -> Path:
    """Return the folder of the templates: inside the installed package, else that of the checkout."""
    installed = Path(str(files("exporters") / "templates"))
    return installed if installed.is_dir() else Path(__file__).resolve().parents[2] / "templates"


def render(template: str, values: dict[str, Any], user_folder: Path | None = None) -> str:
    """Return the text of a template with its values filled in.

    Args:
        template: Name below the template folder, for example ``liggghts/in.bed.j2``.
        values: What the template places; a name that it uses and that is missing here is an error.
        user_folder: The user's own templates, searched first.

    Raises:
        ExportError: The user's folder does not exist, or a template is wrong.
    """
    check_templates(user_folder)
    folders = [folder for folder in (user_folder, template_root()) if folder is not None]
    environment = Environment(
        loader=ChoiceLoader([FileSystemLoader(folder, encoding="utf-8") for folder in folders]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    try:
        return environment.get_template(template).render(values)
    except TemplateError as error:
        line = getattr(error, "lineno", None)
        place = template if line is None else f"{template}:{line}"
        raise ExportError(f"templates: {place}: {error}") from error


def check_templates(user_folder: Path | None) -> None:
    """Refuse a folder of templates that does not exist.

    Raises:
        ExportError: It does not exist.
    """
    if user_folder is not None and not user_folder.is_dir():
        raise ExportError(f"templates: {user_folder} is not a folder")


def comment_text(value: object) -> str:
    """Return ``value`` as text that cannot leave a comment or a quoted string of any deck.

    Characters other than letters, digits and ``space . _ , : = + - / ( )`` become underscores, line ends
    included: ``$`` would be replaced by a solver's variable, ``&`` would continue the line.
    """
    return re.sub(r"[^A-Za-z0-9 ._,:=+\-/()]", "_", str(value))[:COMMENT_LENGTH_MAX].strip() or "_"


def different_words(names: Sequence[str], taken: Sequence[str] = ()) -> list[str]:
    """Return names as words of letters, digits and underscores, all different and none of those taken.

    Of names that would be one word the later ones get their place among the names behind them, from 0.
    """
    words: list[str] = []
    for place, name in enumerate(names):
        stem = word = re.sub(r"[^A-Za-z0-9_]", "_", name) or "set"
        number = place
        while word in words or word in taken:
            word, number = f"{stem}_{number}", number + 1
        words.append(word)
    return words


def provenance_values(bed: AnyBed) -> dict[str, str]:
    """Return version, scene and seed of a bed for the head of a deck, each safe in a comment."""
    scene = bed.provenance.get("scene", "unknown")
    name = PurePath(scene).name if isinstance(scene, str | PurePath) else "unknown"
    return {
        "version": comment_text(bed.provenance.get("packgen", "unknown")),
        "scene": comment_text(name),
        "seed": comment_text(bed.provenance.get("seed", "unknown")),
    }


def check_exportable(
    bed: AnyBed, solver: str, needs: Sequence[str] = ALL_NEEDS, *, clumps: bool = False
) -> None:
    """Refuse a bed that no solver can load, and one from elsewhere that lacks what the format writes.

    Args:
        bed: The bed.
        solver: What messages call the format.
        needs: What the format writes beside the spheres.
        clumps: Whether the format has rigid clumps.

    Raises:
        ExportError: The bed is empty, has clumps that the format has not, a position is not finite, a radius
            or density is not finite and positive, or materials or walls are not known.
    """
    if bed.count == 0:
        raise ExportError(f"{solver}: the bed holds no spheres; {solver} cannot load an empty bed")
    if not clumps:
        refuse_clumps(bed, solver)
    problems: list[str] = []
    problems += _wrong_spheres(bed)
    problems += [
        f"density of set {each.name} is {each.density} kg/m3, expected more than 0"
        for each in bed.particle_sets
        if "density" in needs and not (np.isfinite(each.density) and each.density > 0)
    ]
    if "materials" in needs and not bed.materials:
        problems.append("the materials are not known, expected those of spheres and walls")
    if "walls" in needs and not bed.container.walls_known:
        problems.append("the walls are not known, expected the container of the bed")
    if problems:
        raise ExportError("\n".join(f"{solver}: {problem}" for problem in problems))


def _wrong_spheres(bed: AnyBed) -> list[str]:
    """Return a line for the first sphere without a position, and one for the first without a radius."""
    problems: dict[str, str] = {}
    for start, chunk in numbered(bed):
        wrong = np.flatnonzero(~np.isfinite(chunk.position).all(axis=1))
        if len(wrong):
            place = chunk.position[wrong[0]].tolist()
            line = f"position of sphere {start + wrong[0] + 1} is {place}, expected numbers"
            problems.setdefault("position", line)
        wrong = np.flatnonzero(~(np.isfinite(chunk.radius) & (chunk.radius > 0)))
        if len(wrong):
            radius = chunk.radius[wrong[0]]
            line = f"radius of sphere {start + wrong[0] + 1} is {radius} m, expected more than 0"
            problems.setdefault("radius", line)
    return [problems[each] for each in ("position", "radius") if each in problems]


def write_text(path: Path, text: str) -> Path:
    """Write a deck's text with Unix line ends, and return its path."""
    path.write_text(text, encoding="ascii", errors="replace", newline="\n")
    return path
