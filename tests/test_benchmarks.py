"""Each script of the benchmarks end to end at a tiny size; their measures are in test_benchmark_measures."""

from __future__ import annotations

import csv
import importlib
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.beds import box_container, make_bed
from tests.seeds import raised

BENCHMARKS = Path(__file__).resolve().parent / "benchmarks"
sys.path.append(str(BENCHMARKS))  # the scripts' own helpers, as the scripts themselves find them
columns = importlib.import_module("columns")
pour = importlib.import_module("pour")
quality = importlib.import_module("quality")
scaling = importlib.import_module("scaling")
speed_against_error = importlib.import_module("speed_against_error")

needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")


def rows_of(table: Path) -> list[dict[str, str]]:
    """The rows of a CSV file, without the lines that say how it was made."""
    with table.open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def run(script: str, folder: Path, *options: str, drawn: bool = True) -> tuple[list[dict[str, str]], str]:
    """Run a script from an empty folder; return the rows of its CSV and its table."""
    (folder / "elsewhere").mkdir()
    command = [sys.executable, str(BENCHMARKS / f"{script}.py"), "--out", str(folder / "out")]
    command += ["--seed", str(raised(0)), *options]
    done = subprocess.run(command, cwd=folder / "elsewhere", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert list((folder / "elsewhere").iterdir()) == []
    names = {path.name for path in (folder / "out").iterdir()}
    assert names == {f"{script}.csv", f"{script}.txt", *([f"{script}.png"] if drawn else [])}
    assert not drawn or (folder / "out" / f"{script}.png").read_bytes().startswith(b"\x89PNG")
    return rows_of(folder / "out" / f"{script}.csv"), (folder / "out" / f"{script}.txt").read_text(
        encoding="utf-8"
    )


@pytest.mark.slow
def test_speed_against_error_measures_each_method_at_each_setting(tmp_path):
    rows, text = run(
        "speed_against_error", tmp_path, "--methods", "projection", "adam", "the paper's", "--spheres", "60",
        "--spheres-slow", "20", "--width", "0.3", "--repeats", "1", "--tolerances", "1e-6",
    )  # fmt: skip
    cases = [(row["method"], row["setting"]) for row in rows]
    assert len(cases) == len(set(cases)) == 3
    assert all(row["spheres"] == row["asked"] for row in rows)
    assert all(float(row["microseconds_a_sphere"]) > 0 for row in rows)
    limits = {"tolerance 1e-06": 1e-6, "all pairs": 0.2}
    assert all(float(row["overlap_max"]) <= limits[row["setting"]] for row in rows)
    assert "step-0 force" in text
    assert "cpu: " in text


def test_the_methods_take_turns_and_the_table_holds_their_medians(capsys):
    asked = []
    seconds = iter([1e-3, 5e-3, 3e-3, 5e-3, 2e-3, 5e-3])
    bed = make_bed([[1, 1, 1], [1, 1, 2.9]], 1.0, box_container((0, 0, 0), (2, 2, 4)))

    def case(name):
        def run_case(seed):
            asked.append((name, seed))
            return speed_against_error.Outcome(bed, next(seconds))

        return speed_against_error.Case(name, "once", 2, run_case)

    rows = speed_against_error.run_rounds([case("one"), case("other")], repeats=3, seed=5)
    assert asked == [("one", 5), ("other", 5), ("one", 6), ("other", 6), ("one", 7), ("other", 7)]
    one, other = speed_against_error.medians(rows)
    assert one["microseconds_a_sphere"] == pytest.approx(1000)
    assert (one["fastest"], one["slowest"]) == pytest.approx((500, 1500))
    assert other["microseconds_a_sphere"] == pytest.approx(2500)
    assert one["overlap_max"] == one["overlap_mean"] == pytest.approx(0.1)


@needs_liggghts
@pytest.mark.solver
def test_liggghts_pours_a_bed_that_overlaps_less_the_stiffer_it_is():
    found = {}
    for modulus in speed_against_error.LIGGGHTS_MODULI:
        poured = pour.pour(40, width=0.25, radius=0.03, youngs_modulus=modulus, seed=raised(0))
        bed = columns.bed_of(poured.position, poured.radius, width=0.25, height=poured.height)
        found[modulus] = quality.quality(bed)
        assert (bed.count, found[modulus].outside) == (40, 0)
    soft, stiff = found.values()
    # 20 seeds: 0.0040 to 0.0064 and 0.027 to 0.043.
    assert 1e-4 < stiff.overlap_max < soft.overlap_max < 0.2
    assert stiff.overlap_mean < stiff.overlap_max


@needs_liggghts
@pytest.mark.solver
def test_liggghts_pours_a_round_bed_that_is_looser_the_rougher_its_spheres():
    tops = []
    for friction in (0.1, 0.8):
        poured = pour.pour(
            120, width=0.25, radius=0.02, youngs_modulus=1e7, seed=raised(0), friction=friction, cylinder=True
        )
        away = np.hypot(poured.position[:, 0], poured.position[:, 1])
        assert (away + 0.02).max() < 0.125 * 1.01  # 20 seeds: at most 0.1255.
        tops.append(np.quantile(poured.position[:, 2], 0.9))
    assert tops[0] < tops[1]  # 20 seeds: 0.125 to 0.134 and 0.137 to 0.147.


@pytest.mark.slow
def test_scaling_measures_each_point_in_a_process_of_its_own(tmp_path):
    rows, text = run(
        "scaling", tmp_path, "--series", "busy", "--spheres", "50",
        "--width", "0.3", "--repeats", "1",
    )  # fmt: skip
    assert [row["label"] for row in rows] == ["idle machine", "one core busy"]
    assert len({row["bed"] for row in rows}) == 1
    assert all(float(row["peak_memory_MB"]) >= float(row["memory_before_MB"]) > 10 for row in rows)
    assert "time with one core busy to idle: " in text


def test_scaling_says_the_ratios_and_whether_the_beds_depend_on_the_threads():
    def row(series, label, cost, seconds=1.0, bed="same"):
        return {
            "series": series, "label": label, "microseconds_a_sphere": cost, "seconds_in_all": seconds,
            "bed": bed,
        }  # fmt: skip

    rows = [
        row("spheres", "50,000", 20.0),
        row("spheres", "1,000,000", 25.0),
        row("first run", "first", 1.0, 14.0),
        row("first run", "second", 1.0, 2.5),
        row("threads", "1", 20.0),
        row("threads", "2", 20.0),
    ]
    assert scaling.verdicts(rows) == [
        "cost a sphere, 1,000,000 to 50,000 spheres: 1.25",
        "first run takes longer than the second by: 11.5 s",
        "beds for different numbers of threads: the same",
    ]
    rows[-1]["bed"] = "another"
    assert scaling.verdicts(rows)[-1].endswith("DIFFERENT")


def test_two_sizes_have_the_mass_share_and_the_mean_volume_that_are_said():
    from packgen.supply.supply import Supply

    scene, container = columns.read_scene(scaling.two_sizes(40_000, 0))
    supply = Supply(scene.zones[0], scene.particle_sets, np.random.default_rng(0))
    radius = supply.take(40_000).radius
    small = radius < 0.01
    assert (radius[small] ** 3).sum() / (radius**3).sum() == pytest.approx(0.3, abs=0.02)
    solid = 4 / 3 * np.pi * (radius**3).sum()
    assert solid / container.volume < columns.LOOSEST


@needs_liggghts
@pytest.mark.solver
@pytest.mark.slow
def test_bed_quality_judges_the_bed_and_its_mark(tmp_path):
    rows, text = run(
        "bed_quality", tmp_path, "--beds", "1", "--spheres", "60", "--free-fall-times", "0.5",
        "--columns", "1", "--column-spheres", "600",
        "--poured", "1", "--poured-spheres", "60", "--width", "0.3",
    )  # fmt: skip
    moved = {row["bed"]: row for row in rows if row["part"] == "displacement"}
    assert set(moved) == {"packgen", "the mark"}
    assert all(float(row["force_max"]) < 1e-6 and row["lost"] == "0" for row in moved.values())
    assert 0.0 < float(moved["the mark"]["mean_trim"]) < 0.01
    columns = {row["bed"]: row for row in rows if row["part"] == "homogeneity"}
    assert set(columns) == {"packgen", "LIGGGHTS"}
    assert 1.0 < float(columns["packgen"]["period_diameters"]) < 3.0
    assert "ratio" in text


@pytest.mark.slow
@pytest.mark.solver
@needs_liggghts
def test_standing_beds_are_asked_at_their_own_and_at_lower_frictions(tmp_path):
    rows, text = run(
        "standing_beds", tmp_path, "--spheres", "60", "--frictions", "0.5", "0.1", "--free-fall-times", "0.5"
    )
    cases = [(row["bed"], row["packed_at"], row["run_at"]) for row in rows]
    assert cases == [
        ("packgen", "0.5", "0.5"), ("packgen", "0.5", "0.1"), ("a tenth taken out", "0.5", "0.5"),
        ("LIGGGHTS", "0.5", "0.5"), ("LIGGGHTS", "0.5", "0.1"),
        ("packgen", "0.1", "0.1"), ("LIGGGHTS", "0.1", "0.1"),
    ]  # fmt: skip
    shares = [float(row["not_carried"]) for row in rows]
    assert shares[1] > shares[0]  # less friction carries less
    assert "least friction" in text


@pytest.mark.slow
@pytest.mark.solver
@needs_liggghts
def test_densities_reach_what_is_asked_and_run_each_bed_beside_its_mark(tmp_path):
    rows, text = run(
        "densities", tmp_path, "--spheres", "1500", "--spheres-run", "200", "--free-fall-times", "0.5",
        drawn=False,
    )  # fmt: skip
    columns = [row for row in rows if row["bed"] == "column"]
    asked = [float(row["asked"]) for row in columns[1:-1]]
    assert asked == [0.55, 0.56, 0.57, 0.58, 0.59, 0.6, 0.61, 0.62, 0.63]
    # So few spheres have a core of a few hundred: the loosest ones are missed by as much as 0.024.
    assert all(abs(float(row["core"]) - float(row["asked"])) < 0.04 for row in columns[1:-1])
    assert [row["bed"] for row in rows[len(columns) :]] == 4 * ["asked", "plain", "the mark"]
    assert "times plain" in text


@pytest.mark.slow
def test_export_speed_writes_each_format_in_a_process_of_its_own(tmp_path):
    rows, text = run(
        "export_speed", tmp_path, "--spheres", "20000", "--repeats", "2", "--formats", "csv", "vtk with vtu"
    )
    assert [row["format"] for row in rows] == ["csv", "csv", "vtk with vtu", "vtk with vtu"]
    # A sphere has four numbers of ten characters or eight bytes at least.
    assert all(int(row["bytes"]) > 20_000 * 32 for row in rows)
    assert all(float(row["processor_seconds"]) > 0 and float(row["extra_memory_MB"]) >= 0 for row in rows)
    assert "more than 2 s of processor time: none" in text


@pytest.mark.slow
def test_facets_packs_the_same_spheres_in_a_form_and_in_meshes_of_facets(tmp_path):
    rows, text = run("facets", tmp_path, "--spheres", "300", "--facets", "2000", "--repeats", "1")
    names = ["plain cylinder", "straight, 2,070 facets", "waisted, 2,070 facets"]
    assert [row["vessel"] for row in rows] == names
    assert {row["spheres"] for row in rows} == {"300"}
    assert all(0.0 < float(row["arrange"]) < float(row["seconds"]) for row in rows)
    assert text.splitlines()[0] == "What facets cost"


@needs_liggghts
@pytest.mark.solver
@pytest.mark.slow
def test_mixtures_holds_arranged_beds_against_poured_ones_and_a_model(tmp_path):
    rows, text = run("mixtures", tmp_path, "--depth", "6", "--beds", "1", "--sizes", "1:2, 30% small")
    assert [row["by"] for row in rows] == ["packgen", "LIGGGHTS"]
    assert rows[0]["spheres"] == rows[1]["spheres"]
    assert all(0.5 < float(row["core"]) < 0.75 for row in rows)
    assert all(0.4 < float(row["large_lowest"]) <= float(row["large_highest"]) < 1.0 for row in rows)
    assert "1:2, 30% small, LIGGGHTS" in text


@pytest.mark.slow
def test_jammed_tells_time_fraction_and_proof(tmp_path, capsys):
    script = importlib.import_module("jammed")
    script.main(["--equal", "50", "--mixed", "0", "--repeats", "1", "--out", str(tmp_path)])
    assert len(script.cases([50], 600)) >= 1 + len(script.laws())
    rows = rows_of(tmp_path / "jammed.csv")
    ours = [row for row in rows if row["method"] == "packgen"]
    assert [row["sizes"] for row in ours] == ["equal"]
    assert float(ours[0]["overlap"]) < 1e-11
    # 24 seeds of 200 spheres: 0.634 to 0.642; fewer scatter more.
    assert 0.58 < float(ours[0]["fraction"]) < 0.70
    assert "column = 17 us" in (tmp_path / "jammed.txt").read_text()


@pytest.mark.slow
def test_shrinking_cell_tells_how_many_starts_hit(tmp_path, capsys):
    script = importlib.import_module("shrinking_cell")
    script.main(["--starts", "3", "--cases", "2 equal", "NaCl", "--out", str(tmp_path)])
    rows = rows_of(tmp_path / "shrinking_cell.csv")
    assert [row["cell"] for row in rows] == ["2 equal"] * 3 + ["NaCl"] * 3
    assert max(float(row["fraction"]) - float(row["known"]) for row in rows) < 1e-9
    assert "column = 17 us" in (tmp_path / "shrinking_cell.txt").read_text()


@pytest.mark.slow
def test_optimal_holds_radii_against_the_best_known(tmp_path, capsys):
    script = importlib.import_module("optimal")
    script.main(["--cube", "1", "3", "--sphere", "4", "--no-choices", "--out", str(tmp_path)])
    rows = rows_of(tmp_path / "optimal.csv")
    assert [row["container"] + row["spheres"] for row in rows] == ["sphere4", "cube1", "cube3"]
    assert all(abs(float(row["found"]) - float(row["known"])) < 1e-8 for row in rows)
    assert "within 1e-8: 2 in the cube, 1 in the sphere" in (tmp_path / "optimal.txt").read_text()


@pytest.mark.slow
def test_void_filling_tells_time_and_coverage_of_five_bodies(tmp_path, capsys):
    script = importlib.import_module("void_filling")
    script.main(["--spheres", "12", "--many", "15", "--facets", "2", "--out", str(tmp_path)])
    rows = rows_of(tmp_path / "void_filling.csv")
    assert [int(row["spheres"]) for row in rows] == [12] * 5 + [15]
    assert all(float(row["overlap"]) == 0.0 and 0.4 < float(row["coverage"]) < 0.9 for row in rows)
    assert "Mean coverage of the five bodies" in capsys.readouterr().out


@pytest.mark.slow
def test_advancing_front_tells_time_and_fraction_of_boxes_and_meshes(tmp_path):
    script = importlib.import_module("advancing_front")
    options = ["--spheres", "300", "--meshed", "300", "--facets", "200", "--lattice", "4", "--repeats", "1"]
    script.main([*options, "--rules", "lowest", "--out", str(tmp_path)])
    rows = rows_of(tmp_path / "advancing_front.csv")
    assert [row["sizes"] for row in rows] == ["equal", "1:2", "1:5", "1:2", "1:2"]
    assert all(float(row["overlap"]) < 1e-12 and 0.3 < float(row["fraction"]) < 0.7 for row in rows)
    assert "column = 17 us" in (tmp_path / "advancing_front.txt").read_text()


@pytest.mark.slow
def test_clumps_are_timed_and_known_shapes_packed(tmp_path):
    script = importlib.import_module("clumps")
    script.main(["--parts", "speed", "curve", "--clumps", "30", "--judged", "40", "--out", str(tmp_path)])
    rows = rows_of(tmp_path / "clumps_speed.csv")
    assert [(row["spheres each"], row["clumps"]) for row in rows] == [("3", "30"), ("8", "30"), ("20", "30")]
    assert all(float(row["overlap / r"]) <= 1e-6 for row in rows)
    rows = rows_of(tmp_path / "clumps_curve.csv")
    assert len(rows) == 2 * 14
    assert {row["clumps"] for row in rows} == {"40"}
    assert (tmp_path / "clumps.png").read_bytes().startswith(b"\x89PNG")
    script.main(["--parts", "--out", str(tmp_path)])  # the table again, from what is there
    assert "ellipsoid of 20" in (tmp_path / "clumps.txt").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("lmp") is None, reason="lammps is not installed")
