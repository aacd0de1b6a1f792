"""Runs of OPTIMAL and SHRINKING_CELL by their scenes: what is refused, kept, reported and repeated."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.optimal import arrange as module
from packgen.errors import PackingError, SceneError
from packgen.report import build_report
from tests.scenes import box, constant, run_scene

CUBE = box([0, 0, 0], [1, 1, 1])


def optimal(folder, zone, container=CUBE, sets=None, **params):
    return run_scene(
        folder, container, sets or constant(0.1), algorithm="OPTIMAL", zones=[zone], threads=1,
        params={"proof": False, **params},
    )  # fmt: skip


def test_all_radii_take_one_factor_and_the_report_has_the_bound(tmp_path):
    result = optimal(tmp_path, {"n_particles": 2}, maximize="scale")
    assert result.bed.radius == pytest.approx(np.full(2, 0.3169872981), abs=1e-9)
    found = result.search
    assert found.proven
    assert found.bound_by == "its two largest spheres alone"
    assert found.value == pytest.approx(3.169872981)
    report = build_report(result.bed, zones=result.zones, search=found)
    rows = dict(report.rows())
    assert rows["bound"].endswith("proven: nothing is better")
    assert not report.missed


def test_the_same_seed_gives_the_same_bed(tmp_path):
    first, second = (optimal(tmp_path, {"n_particles": 4}, maximize="scale", agree=2).bed for _ in range(2))
    assert (first.position == second.position).all()


def test_what_is_not_chosen_is_not_missing(tmp_path):
    sets = [constant(0.45), constant(0.2)]
    result = optimal(tmp_path, {"n_particles": 4}, sets=sets, agree=1)
    assert result.zones[0].asked is None
    assert result.search.candidates == 4
    assert result.search.chosen == result.bed.count < 4
    assert set(result.bed.radius.tolist()) <= {0.45, 0.2}
    # One large sphere is as much as 11 small ones, and two do not fit.
    assert (result.bed.radius == 0.45).sum() == 1
    assert not build_report(result.bed, zones=result.zones, search=result.search).missed


def test_a_stop_keeps_the_best_so_far(tmp_path, monkeypatch):
    def stopped(function, calls, processes):
        yield function(*calls[0])
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "results_in_order", stopped)
    result = optimal(tmp_path, {"n_particles": 3}, maximize="scale")
    assert result.bed.count == 3
    assert result.search.ended == "stopped"
    assert "stopped" in result.search.line()


def test_a_stop_before_anything_is_found_is_a_stop(tmp_path, monkeypatch):
    def stopped(function, calls, processes):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(module, "results_in_order", stopped)
    with pytest.raises(KeyboardInterrupt):
        optimal(tmp_path, {"n_particles": 3}, maximize="scale")


def test_what_optimal_cannot_do_is_refused_with_a_remedy(tmp_path):
    cylinder = {"cylinder": {"radius": 0.5, "height": 1.0}}
    with pytest.raises(PackingError, match=r"curved or inner wall.*a box, a sphere or a convex mesh"):
        optimal(tmp_path, {"n_particles": 3}, cylinder)
    with pytest.raises(PackingError, match=r"201 spheres, expected at most 200.*JAMMED"):
        optimal(tmp_path, {"n_particles": 201})
    with pytest.raises(PackingError, match=r"found no amount.*give `n_particles`"):
        optimal(tmp_path, {})


def cell(folder, zones, container=None, **keys):
    return run_scene(
        folder, container or {"cell": "free"}, constant(0.5), algorithm="SHRINKING_CELL", zones=zones, **keys
    )


def test_a_cell_of_equal_spheres_is_proven_and_keeps_radii_and_tolerance(tmp_path):
    result = cell(tmp_path, [{"n_particles": 2}], params={"starts": 2}, threads=1)
    bed, found = result.bed, result.search
    assert (bed.radius == 0.5).all()
    assert bed.container.volume == pytest.approx(np.sqrt(2.0), rel=1e-10)
    assert found.proven
    assert found.fraction == pytest.approx(np.pi / np.sqrt(18.0), rel=1e-10)
    assert (bed.container.cell == np.tril(bed.container.cell)).all()
    report = build_report(bed, zones=result.zones, search=found)
    assert report.overlap.overlap_max < 1e-13
    assert "degrees" in dict(report.rows())["cell"]


def test_cells_and_containers_that_do_not_go_together_are_refused(tmp_path):
    with pytest.raises(SceneError, match=r"container: found box, expected \{cell: free\} with SHRINK"):
        cell(tmp_path, [{"n_particles": 2}], CUBE)
    with pytest.raises(SceneError, match=r"container.cell: found 'free'.*take `algorithm: SHRINKING_CELL`"):
        run_scene(tmp_path, {"cell": "free"}, constant(0.5), zones=[{"n_particles": 2}])
    with pytest.raises(PackingError, match=r"found no amount.*give `n_particles`"):
        cell(tmp_path, [{}])
    with pytest.raises(PackingError, match="found 2 zones, expected one"):
        cell(tmp_path, [{"n_particles": 2}] * 2)
