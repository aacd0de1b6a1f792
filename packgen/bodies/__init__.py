"""Bodies: spheres that belong together, and the rigid bodies that they stand for."""

from packgen.bodies.columns import are_in_rows, body_starts, joined_bodies, touched_bodies, whole_bodies
from packgen.bodies.mass import MassProperties
from packgen.bodies.placed import SINGLE, Bodies, has_members, members_of, rotations
from packgen.bodies.shares import UnbalancedError, member_shares, sphere_shares
from packgen.bodies.stored import bodies_of_arrays, body_arrays
from packgen.bodies.template import Template

__all__ = [
    "SINGLE", "Bodies", "MassProperties", "Template", "UnbalancedError", "are_in_rows", "bodies_of_arrays",
    "body_arrays", "body_starts", "has_members", "joined_bodies", "member_shares", "members_of", "rotations",
    "sphere_shares", "touched_bodies", "whole_bodies",
]  # fmt: skip
