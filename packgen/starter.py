"""Scenes to start from: commented, and packed in seconds as they are."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.container.load import mesh_container
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackgenError
from packgen.filling.unit_remarks import extent_text, likely_units, usual_units
from packgen.geometry import Container
from packgen.scene.schema import SCHEMA_NAME
from packgen.units import LENGTHS

__all__ = ["KINDS", "Starter", "starter_scene"]

KINDS = ("box", "tube")

COUNT, COUNT_MAX = 1000, 2000  # spheres of a scene to start from
DIAMETERS = 8.0  # least width of a vessel, in diameters
LOOSE = 0.5  # solid fraction that every bed reaches


@dataclass(frozen=True, slots=True)
class Starter:
    """A scene to start from.

    Attributes:
        text: The scene file.
        remarks: What was guessed, a line each.
    """

    text: str
    remarks: tuple[str, ...] = ()


def starter_scene(
    kind: str, scene: Path, *, units: str | None = None, radius: float | None = None
) -> Starter:
    """Return a scene to start from.

    Args:
        kind: ``box``, ``tube``, or the path of a mesh.
        scene: Where the scene file will be: the path of the mesh starts at its folder.
        units: Unit of the mesh; None: a guess.
        radius: Radius of the spheres [m]; None: one that suits the vessel.

    Raises:
        PackgenError: There is no such mesh, or it cannot be read.
    """
    if kind == "box":
        side = 0.1 if radius is None else _rounded(20.0 * radius)
        container = f"  box: {{min: [0, 0, 0], max: [{side:g}, {side:g}, {side:g}]}}   # m, or with a unit"
        return Starter(_scene(container, 0.05 * side if radius is None else radius, COUNT))
    if kind == "tube":
        width = 0.05 if radius is None else _rounded(10.0 * radius)
        container = f"  cylinder: {{radius: {width:g}, height: {6 * width:g}}}   # m, or with a unit"
        return Starter(_scene(container, 0.1 * width if radius is None else radius, COUNT))
    return _of_mesh(Path(kind), scene, units, radius)


def _of_mesh(mesh: Path, scene: Path, units: str | None, radius: float | None) -> Starter:
    if not mesh.is_file():
        raise PackgenError(
            f"{mesh}: found no such file, expected {', '.join(KINDS)} or the path of a mesh such as tank.stl"
        )
    said: list[str] = []
    vessel = mesh_container(mesh, "m", str(mesh), said.append)
    extent = vessel.bounds[1] - vessel.bounds[0]
    fitting = (
        usual_units(float(extent.max()))
        if radius is None
        else likely_units(float(extent.min()), radius, radius)
    )
    unit = units or (fitting[0] if fitting else "m")
    scale = LENGTHS[unit]
    size = extent_text(np.stack([np.zeros(3), extent * scale]))
    chosen = _suitable_radius(vessel, extent, scale) if radius is None else radius
    own = " x ".join(f"{each:.4g}" for each in extent)
    others = "".join(f" or {each}" for each in fitting if each != unit)
    guess = f"{mesh.name} is {own} in its own unit, taken for {unit}: {size}"
    if units is None:
        said.append(f"{guess}; change `units`{f' to{others[3:]}' if others else ''} where that is wrong")
    path = Path(os.path.relpath(mesh, scene.parent)).as_posix()
    container = (
        f"  path: {_quoted(path)}   # stl, ply, obj, off, vtk, vtu, msh ...; it starts at this file\n"
        f"  units: {unit}   # of the mesh: m, cm, mm, um, in or ft; {'given' if units else 'a guess'}: {size}"
    )
    fits = LOOSE * vessel.volume * scale**3 / (UNIT_VOLUME * chosen**3)
    return Starter(_scene(container, chosen, max(1, min(COUNT_MAX, int(0.7 * fits)))), tuple(said))


def _suitable_radius(vessel: Container, extent: Float64Array, scale: float) -> float:
    """Return the radius [m] of which about `COUNT_MAX` spheres fill a vessel, unless that is too narrow."""
    by_volume = (LOOSE * vessel.volume / (COUNT_MAX * UNIT_VOLUME)) ** (1 / 3)
    return _rounded(scale * min(by_volume, float(extent.min()) / (2.0 * DIAMETERS)))


def _rounded(value: float) -> float:
    """Return a number rounded down to two significant digits."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / power * (1 + 1e-12)) * power:.2g}")


def _quoted(text: str) -> str:
    """Return text as a scalar of YAML in double quotes."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _scene(container: str, radius: float, count: int) -> str:
    low, high = _rounded(0.8 * radius), _rounded(1.001 * radius)
    return f"""# yaml-language-server: $schema={SCHEMA_NAME}
# A scene of packgen: `packgen plan THIS` says what to expect, `packgen THIS --export liggghts` makes the bed.
container:
{container}

gravity_axis: z                     # spheres fall towards smaller z; -z: larger; or the vector of gravity
seed: 0                             # another seed, another bed; the same seed, the same bed

particle_sets:
  - name: grains
    radius_distribution: uniform    # or constant, normal, lognormal, rosin_rammler, sieve, discrete, file
    {f"radius_min: {low:g}":<32}# m, or with a unit: "5 mm"
    radius_max: {high:g}
    density: 2500                   # kg/m3
    material: stone

materials:                          # what decks need; friction also says how densely spheres settle
  stone: {{youngs_modulus: 1.0e8, poissons_ratio: 0.3, restitution: 0.5, friction: 0.5}}

zones:                              # filled in this order
  - {f"n_particles: {count}":<32}# or volume (m3 of solid), or mass (kg); without any: until it is full
    # location:                     # a part of the container; without it, the whole
    #   slice: {{axis: z, min_bound: 0, max_bound: 1}}
"""
