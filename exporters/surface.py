"""Particle-resolved CFD: an OpenFOAM case that meshes the space between the spheres.

Where spheres touch, cells would be slivers. ``contacts`` says what becomes of them: ``caps`` cuts both flat,
``bridges`` joins them by cylinders, ``shrink`` makes all spheres smaller, ``none`` leaves them. The spheres
are ``constant/triSurface/spheres.stl``, one solid a set, or snappyHexMesh's own ``searchableSphere``. A
cylinder or box is a tube with inlet and outlet; ``system`` has the dictionaries of blockMesh, snappyHexMesh
and a steady laminar run, ``Allrun`` makes the mesh and checks it. ``surface.json`` says what the treatment
did to the porosity. Fields and properties of the fluid are the user's.

Reference: OpenFOAM v1912, annotated ``snappyHexMeshDict``; ``searchableSphere`` and ``centre`` are what older
and newer versions of both lines read.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field, model_validator

from exporters.protocol import Outlook
from exporters.resolved import case, channel, contacts, fluid_point, surfaces, treatment
from exporters.shared import deck
from exporters.shared.bonds import refuse_narrow_box
from packgen.bed import Bed
from packgen.errors import ExportError
from packgen.geometry import floor_direction

NAME = "surface"
NEEDS = ("walls",)
FACETS_MAX = 10_000_000


class Options(deck.DeckOptions):
    """Options of the case.

    Attributes:
        contacts: What becomes of spheres where they touch each other and walls: caps, bridges, shrink, none.
        gap: With caps the least gap that is left, with bridges the largest one that is bridged, as a fraction
            of the smaller radius.
        shrink: With shrink the factor of all radii.
        bridge_radius: With bridges their radius, as a fraction of the smaller sphere's.
        spheres: stl: triangles; analytic: snappyHexMesh's own spheres and cylinders, not with caps.
        chord_error: How deep facets may lie under a sphere, as a fraction of its radius.
        inlet_length: Length of a tube before the outermost sphere [m]; None: three mean diameters.
        outlet_length: Length behind the bed [m]; None: six mean diameters.
        inlet: Which end of a tube the inlet is, bottom or top.
        axis: Axis of the flow through a box, x, y or z; None: the one along gravity.
        cell_size: Size of the background mesh's cells [m]; None: a fifth of the smallest diameter.
        level: How often cells are halved at spheres and walls.
    """

    contacts: Literal["caps", "bridges", "shrink", "none"] = "caps"
    gap: float = Field(default=0.02, gt=0, le=0.2, allow_inf_nan=False)
    shrink: float = Field(default=0.99, gt=0, lt=1, allow_inf_nan=False)
    bridge_radius: float = Field(default=0.2, gt=0, le=0.4, allow_inf_nan=False)
    spheres: Literal["stl", "analytic"] = "stl"
    chord_error: float = Field(default=0.025, ge=2.0e-4, le=0.2, allow_inf_nan=False)
    inlet_length: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    outlet_length: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    inlet: Literal["bottom", "top"] = "bottom"
    axis: Literal["x", "y", "z"] | None = None
    cell_size: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    level: int = Field(default=1, ge=0, le=6)

    @model_validator(mode="after")
    def _possible(self) -> Options:
        if self.contacts == "caps" and self.spheres == "analytic":
            raise ValueError(
                "spheres=analytic cannot be cut flat; give contacts=bridges, shrink or none, or spheres=stl"
            )
        for key, whose in (
            ("shrink", ("shrink",)),
            ("bridge_radius", ("bridges",)),
            ("gap", ("caps", "bridges")),
        ):
            if key in self.model_fields_set and self.contacts not in whose:
                raise ValueError(f"{key} is of contacts={' or '.join(whose)}, found contacts={self.contacts}")
        return self

    @property
    def lengths(self) -> tuple[float | None, float | None]:
        """Inlet and outlet length [m]."""
        return self.inlet_length, self.outlet_length

    @property
    def reach(self) -> float:
        """Largest gap of spheres that are treated, as a fraction of the smaller radius."""
        return self.gap if self.contacts in ("caps", "bridges") else 0.0


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the case into an existing folder and return the paths of its files.

    Raises:
        ExportError: The bed or its walls cannot be meshed so, or there would be too many facets or cells.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    _check_facets(bed, options)
    tube = channel.make_channel(bed, options.axis, options.lengths, inlet_low=options.inlet == "bottom")
    mesh = case.background(bed, tube, options.cell_size)
    treated = _treated(bed, tube, options)
    parts = case.make_parts(bed, treated)
    point, clearance = fluid_point.fluid_point(tube, parts.position, parts.radius, parts.rods)
    walls = channel.wall_solids(tube, options.chord_error * float(bed.radius.min()))
    (folder / "system").mkdir(exist_ok=True)
    (folder / "constant" / "triSurface").mkdir(parents=True, exist_ok=True)
    paths, of_stl = case.write_surfaces(folder, parts, walls, options)
    values = case.dictionary_values(bed, tube, mesh, parts, list(walls))
    values |= {"options": options, "point": point.tolist(), "clearance": clearance}
    paths += case.write_dictionaries(folder, values, options.templates)
    told = _told(bed, tube, treated, options) | {
        "spheres_volume_of_stl": of_stl,
        "location_in_mesh": point.tolist(),
        "distance_of_location_from_walls_and_spheres": clearance,
        "background_cells": list(mesh.shape),
    }
    paths.append(deck.write_text(folder / "surface.json", json.dumps(told, indent=2) + "\n"))
    return paths


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse lengths of what is no tube, open walls, and a box that is narrower than two contacts.

    Raises:
        ExportError: The scene's container does not fit the options, or the templates do not exist.
    """
    deck.check_templates(options.templates)
    held = floor_direction(outlook.gravity, outlook.container.periodic)
    strength = float(np.linalg.norm(outlook.gravity))
    down = np.array([0.0, 0.0, -1.0]) if strength == 0.0 else outlook.gravity / strength
    with outlook.placed("container"):
        channel.check_lengths(
            outlook.container, down if held is None else held, options.axis, options.lengths
        )
        channel.check_closed(outlook.container)
        refuse_narrow_box(outlook.container, outlook.radius_min, options.reach, NAME)


