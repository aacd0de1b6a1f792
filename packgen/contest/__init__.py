"""The same scene by several algorithms: which runs that makes, and how they stand."""

from packgen.contest.entries import entries, known_algorithms
from packgen.contest.standings import HEAD, Standing, standing_rows, standings

__all__ = ["HEAD", "Standing", "entries", "known_algorithms", "standing_rows", "standings"]
