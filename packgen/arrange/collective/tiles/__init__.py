"""Beds by tiles: a layer of a tile is a unit of work of its own, in any process; see ``layout``."""
