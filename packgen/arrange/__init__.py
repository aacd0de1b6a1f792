"""The arrangement: spheres, walls and a direction down in; a bed without overlaps out."""