def test_poured_clumps_are_trimmed_until_none_overlaps_and_judged():
    script, beds = importlib.import_module("clumps"), importlib.import_module("clumps_beds")
    bed, _ = script.timed(beds.in_cylinder(beds.JUDGED["dimer"], 25, raised(0), 2.0))
    mark = importlib.import_module("clumps_poured").mark_of(bed, raised(0))
    assert script.largest_overlap(mark) < 1e-9
    row = script.judged_row("dimer", "LAMMPS, trimmed", mark)
    assert (row["clumps"], row["lost"]) == (25, 0)
    assert row["step-0 force [weights]"] < 1e-6


@pytest.mark.slow
def test_clump_makers_are_measured_on_every_stone(tmp_path):
    script = importlib.import_module("clump_makers")
    script.main(["--spheres", "4", "--out", str(tmp_path)])
    rows = rows_of(tmp_path / "clump_makers.csv")
    ours = [row for row in rows if row["made by"].startswith("packgen")]
    assert [row["stone"] for row in ours] == ["crushed"] * 2 + ["pebble"] * 2 + ["shard"] * 2 + ["pebble"]
    # Best fitting spheres have the stone's volume; inscribed ones lack some of it.
    assert all((abs(float(row["volume [%]"])) < 1e-5) == ("best" in row["made by"]) for row in ours)


