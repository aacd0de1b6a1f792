"""Fused CPU loops (numba): neighbour lists, contact sweeps and walls, each equal to its plain torch form."""
