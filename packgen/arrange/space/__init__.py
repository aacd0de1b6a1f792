"""The space that one zone's spheres live in: walls, seams, columns along gravity."""
