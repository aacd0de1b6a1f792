"""Spheres into voids: always the largest one that fits, or drawn ones, each into the smallest void for it."""