@needs_liggghts
@pytest.mark.solver
@pytest.mark.slow
def test_solver_agreement_holds_pairs_against_the_law(tmp_path, capsys):
    script = importlib.import_module("solver_agreement")
    options = ["--scenes", "furnace", "--spheres", "100", "--solvers", "liggghts", "--free-fall-times", "0.2"]
    assert script.main(["--out", str(tmp_path), *options]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"solver_agreement.csv", "solver_agreement.txt"}
    rows = rows_of(tmp_path / "solver_agreement.csv")
    assert [row["bed"] for row in rows] == ["grown", "as packed"]
    assert int(rows[0]["pairs"]) == int(rows[0]["pairs_by_geometry"]) > 0
    assert all(float(row["off_the_law"]) < 1e-9 and row["lost"] == "0" for row in rows)
    assert "Forces at step 0" in capsys.readouterr().out


@pytest.mark.parametrize(
    "script",
    [
        "advancing_front",
        "speed_against_error",
        "scaling",
        "bed_quality",
        "clump_makers",
        "clumps",
        "densities",
        "export_speed",
        "facets",
        "jammed",
        "mixtures",
        "optimal",
        "settling",
        "shrinking_cell",
        "solver_agreement",
        "standing_beds",
        "void_filling",
    ],
)
def test_every_script_explains_itself(script, capsys):
    with pytest.raises(SystemExit, match="0"):
        importlib.import_module(script).main(["--help"])
    assert f"python tests/benchmarks/{script}.py --out DIR" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.solver
@needs_liggghts
def test_settling_puts_settled_beds_beside_the_mark(tmp_path):
    rows, text = run("settling", tmp_path, "--spheres", "60", "--free-fall-times", "2", drawn=False)
    assert [row["bed"] for row in rows] == ["packed", "settled", "settled, trimmed", "the mark"]
    assert all(float(row["displacement_mean"]) >= 0 and row["lost"] == "0" for row in rows)
    assert float(rows[1]["overlap_max"]) > float(rows[2]["overlap_max"]) == 0
    assert float(rows[1]["displacement_mean"]) < float(rows[2]["displacement_mean"])
    assert "ratio to the mark" in text
