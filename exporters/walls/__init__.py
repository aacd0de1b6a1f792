"""The walls of a deck: facets that a solver accepts, primitive walls, STL files."""
