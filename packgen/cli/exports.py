"""The exporters of a run: their options (``--export-option NAME.KEY=VALUE``), early checks, and decks."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from packgen.errors import ExportError
from packgen.resultfolder import DISK_FULL
from packgen.stopping import stop_seen

if TYPE_CHECKING:  # a scene with a fault must not wait for scipy
    from exporters import Exporter, Outlook
    from exporters.protocol import Place
    from packgen.bed import AnyBed
    from packgen.geometry import Container
    from packgen.scene import Scene
    from packgen.scene.sets import SetKeys


@dataclass(frozen=True, slots=True)
class Format:
    """An exporter with the options that it gets."""

    exporter: Exporter
    options: Any


def export_settings(
    exporters: Mapping[str, Any], given: Sequence[str], templates: Path | None
) -> dict[str, Any]:
    """Return the options of each exporter.

    Args:
        exporters: The exporters of this run by name.
        given: Texts ``NAME.KEY=VALUE``; the last one of a key counts.
        templates: The user's templates, for exporters that have any.

    Raises:
        ExportError: A text has another form, names a format that is not exported or an unknown option, or
            gives a wrong value; all faults at once.
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


def outlook_of(scene: Scene, container: Container) -> Outlook:
    """Return what exporters are told of a scene before the run."""
    import numpy as np

    from exporters import Outlook
    from packgen.bed import ParticleSet

    used = [
        each
        for index, each in enumerate(scene.particle_sets)
        if any(zone.set_proportions[index] > 0.0 for zone in scene.zones)
    ]
    names = {each.material for each in used}
    if not all(container.periodic):
        names |= {scene.wall_material, *(each.material for each in container.parts)}
    bounds = [_sphere_bounds(each) for each in used]
    return Outlook(
        container=container,
        gravity=scene.gravity * np.asarray(scene.gravity_direction, np.float64),
        particle_sets=tuple(
            ParticleSet(each.name, each.density, each.material) for each in scene.particle_sets
        ),
        materials=tuple(each for each in scene.materials if each.name in names),
        radius_min=min(low for low, _ in bounds),
        radius_max=max(high for _, high in bounds),
        place=scene.marked.place,
        wall_material=scene.wall_material,
        clumps=any(each.form is not None for each in used),
    )


def _sphere_bounds(each: SetKeys) -> tuple[float, float]:
    """Return the smallest and the largest radius that a sphere of a set may have [m]."""
    low, high = each.distribution.radius_bounds
    if each.form is None:
        return low, high
    radius = each.form.template.spheres[:, 3] / each.form.template.equivalent_radius
    return low * float(radius.min()), high * float(radius.max())


def outlook_of_bed(bed: AnyBed, place: Place) -> Outlook:
    """Return what exporters are told of a bed that is there already.

    Args:
        bed: The bed.
        place: Returns where a value of the scene, or of what stands for it, is.
    """
    from exporters import Outlook
    from packgen.bed import Bed, has_clumps

    counts = bed.census.counts
    used = {each.material for each, count in zip(bed.particle_sets, counts, strict=True) if count}
    if not all(bed.container.periodic):
        used |= {bed.wall_material, *(each.material for each in bed.container.parts)}
    return Outlook(
        container=bed.container,
        gravity=bed.gravity,
        particle_sets=bed.particle_sets,
        materials=tuple(each for each in bed.materials if each.name in used),
        radius_min=min(bed.census.radius_min),
        radius_max=max(bed.census.radius_max),
        place=place,
        wall_material=bed.wall_material,
        clumps=isinstance(bed, Bed) and has_clumps(bed),
    )


def check_formats(formats: Mapping[str, Format], outlook: Outlook) -> None:
    """Let each format refuse the scene before the run.

    Raises:
        ExportError: Some formats refuse it; the reasons of all.
    """
    from exporters.shared.clumps import WAYS

    problems = []
    for name, each in formats.items():
        if outlook.clumps and not each.exporter.CLUMPS:
            problems.append(f"{name}: the particles are clumps, which {name} does not write; {WAYS}")
            continue
        try:
            each.exporter.check_outlook(outlook, each.options)
        except ExportError as error:
            problems.append(str(error))
        except (Exception, SystemExit) as error:
            if stop_seen():
                raise
            problems.append(f"{name}: its check before the run failed, {type(error).__name__}: {error}")
    if problems:
        raise ExportError("\n".join(problems))


def check_whole(formats: Mapping[str, Format], count: int | None) -> None:
    """Refuse formats that take no bed in pieces, where it has too many spheres to be gathered.

    Args:
        formats: The formats.
        count: Number of spheres; None: not known yet.

    Raises:
        ExportError: There are such formats; a line each.
    """
    lines = [
        line for name, each in formats.items() if (line := _too_large(name, each, count or 0)) is not None
    ]
    if lines:
        raise ExportError("\n".join(lines))


def _too_large(name: str, each: Format, count: int) -> str | None:
    from packgen.pieces import GATHERED_MAX

    if each.exporter.STREAMS or count <= GATHERED_MAX:
        return None
    return (
        f"{name}: found a bed in pieces of {count:,} spheres, expected at most {GATHERED_MAX:,}: it takes "
        "the whole bed at once; leave it out, or take csv, which is written piece by piece"
    )


def _taken(bed: AnyBed, name: str, each: Format) -> AnyBed:
    """Return a bed as a format takes it: in pieces, or gathered.

    Raises:
        ExportError: It takes no pieces, and they are too many to be gathered.
    """
    from packgen.pieces import PieceBed

    if each.exporter.STREAMS or not isinstance(bed, PieceBed):
        return bed
    refused = _too_large(name, each, bed.count)
    if refused is not None:
        raise ExportError(refused)
    return bed.gathered()


def write_decks(bed: AnyBed, folder: Path, formats: Mapping[str, Format]) -> tuple[str, ...]:
    """Write a bed in each format, into a folder of the format's name.

    A deck that fails costs no bed: its folder is removed.

    Returns:
        A line for each deck that could not be written.

    Raises:
        OSError: The disk is full.
    """
    missed = []
    for name, each in formats.items():
        (folder / name).mkdir()
        try:
            each.exporter.write(_taken(bed, name, each), folder / name, each.options)
        except (Exception, SystemExit) as error:
            if getattr(error, "errno", None) in DISK_FULL or stop_seen():
                raise
            shutil.rmtree(folder / name)
            failed = f"its exporter or a template failed, {type(error).__name__}: {error}"
            missed.append(f"no {name} deck: {error if isinstance(error, ExportError) else failed}")
    return tuple(missed)
