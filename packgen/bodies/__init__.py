"""Bodies: spheres that belong together, and the rigid bodies that they stand for."""

from packgen.bodies.columns import are_in_rows, body_starts, joined_bodies, touched_bodies, whole_bodies
from packgen.bodies.draw import Form, drawn_bodies, random_turns
from packgen.bodies.extent import fits_within, sieve_size
from packgen.bodies.mass import MassProperties
from packgen.bodies.moved import body_centres, in_one_piece, moved_bodies, quaternions
from packgen.bodies.placed import SINGLE, Bodies, has_members, joined_rows, members_of, rotations
from packgen.bodies.shares import UnbalancedError, member_shares, sphere_shares
from packgen.bodies.stored import bodies_of_arrays, body_arrays
from packgen.bodies.template import Template, is_sphere

__all__ = [
    "SINGLE", "Bodies", "Form", "MassProperties", "Template", "UnbalancedError", "are_in_rows",
    "bodies_of_arrays", "body_arrays", "body_centres", "body_starts", "drawn_bodies", "fits_within",
    "has_members", "in_one_piece", "is_sphere", "joined_bodies", "joined_rows", "member_shares", "members_of",
    "moved_bodies", "quaternions", "random_turns", "rotations", "sieve_size", "sphere_shares",
    "touched_bodies", "whole_bodies",
]  # fmt: skip
