"""The paper's studies: each script end to end at a tiny size; the page holds the numbers of its files."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

from tests.snippets import ROOT

STUDIES = ROOT / "examples" / "studies"
sys.path.append(str(STUDIES))  # the scripts' own helpers, as the scripts themselves find them
study = importlib.import_module("study")
make_page = importlib.import_module("make_page")

TINY = {
    "batch_size": ["--spheres", "40", "--batches", "20", "--width", "0.5", "--seeds", "2"],
    "learning_rate": ["--spheres", "20", "--steps", "30"],
    "core_density": ["--width", "0.4", "--seeds", "1"],
    "threads": ["--spheres", "20", "--threads", "1", "2", "--seeds", "1"],
    "sphere_count": ["--counts", "20", "40", "--seeds", "1"],
    "cone": ["--seeds", "1", "--share", "0.05"],
    "furnace": ["--spheres", "16"],
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return tmp_path_factory.mktemp("results")


@pytest.mark.slow
@pytest.mark.parametrize("name", TINY)
def test_a_study_measures_both_optimisers_and_draws(name, results):
    command = [sys.executable, str(STUDIES / f"{name}.py"), "--out", str(results), *TINY[name]]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=results)
    assert done.returncode == 0, done.stderr
    assert (results / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert (results / f"{name}.png").stat().st_size < 150_000
    facts, rows = study.read(results / f"{name}.csv")
    assert {"date", "cpu", "cores", "versions"} <= set(facts)
    key = {"learning_rate": "setting"}.get(name, "method")
    methods = {row[key] for row in rows}
    assert any(each.startswith("projection") for each in methods)
    assert any(each.startswith(("adam", "fixed")) for each in methods)
    limit = 1e-6
    for row in rows:
        if row.get("overlap_max") is not None and "as it leaves" not in row.get("method", ""):
            assert row["overlap_max"] <= limit
    assert make_page.TABLES[name](rows).count("\n") >= 3


def test_the_page_holds_the_numbers_of_the_committed_files():
    text = (STUDIES / "README.md").read_text(encoding="utf-8")
    assert text == make_page.page(), "out of date: python examples/studies/make_page.py"


def test_every_study_is_on_the_page_with_file_and_plot():
    names = set(TINY)
    assert names == set(make_page.TABLES)
    text = (STUDIES / "README.md").read_text(encoding="utf-8")
    for name in names:
        assert f"python examples/studies/{name}.py" in text
        assert f"(results/{name}.png)" in text
        assert (STUDIES / "results" / f"{name}.png").stat().st_size < 150_000
        assert (STUDIES / f"{name}.py").exists()


def test_a_table_changes_with_its_file(tmp_path):
    (tmp_path / "sphere_count.csv").write_text(
        "# date: 2026-01-01\nmethod,spheres,seed,seconds,core_density\n"
        "adam,100,0,2.0,0.5\nadam,100,1,4.0,0.6\nprojection,100,0,0.5,\n"
    )
    facts, rows = study.read(tmp_path / "sphere_count.csv")
    assert facts == {"date": "2026-01-01"}
    lines = make_page.sphere_count(rows).splitlines()
    assert lines[3] == "| adam | 100 | 3 (2 to 4) | 30 (20 to 40) | 0.550 (0.500 to 0.600) |"
    assert lines[4] == "| projection | 100 | 0.5 | 5 | - |"


def test_speed_up_is_against_one_thread():
    threads = importlib.import_module("threads")
    rows = [
        {"threads": 1.0, "seconds": 6.0},
        {"threads": 2.0, "seconds": 3.0},
        {"threads": 2.0, "seconds": 5.0},
    ]
    assert threads.speedups(rows) == pytest.approx({1.0: 1.0, 2.0: 1.5})
