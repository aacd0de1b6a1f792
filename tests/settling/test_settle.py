"""Beds that solvers settle: what they leave, to the last digit, and what becomes of runs that go wrong."""

from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
import pytest

import exporters
from packgen.check import check_bed
from packgen.errors import SolverError
from packgen.settling import Settled, settle
from packgen.settling.run import Order
from packgen.stopping import heed
from packgen.validation import Limits, validate
from packgen.validation.process import SOLVERS
from packgen.validation.still import free_fall_time
from tests.beds import box_container, make_bed
from tests.exporters.beds import RADIUS

SOLVER = [
    pytest.param(
        name, marks=[pytest.mark.solver, pytest.mark.skipif(not shutil.which(program), reason=f"no {name}")]
    )
    for name, (program, _) in SOLVERS.items()
]


def columns(periodic=(False, False, False)):
    """Four columns of three unlike spheres, apart from each other, that fall straight down."""
    grid = np.stack(np.meshgrid(*(np.arange(count) for count in (2, 2, 3)), indexing="ij"), axis=-1)
    position = (grid.reshape(-1, 3) * 2.4 + 1.2) * RADIUS
    radius = np.linspace(0.9, 1.0, 12) * RADIUS
    return make_bed(position, radius, box_container((0, 0, 0), [4.8 * RADIUS] * 2 + [9 * RADIUS], periodic))


def settled(bed, folder, solver="liggghts", **keys) -> Settled:
    exporter = exporters.get(solver)
    exporter.write(bed, folder, exporter.Options())
    return settle(bed, folder, solver=solver, **keys)


@pytest.mark.slow
@pytest.mark.parametrize("solver", SOLVER)
def test_what_a_solver_settles_rests_on_the_floor_as_the_same_spheres(tmp_path, solver):
    bed, told = columns(), []
    found = settled(bed, tmp_path, solver, on_progress=lambda *each: told.append(each))
    assert (found.still, found.interrupted, found.solver) == (True, False, solver)
    assert found.speed < 1e-4
    for name in ("radius", "set_index", "zone_index", "batch_index"):
        assert np.array_equal(getattr(found.bed, name), getattr(bed, name))
    lowest = found.bed.position[::3]  # ids lead back to the rows
    assert np.allclose(lowest[:, 2], bed.radius[::3], rtol=1e-3)
    moved = np.linalg.norm(found.bed.position - bed.position, axis=1) / bed.radius.mean()
    assert found.displacement_mean == pytest.approx(moved.mean())
    assert found.displacement_max == pytest.approx(moved.max())
    check = check_bed(found.bed)
    assert 0 < max(check.overlap_max, check.wall_overlap_max) < 1e-2
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert "free-fall times" in told[-1][0]


@pytest.mark.slow
@pytest.mark.parametrize("solver", SOLVER)
def test_positions_have_all_their_digits_and_the_bed_stays_where_it_is(tmp_path, solver):
    found = settled(columns(), tmp_path, solver)
    assert not np.array_equal(found.bed.position, np.round(found.bed.position, 15))
    (tmp_path / "again").mkdir()
    exporter = exporters.get(solver)
    exporter.write(found.bed, tmp_path / "again", exporter.Options())
    report = validate(found.bed, tmp_path / "again", solver=solver, limits=Limits(force_limit=None))
    assert report.missed == ()
    assert report.step_zero.law_error < 1e-6
    assert report.step_zero.pair_count + report.step_zero.wall_count >= 12
    assert report.gravity_run.displacement_mean < 1e-2


@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_the_same_deck_settles_to_the_same_bed_and_for_as_long_as_is_said(tmp_path):
    bed = columns()
    free_fall = free_fall_time(bed)
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    one, two = (settled(bed, tmp_path / name, time=0.5 * free_fall) for name in ("one", "two"))
    assert np.array_equal(one.bed.position, two.bed.position)
    assert one.free_fall_times == pytest.approx(0.5, rel=0.01)
    assert not one.still
    # Half a free-fall time ago all were at rest, and the upper ones have met nothing yet.
    fallen = bed.position[2::3, 2] - one.bed.position[2::3, 2]
    assert np.allclose(fallen, 0.5 * 9.81 * (0.5 * free_fall) ** 2, rtol=0.02)


@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_the_state_goes_on_where_the_bed_was_left(tmp_path):
    found = settled(columns(), tmp_path)
    assert found.restart is not None
    deck = (tmp_path / "in.bed").read_text()
    assert "read_data bed.data" in deck
    (tmp_path / "in.on").write_text(deck.replace("read_data bed.data", f"read_restart {found.restart.name}"))
    (tmp_path / "in.look").write_text(
        "include in.on\ndump on all custom 1 on.dump id xu yu zu\n"
        'dump_modify on format "%d %.17g %.17g %.17g"\nrun 0\n'
    )
    subprocess.run(
        ["liggghts", "-in", "in.look", "-log", "none", "-var", "setup_only", "1"], cwd=tmp_path, check=True,
        capture_output=True, timeout=120,
    )  # fmt: skip
    rows = np.loadtxt(tmp_path / "on.dump", skiprows=9)
    assert np.array_equal(rows[np.argsort(rows[:, 0]), 1:], found.bed.position)


@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_a_bed_that_wraps_around_stays_inside_its_box(tmp_path):
    bed = columns((True, True, False))
    pushed = make_bed(
        bed.position, bed.radius, bed.container, gravity=np.array([3.0, 1.0, -9.0])
    )  # slides along the floor, through the sides
    found = settled(pushed, tmp_path, time=20 * free_fall_time(pushed))
    low, high = bed.container.bounds
    assert ((found.bed.position[:, :2] >= low[:2]) & (found.bed.position[:, :2] < high[:2])).all()
    assert found.displacement_max > 5


