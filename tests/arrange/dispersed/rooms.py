"""Rooms to disperse spheres in."""

from __future__ import annotations

import numpy as np

from packgen.arrange.dispersed.crowding import Room
from packgen.arrange.space.region import make_region
from packgen.geometry import Box, Container, Surface

NONE = np.empty((0, 3)), np.empty(0)


def room_of(periodic=(False, False, False), radius=0.05, fixed=NONE) -> Room:
    """A unit cube, with the centres and half distances of the spheres that are in it."""
    cube = Box(np.zeros(3), np.ones(3))
    surface = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    container = Container("cube", cube, surface, np.stack([cube.min, cube.max]), 1.0, periodic)
    return Room(make_region(container, (), np.array([0.0, 0, -1]), radius, "zones[0]"), *fixed)
