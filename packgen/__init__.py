"""packgen: beds of spheres for DEM, from a scene file to a deck that the solver runs unedited."""

__version__ = "0.1.0"
