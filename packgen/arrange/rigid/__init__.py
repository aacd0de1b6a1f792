"""A layer of rigid bodies of spheres: what the default algorithm moves where particles are clumps."""
