"""JAMMED: spheres without gravity, pressed against each other until nothing can move."""
