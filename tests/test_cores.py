"""How many cores are free is what the process is bound to, and what its control groups grant."""

from __future__ import annotations

import os

import pytest

from packgen.cores import free_cores

BOUND = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="ascii")


def test_without_control_groups_all_cores_that_the_process_is_bound_to_are_free(tmp_path):
    assert free_cores(tmp_path / "none", tmp_path / "neither") == BOUND


@pytest.mark.parametrize(
    ("granted", "cores"),
    [
        ("max 100000", BOUND),
        ("100000 100000", 1),
        ("1 100000", 1),
        ("nonsense", BOUND),
        ("900000000 1", BOUND),
    ],
)
def test_a_quota_of_the_group_counts(tmp_path, granted, cores):
    write(tmp_path / "cgroup", "0::/jobs/mine\n")
    write(tmp_path / "groups/jobs/mine/cpu.max", granted + "\n")
    assert free_cores(tmp_path / "groups", tmp_path / "cgroup") == cores


def test_a_group_has_no_more_than_the_one_it_is_part_of(tmp_path):
    write(tmp_path / "cgroup", "0::/jobs/mine\n")
    write(tmp_path / "groups/jobs/cpu.max", "100000 100000\n")
    write(tmp_path / "groups/jobs/mine/cpu.max", "max 100000\n")
    assert free_cores(tmp_path / "groups", tmp_path / "cgroup") == 1


def test_in_a_container_whose_group_is_not_there_the_root_counts(tmp_path):
    write(tmp_path / "cgroup", "0::/of/the/host\n")
    write(tmp_path / "groups/cpu.max", "100000 100000\n")
    assert free_cores(tmp_path / "groups", tmp_path / "cgroup") == 1


def test_the_first_version_of_control_groups_counts_as_well(tmp_path):
    write(tmp_path / "cgroup", "4:memory:/other\n3:cpu,cpuacct:/mine\n0::/\n")
    write(tmp_path / "groups/cpu/mine/cpu.cfs_quota_us", "50000\n")
    write(tmp_path / "groups/cpu/mine/cpu.cfs_period_us", "100000\n")
    assert free_cores(tmp_path / "groups", tmp_path / "cgroup") == 1
    write(tmp_path / "groups/cpu/mine/cpu.cfs_quota_us", "-1\n")
    assert free_cores(tmp_path / "groups", tmp_path / "cgroup") == BOUND
