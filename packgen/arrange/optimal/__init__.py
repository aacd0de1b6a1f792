"""OPTIMAL: the best of all arrangements of a few spheres in a convex container."""
