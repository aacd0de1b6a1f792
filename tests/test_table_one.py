"""The paper's Table I as runs: its page holds the numbers of its file, and has each approach."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest

from packgen.arrange.registry import BUILTIN
from packgen.scene import load_scene
from tests.snippets import ROOT

FOLDER = ROOT / "examples" / "table_one"
sys.path.append(str(FOLDER))  # its own modules, as the script itself finds them
table_one = importlib.import_module("table_one")
peers = importlib.import_module("peers")


def test_the_page_holds_the_numbers_of_the_committed_file():
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert text == table_one.page(), "out of date: python examples/table_one/table_one.py"
    assert {row["by"].split()[0] for row in table_one.read()} >= {
        each.algorithm for each in table_one.ENTRIES
    }


def test_each_row_is_an_algorithm_that_takes_its_scene():
    for entry in table_one.ENTRIES:
        assert entry.algorithm in BUILTIN
        scene = load_scene(FOLDER / f"{entry.scene}.yaml", [f"algorithm={entry.algorithm}"])
        said = getattr(scene.params, "may_change", None)
        assert said == entry.may_change


def test_rows_without_a_bed_have_dashes():
    empty = dict.fromkeys(table_one.COLUMNS, "") | {"approach": "x", "by": "y"}
    assert table_one.markdown([empty]).splitlines()[2].count(" - |") == 8


def test_the_bed_of_another_programme_is_measured_in_the_box_that_it_has_made(tmp_path):
    def lattice(radius, extent, seed):
        place = np.stack(np.meshgrid(*[np.arange(0.5, 5.0)] * 3), axis=-1).reshape(-1, 3)
        return 0.12 * place, np.full(125, 0.06), 0.6 * np.ones(3)

    row = table_one.run_peer(peers.Peer("lattice", "all", lattice, is_there=True), tmp_path / "lattice")
    assert row["sphere_count"] == 125
    assert row["solid_fraction_filled"] == pytest.approx(np.pi / 6.0)
    assert row["overlap_max"] <= 1e-12