# ---- A shell script in place of the solver: it leaves what a run leaves, and ends as it is told ----

FAKE = """\
case "$2" in
in.packgen_timestep) echo "LIGGGHTS-PUBLIC 3.8.0"; echo "packgen timestep 1e-4"; exit 0;;
esac
dump() {{
  (printf 'ITEM: TIMESTEP\\n%s\\nITEM: NUMBER OF ATOMS\\n%s\\n' $2 $3
  printf 'ITEM: BOX BOUNDS\\n0 1\\n0 1\\n0 1\\nITEM: ATOMS id x y z\\n'
  for id in $(seq $3 -1 1); do echo "$id {place}"; done) > $1
}}
{rest}
"""


def fake(tmp_path, monkeypatch, rest, place="0.5 0.5 0.25"):
    program = tmp_path / "bin" / "liggghts"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\n" + FAKE.format(rest=rest, place=place))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")


def three():
    return make_bed(
        [[0.2, 0.5, 0.5], [0.5, 0.5, 0.5], [0.8, 0.5, 0.5]], 0.1, box_container((0, 0, 0), (1, 1, 1))
    )


GOES_WRONG = {
    "loses one": ("dump packgen_end.dump 9 2; echo '9 2 0 0 0.5'", "1 of 3 spheres were lost"),
    "stops": ("echo 'ERROR: no such style'; exit 1", "stopped with exit code 1"),
    "ends early": ("echo '1 3 0 0 0.5'", "ended before step"),
    "leaves no bed": ("echo '1 3 0 0 0'; echo 'packgen calm 99999'", "without writing packgen_end.dump"),
}


@pytest.mark.parametrize("case", GOES_WRONG)
def test_a_solver_that_goes_wrong_is_told_in_a_line(tmp_path, monkeypatch, case):
    script, words = GOES_WRONG[case]
    fake(tmp_path, monkeypatch, script)
    with pytest.raises(SolverError, match=f"^liggghts: .*{words}") as caught:
        settled(three(), tmp_path)
    assert caught.value.exit_code == 1


def test_a_sphere_that_has_left_the_container_is_named(tmp_path, monkeypatch):
    fake(
        tmp_path,
        monkeypatch,
        "dump packgen_end.dump 9 3; echo '9 3 0 0 0'; echo 'packgen calm 99999'",
        "2 2 2",
    )
    with pytest.raises(SolverError, match=r"3 of 3 spheres were lost within .*\(sphere 0, 1, 2\)"):
        settled(three(), tmp_path)


def test_only_what_is_surely_whole_is_kept_of_a_run_that_is_stopped(tmp_path, monkeypatch):
    kept = "".join(
        f"dump packgen_kept_{step}.dump {step} 3; echo '{step} 3 0 0 0.{step}'; " for step in (1, 2, 3)
    )
    cut = "dump packgen_kept_4.dump 4 1; echo restart > packgen_kept_3.restart; sleep 0.3; exit 1"
    fake(tmp_path, monkeypatch, kept + cut)

    def stop(stage, share):
        if len(list(tmp_path.glob("packgen_kept_*.dump"))) > 1 and stage.startswith("0.00"):
            raise KeyboardInterrupt

    bed = three()
    found = settled(bed, tmp_path, on_progress=stop)
    heed()
    assert found.interrupted
    assert not found.still
    assert np.array_equal(found.bed.position, [[0.5, 0.5, 0.25]] * 3)
    assert np.array_equal(found.bed.radius, bed.radius)
    assert found.time == pytest.approx(1e-4 * found.steps)
    assert 1 <= found.steps <= 3


def test_a_run_that_is_stopped_before_it_keeps_anything_leaves_the_bed_as_it_was(tmp_path, monkeypatch):
    fake(tmp_path, monkeypatch, "echo '0 3 0 0 0'")

    def stop(_stage, _share):
        raise KeyboardInterrupt

    bed = three()
    found = settled(bed, tmp_path, on_progress=stop)
    heed()
    assert (found.interrupted, found.time, found.restart) == (True, 0.0, None)
    assert np.array_equal(found.bed.position, bed.position)


@pytest.mark.parametrize(
    "changes", [{"gravity": np.zeros(3)}, {"container": box_container((0, 0, 0), (1, 1, 1), (True,) * 3)}]
)
def test_a_bed_that_has_nothing_to_fall_on_is_refused(tmp_path, monkeypatch, changes):
    fake(tmp_path, monkeypatch, "")
    container = changes.pop("container", box_container((0, 0, 0), (1, 1, 1)))
    bed = make_bed([[0.5, 0.5, 0.5]], 0.1, container, **changes)
    with pytest.raises(SolverError, match="nothing to fall on") as caught:
        settle(bed, tmp_path)
    assert caught.value.exit_code == 2


def test_a_run_until_still_has_an_end_and_its_share_never_falls():
    bed, told = three(), []
    order = Order(bed, None, None, lambda _stage, share: told.append(share))
    timestep = free_fall_time(bed) / 1000
    looks = order.looks(timestep)
    assert looks.steps == 400_000
    assert looks.every == 250
    tell = order.progress(looks, timestep)
    for step, speed in enumerate((0.0, 1.0, 0.1, 0.5, 1e-3, 1e-9)):
        tell(250 * step, speed)
    assert told == sorted(told)
    assert told[-1] == 0.99
    assert Order(bed, None, 1.0, print).looks(timestep).speed == 0.0
