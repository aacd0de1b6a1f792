"""A zone is filled by a function of its task, the spheres at rest and a generator: nothing else tells."""

from __future__ import annotations

import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from packgen.arrange.adam.arrange import fill_zone as fill_by_adam
from packgen.arrange.collective.arrange import fill_zone as fill_by_layers
from packgen.arrange.spheres import Spheres, joined, no_spheres
from packgen.arrange.task import Progress, Task, no_listener
from packgen.filling.pack import pack
from tests.scenes import box, constant, read_scene, uniform

VESSEL = box([0, 0, 0], [0.6, 0.3, 0.5])
SETS = [uniform(0.02, 0.03), constant(0.025)]
LEFT = {"box": {"min": [0, 0, 0], "max": [0.3, 0.3, 0.5]}}
RIGHT = {"box": {"min": [0.3, 0, 0], "max": [0.6, 0.3, 0.5]}}
ZONES = [
    {"n_particles": 80, "set_proportions": [0.5, 0.5], "location": LEFT},
    {"set_proportions": [0.25, 0.75], "location": RIGHT},
]
STEPS = {"n_epoch": 40, "batch_size": 30}


def task_of(folder, monkeypatch, **keys) -> Task:
    """The task that a scene becomes."""
    caught: list[Task] = []

    class CaughtError(Exception):
        pass

    def catch(task: Task) -> Spheres:
        caught.append(task)
        raise CaughtError

    scene, vessel = read_scene(folder, VESSEL, SETS, **keys)
    with monkeypatch.context() as patch:
        patch.setattr("packgen.arrange.registry.Registered.load", lambda _: catch)
        with pytest.raises(CaughtError):
            pack(scene, vessel)
    return caught[0]


def same(first: Spheres, second: Spheres) -> bool:
    columns = ("position", "radius", "set_index", "zone_index", "batch_index")
    return all(np.array_equal(getattr(first, each), getattr(second, each)) for each in columns)


def fill_in_another_process(pickled: bytes) -> bytes:
    fill, zone, earlier = pickle.loads(pickled)
    return pickle.dumps(fill(zone, earlier, zone.generator(), no_listener))


@pytest.mark.parametrize("fill", [fill_by_layers, fill_by_adam], ids=["layers", "adam"])
def test_the_same_arguments_give_the_same_spheres_in_any_process(tmp_path, monkeypatch, fill):
    params = {"batch_size": 40, "n_epoch": 60}
    task = task_of(tmp_path, monkeypatch, zones=ZONES, params=params)
    zone = task.zones[0]
    first = fill(zone, no_spheres(), zone.generator(), no_listener)
    second = fill(zone, no_spheres(), zone.generator(), no_listener)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        sent = pickle.dumps((fill, zone, no_spheres()))
        third = pickle.loads(pool.submit(fill_in_another_process, sent).result())
    assert len(first.spheres) > 40
    assert same(first.spheres, second.spheres)
    assert same(first.spheres, third.spheres)
    assert third.supply.remaining == first.supply.remaining


@pytest.mark.parametrize("fill", [fill_by_layers, fill_by_adam], ids=["layers", "adam"])
def test_filling_a_zone_changes_neither_its_supply_nor_the_spheres_at_rest(tmp_path, monkeypatch, fill):
    params = {"batch_size": 40, "n_epoch": 60}
    task = task_of(tmp_path, monkeypatch, zones=ZONES, params=params)
    left = fill(task.zones[0], no_spheres(), task.zones[0].generator(), no_listener).spheres
    kept, zone = pickle.dumps(left), task.zones[1]
    before = zone.supply.copy().take(100)
    filled = fill(zone, left, zone.generator(), no_listener)
    assert (filled.spheres.zone_index == 1).all()
    assert same(left, pickle.loads(kept))
    assert np.array_equal(before.radius, zone.supply.copy().take(100).radius)


def test_a_zone_owes_nothing_to_the_randomness_of_the_one_before(tmp_path, monkeypatch):
    task = task_of(tmp_path, monkeypatch, zones=ZONES)
    few = task_of(tmp_path, monkeypatch, zones=[ZONES[0] | {"n_particles": 8}, ZONES[1]])
    beds = []
    for each in (task, few):
        left = fill_by_layers(each.zones[0], no_spheres(), each.zones[0].generator(), no_listener).spheres
        zone = each.zones[1]
        beds.append(fill_by_layers(zone, left[:0], zone.generator(), no_listener).spheres)
    assert len(beds[0]) > 40
    assert same(*beds)


def test_a_listener_hears_of_its_zone_alone_and_of_every_so_many_steps_of_adam(tmp_path, monkeypatch):
    heard: list[Progress] = []
    task = task_of(
        tmp_path, monkeypatch, zones=ZONES, params={"n_epoch": 40, "verbosity": 15, "batch_size": 30}
    )
    zone = task.zones[0]
    fill_by_adam(zone, no_spheres(), zone.generator(), heard.append)
    steps = [each.stage for each in heard if each.stage != "arrange"]
    assert set(steps) == {"arrange, step 15 of a batch", "arrange, step 30 of a batch"}
    assert all(each.total == 80 for each in heard)
    assert heard[-1].stage == "arrange"
    task = task_of(
        tmp_path, monkeypatch, zones=ZONES, params={"n_epoch": 40, "verbosity": 0, "batch_size": 30}
    )
    heard.clear()
    fill_by_adam(task.zones[0], no_spheres(), task.zones[0].generator(), heard.append)
    assert {each.stage for each in heard} == {"arrange"}


def test_joined_zones_are_the_bed(tmp_path, monkeypatch):
    task = task_of(tmp_path, monkeypatch, zones=ZONES)
    scene, vessel = read_scene(tmp_path, VESSEL, SETS, zones=[ZONES[0]])
    alone = pack(scene, vessel).bed
    zone = task.zones[0]
    spheres = joined(
        [no_spheres(), fill_by_layers(zone, no_spheres(), zone.generator(), no_listener).spheres]
    )
    assert len(alone.radius) == len(spheres) == 80
    assert np.array_equal(np.sort(alone.radius), np.sort(spheres.radius))
