"""Bodies as plain arrays that any numpy reads, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from packgen.arrays import read_only
from packgen.bodies.placed import SINGLE, Bodies
from packgen.bodies.template import Template

__all__ = ["ARRAYS", "bodies_of_arrays", "body_arrays"]

ARRAYS = ("body_position", "body_orientation", "body_template", "body_scale", "templates")
"""The keys of bodies in ``bed.npz``."""

UNIT_ERROR = 1.0e-9  # of the length of a quaternion


def body_arrays(bodies: Bodies) -> dict[str, Any]:
    """Return bodies as arrays by the keys of `ARRAYS`; the templates are JSON text."""
    templates = [
        {
            "name": each.name,
            "spheres": each.spheres.tolist(),
            "volume": each.volume,
            "inertia": each.inertia.tolist(),
            "place": each.place.tolist(),
        }
        for each in bodies.templates
    ]
    return {
        "body_position": bodies.position,
        "body_orientation": bodies.orientation,
        "body_template": bodies.template_index,
        "body_scale": bodies.scale,
        "templates": np.array(json.dumps(templates)),
    }


def bodies_of_arrays(arrays: Mapping[str, Any]) -> Bodies | None:
    """Return the bodies that `body_arrays` stored; None where there are none.

    Raises:
        ValueError: An array is missing, has another shape or numbers that no body has, or the templates are
            none; the message says which.
    """
    there = [name for name in ARRAYS if name in arrays]
    if not there:
        return None
    missing = [name for name in ARRAYS if name not in arrays]
    if missing:
        raise ValueError(f"bodies without {', '.join(missing)}")
    templates = _templates(str(arrays["templates"]))
    numbers, count = arrays["body_template"], len(arrays["body_template"])
    if numbers.dtype.kind not in "iu" or not ((numbers >= SINGLE) & (numbers < len(templates))).all():
        raise ValueError(f"body_template other than whole numbers from {SINGLE} to {len(templates) - 1}")
    scale, turn = (np.asarray(arrays[name], np.float64) for name in ("body_scale", "body_orientation"))
    place = read_only(arrays["body_position"], np.float64, (count, 3), "body_position")
    turn = read_only(turn, np.float64, (count, 4), "body_orientation")
    if not (np.isfinite(scale) & (scale > 0.0)).all():
        raise ValueError("body_scale that is not above 0")
    if not np.isfinite(place).all():
        raise ValueError("body_position that is no number")
    if not (np.abs(np.linalg.norm(turn, axis=1) - 1.0) <= UNIT_ERROR).all():
        raise ValueError("body_orientation that is no unit quaternion")
    return Bodies(templates, numbers.astype(np.int32), scale, place, turn)


def _templates(text: str) -> tuple[Template, ...]:
    try:
        return tuple(
            Template(
                str(each["name"]), np.array(each["spheres"], np.float64), float(each["volume"]),
                np.array(each["inertia"], np.float64), np.array(each["place"], np.float64),
            )
            for each in json.loads(text)
        )  # fmt: skip
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"templates that are none ({error})") from error
