"""What the tests of the command line share: a scene of 125 spheres, and the report of its run."""

from __future__ import annotations

import json
from pathlib import Path

SCENE = """
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
seed: 7
particle_sets:
  - {name: pellets, radius_distribution: constant, radius: 0.1}
zones:
  - {n_particles: 125}
"""


def report_of(folder="box"):
    """Return the report of a run."""
    return json.loads(Path(folder, "report.json").read_text())
