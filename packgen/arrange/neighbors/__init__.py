"""Which spheres are near each other: neighbour lists, across the seams of a periodic box too."""