def _check_facets(bed: Bed, options: Options) -> None:
    count = surfaces.facets_of(options.chord_error) * bed.count
    if options.spheres == "stl" and count > FACETS_MAX:
        raise ExportError(
            f"{NAME}: {count:.3g} facets of {bed.count:,} spheres, expected at most {FACETS_MAX:,}; enlarge "
            f"{NAME}.chord_error, or choose {NAME}.spheres=analytic"
        )


def _treated(bed: Bed, tube: channel.Channel, options: Options) -> treatment.Treated:
    pairs = contacts.near_pairs(bed, options.reach, NAME)
    if options.contacts == "none":
        return treatment.left(bed, pairs)
    if options.contacts == "shrink":
        return treatment.shrunk(bed, pairs, options.shrink)
    walls = contacts.near_walls(bed, tube, options.gap)
    if options.contacts == "caps":
        return treatment.capped(bed, pairs, walls, options.gap)
    return treatment.bridged(bed, pairs, walls, options.bridge_radius)


def _told(bed: Bed, tube: channel.Channel, treated: treatment.Treated, options: Options) -> dict[str, Any]:
    """Return what ``surface.json`` says of the treatment."""
    volume, method = tube.bed_volume, treated.method
    if bed.body_index is not None and len(np.unique(bed.body_index)) < bed.count:
        method += ", overlaps of spheres of one body counted twice"
    if options.contacts == "bridges" and tube.kind == "vessel":
        method += ", walls taken for flat where bridges meet them"
    before, after = (1.0 - solid / volume for solid in (treated.solid_before, treated.solid_after))
    of = "the tube between the ends of the bed" if tube.is_tube else "the container"
    return {
        "contacts": options.contacts,
        **{key: getattr(options, key) for key in _keys(options)},
        **treated.counts,
        "porosity_of": of,
        "volume": volume,
        "solid_volume_before": treated.solid_before,
        "solid_volume_after": treated.solid_after,
        "porosity_before": before,
        "porosity_after": after,
        "porosity_change": (treated.solid_before - treated.solid_after) / volume,
        "volume_found_by": method,
        "tube_length": tube.ends[1] - tube.ends[0] if math.isfinite(tube.ends[0]) else None,
    }


def _keys(options: Options) -> tuple[str, ...]:
    return {
        "caps": ("gap",), "bridges": ("gap", "bridge_radius"), "shrink": ("shrink",), "none": (),
    }[options.contacts]  # fmt: skip
