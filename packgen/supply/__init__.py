"""The spheres of a zone: how many of each set, with which radii, in which order."""
