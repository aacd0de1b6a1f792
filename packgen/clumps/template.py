"""Templates of bodies that are unions of spheres themselves."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.bodies import Template
from packgen.clumps.properties import union_properties

__all__ = ["template_of_spheres"]


def template_of_spheres(name: str, spheres: Float64Array) -> Template:
    """Return the template of a body that is the union of some spheres itself.

    Args:
        name: Its name.
        spheres: Centres and radii in any frame [m], shape (N, 4), float64; the axes are kept.
    """
    body = union_properties(spheres)
    moved = np.asarray(spheres, np.float64) - np.append(body.centre, 0.0)
    return Template(name, moved, body.volume, body.inertia, body.centre)
