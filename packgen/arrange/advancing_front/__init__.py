"""ADVANCING_FRONT: spheres put one by one where they touch three others or walls, without any dynamics."""
