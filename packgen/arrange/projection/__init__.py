"""Arranges one layer of spheres: it sinks, and projection sweeps part its overlaps."""
