"""Several processes make the bed that one makes: two, three, one that is killed, a run that goes on."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from packgen.arrange.crew import Alone
from packgen.errors import PackgenError
from packgen.filling.pack import pack
from packgen.workers.cluster import Cluster, WorkerError, local_cluster, remote_cluster
from tests.scenes import box, constant, read_scene

TROUGH = box([0, 0, 0], [8, 1, 3])
BOUND = 120  # seconds; many times what a slow machine needs

dask = pytest.importorskip("distributed")


def packed(folder, crew=None):
    scene, vessel = read_scene(
        folder, TROUGH, constant(0.05), zones=[{"n_particles": 9000}], params={"tile": 20}
    )
    return pack(scene, vessel, crew=crew, threads=1).bed


def same(bed, other):
    names = ("position", "radius", "set_index", "batch_index")
    return all(np.array_equal(getattr(bed, name), getattr(other, name)) for name in names)


@pytest.fixture(scope="module")
def bed(tmp_path_factory):
    return packed(tmp_path_factory.mktemp("one"))


def when(condition, act):
    """Do something as soon as a condition holds, beside the test."""

    def watch():
        end = time.monotonic() + BOUND
        while not condition():
            if time.monotonic() > end:
                return
            time.sleep(0.005)
        act()

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    return thread


def done_in(parts):
    return len(list(parts.glob("layer_*_0000.npz")))


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_any_number_of_processes_makes_the_bed_of_one(tmp_path, bed, workers):
    with local_cluster(workers, tmp_path, 1) as crew:
        assert same(packed(tmp_path, crew), bed)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="processes are killed as POSIX does it")
def test_a_process_that_is_killed_midway_changes_nothing(tmp_path, bed):
    with local_cluster(2, tmp_path, 1) as crew:
        victims = []

        def kill():
            victims.append(next(iter(crew.client.run(os.getpid).values())))
            os.kill(victims[0], signal.SIGKILL)

        watch = when(lambda: done_in(tmp_path) >= 3, kill)
        assert same(packed(tmp_path, crew), bed)
        watch.join()
        assert len(victims) == 1


class Stops(Alone):
    """Ends in the middle of the work."""

    left = 7

    def next_done(self):
        self.left -= 1
        if self.left < 0:
            raise KeyboardInterrupt
        return super().next_done()


@pytest.mark.slow
def test_processes_go_on_with_what_an_interrupted_run_has_left(tmp_path, bed):
    with pytest.raises(KeyboardInterrupt):
        packed(tmp_path, Stops(tmp_path))
    assert done_in(tmp_path) == 7
    with local_cluster(2, tmp_path, 1) as crew:
        assert same(packed(tmp_path, crew), bed)


@pytest.mark.slow
def test_a_scheduler_with_its_workers_makes_the_same_bed_and_a_lost_one_is_told_of(tmp_path, bed):
    first, second = tmp_path / "first", tmp_path / "second"
    for each in (first, second):
        each.mkdir()
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None, "memory_limit": 0}
    with dask.LocalCluster(**options) as cluster:
        with remote_cluster(cluster.scheduler_address, first, 1) as crew:
            assert same(packed(tmp_path, crew), bed)
        with remote_cluster(cluster.scheduler_address, second, None) as crew:
            assert crew.threads >= 1
            watch = when(lambda: done_in(second) >= 2, cluster.close)
            with pytest.raises(WorkerError, match="scheduler does not answer any more; what is done is in"):
                packed(tmp_path, crew)
            watch.join()
    assert same(packed(tmp_path, Alone(second)), bed)


@pytest.mark.slow
def test_workers_must_see_the_folder(tmp_path):
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None, "processes": False}
    with (
        dask.LocalCluster(**options) as cluster,
        pytest.raises(PackgenError, match=r"does not see .*choose with -o a folder on a file system"),
        remote_cluster(cluster.scheduler_address, tmp_path / "elsewhere", 1),
    ):
        pass


@pytest.mark.slow
def test_an_error_of_a_call_comes_back_as_it_is(tmp_path):
    with local_cluster(1, tmp_path, 1) as crew:
        crew.hand_out((0,), int, "three")
        with pytest.raises(ValueError, match="three"):
            crew.next_done()


@pytest.mark.slow
def test_a_call_that_ends_every_process_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr("packgen.workers.cluster.ENDED_MAX", 1)
    with local_cluster(1, tmp_path, 1) as crew:
        crew.hand_out((0,), os._exit, 1)
        with pytest.raises(WorkerError, match=r"\(0,\): every process that worked on it has ended"):
            crew.next_done()


def test_processes_start_with_the_first_call(tmp_path):
    with local_cluster(2, tmp_path, None) as crew:
        assert crew.threads >= 1
        assert dask.client._global_clients == {}


def test_a_lost_scheduler_claims_only_what_is_there(tmp_path):
    crew = Cluster(lambda: SimpleNamespace(status="closed"), tmp_path, 1)
    with pytest.raises(WorkerError, match="does not answer any more; nothing is done yet"):
        crew.next_done()
    (tmp_path / "layer_00000_tile_0000_0000.npz").touch()
    with pytest.raises(WorkerError, match=r"does not answer any more; what is done is in .*, --resume"):
        crew.next_done()


def test_a_machine_without_dask_is_told_how_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "dask", None)
    with (
        pytest.raises(PackgenError, match=r"--workers: needs Dask.*pip install 'packgen\[distributed\]'"),
        local_cluster(2, tmp_path, None),
    ):
        pass
