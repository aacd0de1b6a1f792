from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from packgen import leftovers
from packgen.leftovers import NOBODY, SCRATCH, abandoned, is_gone, owner, remove_scratch

pytestmark = pytest.mark.skipif(owner() == NOBODY, reason="the system does not tell when a process started")


@pytest.fixture
def ended():
    """What a process that has ended was named."""
    script = "from packgen.leftovers import owner; print(owner())"
    return subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[1],
    ).stdout.strip()


def test_this_process_lives_and_one_that_has_ended_is_gone(ended):
    assert not is_gone(owner())
    assert is_gone(ended)


def test_a_number_that_another_process_has_by_now_is_told_by_its_start():
    pid, start, machine, boot = owner().split("-")
    assert is_gone(f"{pid}-{int(start, 16) - 1:x}-{machine}-{boot}")


def test_processes_of_other_machines_and_of_none_are_never_gone(ended):
    pid, start, machine, boot = ended.split("-")
    assert is_gone(f"{pid}-{start}-{machine}-0")  # before this machine was started anew
    assert not is_gone(f"{pid}-{start}-0-{boot}")
    assert not is_gone(NOBODY)
    assert not is_gone("x7zk29ab")


def test_without_a_system_that_tells_nothing_is_gone(ended, monkeypatch):
    monkeypatch.setattr(leftovers, "_here", lambda: None)
    assert owner() == NOBODY
    assert not is_gone(ended)


def test_folders_of_ended_processes_are_found_and_nothing_else(tmp_path, ended):
    named = [
        f".a.{ended}-x",
        f".a.{ended}-x~",
        f".a.{ended}-x~~",
        f".b.{ended}-x",
        f".a.{owner()}-x",
        ".a.x1",
    ]
    for name in named:
        (tmp_path / name).mkdir()
    (tmp_path / f".a.{ended}-file").write_text("")
    (tmp_path / f".a.{ended}-link").symlink_to(tmp_path, target_is_directory=True)
    assert [path.name for path in abandoned(tmp_path, r"\.a\.")] == named[:3]
    assert abandoned(tmp_path / "nowhere", "") == []


def test_scratch_folders_of_killed_runs_go(tmp_path, ended):
    for name in (f"{SCRATCH}{ended}-x", f"{SCRATCH}{owner()}-x", "packgen_other"):
        (tmp_path / name / "deck").mkdir(parents=True)
    remove_scratch(tmp_path)
    assert sorted(os.listdir(tmp_path)) == sorted([f"{SCRATCH}{owner()}-x", "packgen_other"])
