"""SHRINKING_CELL: the densest periodic cell of a few spheres, its shape free."""
