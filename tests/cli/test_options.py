from __future__ import annotations

from dataclasses import fields
from pathlib import Path

from packgen.cli import build_parser
from packgen.cli.options import RunOptions, run_options


def read(*arguments):
    return run_options(build_parser().parse_args(["bed.yaml", *arguments]))


def test_without_options_the_parser_has_the_defaults_of_the_class():
    assert read() == RunOptions(Path("bed.yaml"))


def test_names_are_repeated_or_listed_and_counted_once():
    options = read("--export", "vtk, csv,", "--export", "csv", "--solver", "yade,liggghts")
    assert options.export == ("vtk", "csv")
    assert options.solver == ("yade", "liggghts")


def test_every_option_arrives():
    given = read(
        "--export", "csv", "-o", "out", "--validate", "--solver", "yade", "--seed", "3", "--threads", "4",
        "--device", "cuda", "--templates", "mine", "--export-option", "csv.a=b", "--force", "--picture",
        "--settle", "lammps", "--until", "2s",
        "--no-report", "--quiet", "--workers", "2", "--scheduler", "tcp://here", "--resume", "--json",
        "--pieces",
        "--set", "seed=1",
    )  # fmt: skip
    usual = RunOptions(Path("bed.yaml"))
    same = [each.name for each in fields(usual) if getattr(given, each.name) == getattr(usual, each.name)]
    assert same == ["scene"]


def test_the_result_folder_is_named_after_the_scene_where_none_is_given():
    assert RunOptions(Path("a/bed.yaml")).target == Path("bed")
    assert read("-o", "out").target == Path("out")
