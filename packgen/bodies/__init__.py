"""Bodies: spheres that belong together, and the rigid bodies that they stand for."""

from packgen.bodies.columns import are_in_rows, body_starts, joined_bodies, touched_bodies, whole_bodies
from packgen.bodies.mass import MassProperties
from packgen.bodies.placed import SINGLE, Bodies, members_of, rotations
from packgen.bodies.template import Template

__all__ = [
    "SINGLE", "Bodies", "MassProperties", "Template", "are_in_rows", "body_starts", "joined_bodies",
    "members_of", "rotations", "touched_bodies", "whole_bodies",
]  # fmt: skip
