"""Clumps: particles of any shape as rigid bodies of spheres."""

from packgen.bodies import Template
from packgen.clumps.clump import Clump, make_clump
from packgen.clumps.make import Wanted
from packgen.clumps.shapes import SHAPES, Cube, Cylinder, Dumbbell, Ellipsoid, Ring, Rod, Tetrapod, shape_of
from packgen.clumps.template import template_of_spheres
from packgen.clumps.template_file import read_template, write_template

__all__ = [
    "SHAPES", "Clump", "Cube", "Cylinder", "Dumbbell", "Ellipsoid", "Ring", "Rod", "Template", "Tetrapod",
    "Wanted",     "make_clump", "read_template", "shape_of", "template_of_spheres", "write_template",
]  # fmt: skip
