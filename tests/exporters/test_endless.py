"""Decks of a bed whose box wraps around along gravity: none of them has gravity, each says why."""

from __future__ import annotations

import numpy as np
import pytest

from exporters import lammps, liggghts, yade
from tests.beds import box_container, make_bed

SCRIPTS = {lammps: "in.bed", liggghts: "in.bed", yade: "bed.py"}


def deck(exporter, folder, periodic, **changes):
    bed = make_bed([[1, 1, 1]], 0.4, box_container((0, 0, 0), (4, 4, 4), periodic), **changes)
    exporter.write(bed, folder, exporter.Options())
    return (folder / SCRIPTS[exporter]).read_text(encoding="utf-8")


@pytest.mark.parametrize("exporter", SCRIPTS, ids=lambda each: each.NAME)
def test_an_endless_bed_has_no_gravity_in_its_deck_and_the_deck_says_why(tmp_path, exporter):
    text = deck(exporter, tmp_path, (True, True, True))
    assert "# No gravity: the box wraps around along it" in text
    assert "9.81" not in text


@pytest.mark.parametrize("exporter", [lammps, liggghts], ids=lambda each: each.NAME)
def test_gravity_askew_to_the_period_stays_in_the_deck(tmp_path, exporter):
    slope = np.array([3.0, 0.0, -4.0])
    text = deck(exporter, tmp_path, (True, False, False), gravity=slope)
    assert "fix gravity all gravity 5.0 vector 0.6 0.0 -0.8" in text
    assert "No gravity" not in text
