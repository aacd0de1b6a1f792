"""Fields on grids and meshes: how much of each cell is filled by spheres."""
