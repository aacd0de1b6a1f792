"""The outer loop of Algorithm 1: batches, halving, what is thrown back, and the paper's box."""

import dataclasses

import numpy as np
import pytest
import torch

from packgen.arrange.adam.batch import AdamSettings, batch_accepted, measure_batch
from packgen.arrange.adam.objective import PlaneWalls
from packgen.arrange.adam.zone import Surroundings, ZoneSpace, pack_zone_adam, torch_threads
from tests.seeds import raised

NOTHING = torch.empty((0, 3), dtype=torch.float64), torch.empty(0, dtype=torch.float64)
SHORT = AdamSettings(batch_size=16, n_epoch=400, patience=30, plateau_factor=0.5, plateau_patience=5, lr=0.02)


@dataclasses.dataclass(frozen=True)
class Draw:
    radius: np.ndarray
    set_index: np.ndarray


class Supply:
    """A queue of spheres."""

    def __init__(self, radius):
        self.queue = list(enumerate(radius))

    @property
    def finished(self):
        return not self.queue

    def take(self, count):
        taken, self.queue = self.queue[:count], self.queue[count:]
        return Draw(
            np.array([each[1] for each in taken]), np.array([each[0] for each in taken], dtype=np.int32)
        )

    def put_back(self, draw):
        self.queue = list(zip(draw.set_index.tolist(), draw.radius.tolist(), strict=True)) + self.queue


def pack(
    radius,
    *,
    size=1.0,
    axis=2,
    sign=-1.0,
    settings=SHORT,
    fixed=NOTHING,
    seed=0,
    supply_type=Supply,
    **options,
):
    """Pack a cube; returns the zone, the supply, the progress reports, and the walls."""
    down = torch.zeros(3, dtype=torch.float64)
    down[axis] = sign
    eye = torch.eye(3, dtype=torch.float64)
    walls = PlaneWalls(torch.cat((eye, -eye)), torch.tensor([size] * 3 + [0.0] * 3, dtype=torch.float64))

    def clear(position):
        away = np.linalg.norm(position[:, None] - fixed[0].numpy(), axis=2)
        return (away > fixed[1].numpy() + np.max(radius)).all(axis=1)

    def sample(rng, count, height, thickness):
        position = rng.uniform(0.0, size, size=(count, 3))
        position[:, axis] = -sign * rng.uniform(height, height + thickness, size=count)
        return position[clear(position)]

    def sample_above(rng, count, height, thickness):
        position = sample(rng, count, height, thickness)
        while len(position) < count:
            position = np.concatenate([position, sample(rng, count, height, thickness)])
        return position[:count]

    def free(altitude):
        return len(sample(np.random.default_rng(0), 1000, altitude, 0.0)) / 1000

    ends = (0.0, size) if sign < 0.0 else (-size, 0.0)
    space = ZoneSpace(*ends, lambda altitude: size**2, free, sample_above)
    supply, reports = supply_type(radius), []
    zone = pack_zone_adam(
        supply, Surroundings(walls, space, down, *fixed), settings, np.random.default_rng(raised(seed)),
        on_progress=reports.append, **options,
    )  # fmt: skip
    return zone, supply, reports, walls


def radii(count, low=0.08, high=0.12, seed=1):
    return np.random.default_rng(raised(seed)).uniform(low, high, count)


def overlaps(zone, walls):
    return measure_batch(torch.from_numpy(zone.position), torch.from_numpy(zone.radius), *NOTHING, walls)


@pytest.mark.parametrize(("axis", "sign"), [(2, -1.0), (0, 1.0)])
def test_counted_zone_gets_exactly_its_spheres_on_the_floor(axis, sign):
    radius = radii(40)
    zone, supply, reports, walls = pack(radius, axis=axis, sign=sign)
    assert supply.finished
    assert sorted(zone.radius) == sorted(radius)
    assert np.array_equal(zone.radius, radius[zone.set_index])
    assert reports[-1].placed == 40
    assert max(overlaps(zone, walls)[::2]) <= SHORT.overlap_limit
    depth = zone.position[:, axis] if sign < 0.0 else 1.0 - zone.position[:, axis]
    # 20 seeds: the lowest sphere is up to 0.0007 off the floor.
    assert depth.min() == pytest.approx(zone.radius[depth.argmin()], abs=0.01)
    # 20 seeds along each axis: 0.180 to 0.255. A single sphere may hang: the highest is at 0.39 to 0.75.
    assert np.median(depth) < 0.3


def test_full_zone_halves_its_batches_to_nothing_and_returns_what_does_not_fit():
    radius = radii(400, 0.1, 0.1)
    zone, supply, reports, _ = pack(radius, size=0.8)
    assert not supply.finished
    assert len(zone.radius) + len(supply.queue) == 400
    sizes = [report.batch_size for report in reports]
    expected = [size if report.accepted else size // 2 for size, report in zip(sizes, reports, strict=True)]
    assert [*sizes[1:], 0] == expected
    assert sum(report.batch_size for report in reports if not report.accepted) == zone.thrown_back
    assert all(report.accepted == batch_accepted(report.result, SHORT) for report in reports)
    # A simple cubic arrangement has 64; small batches and few steps leave it loose. 20 seeds: 41 to 51.
    assert 36 < len(zone.radius) <= 64
    assert sorted(zone.set_index.tolist() + [each[0] for each in supply.queue]) == list(range(400))


def test_spheres_that_do_not_fit_at_all_end_in_an_empty_zone():
    zone, supply, reports, _ = pack([0.6] * 3)
    assert zone.position.shape == (0, 3)
    assert zone.set_index.dtype == zone.batch_index.dtype == np.int32
    assert [report.batch_size for report in reports] == [3, 1]
    assert len(supply.queue) == 3


def test_end_game_decides_which_spheres_stay_and_where():
    def finish(position, radius, fixed_position, fixed_radius):
        kept = torch.ones(len(radius), dtype=torch.bool)
        # the first of each full batch goes back
        kept[0] = len(radius) < SHORT.batch_size
        return kept, position + 1e-3

    radius = radii(40)
    accept_all = dataclasses.replace(SHORT, overlap_limit=9.0)
    zone, _, reports, _ = pack(radius, finish=finish, settings=accept_all)
    left, _, _, _ = pack(radius[:16], settings=accept_all)
    assert np.array_equal(np.sort(zone.set_index), np.arange(40))
    assert np.array_equal(zone.set_index[:15], np.arange(1, 16))
    np.testing.assert_allclose(zone.position[:15], left.position[1:16] + 1e-3, rtol=0.0, atol=1e-15)
    assert zone.thrown_back == sum(report.batch_size == 16 for report in reports) > 0
    assert np.array_equal(np.bincount(zone.batch_index)[:1], [15])


def test_an_end_game_that_keeps_nothing_is_a_failed_batch():
    reject = lambda position, radius, *fixed: (torch.zeros(len(radius), dtype=torch.bool), position)  # noqa: E731
    zone, _, reports, _ = pack(radii(4), finish=reject)
    assert len(zone.radius) == 0
    assert [report.batch_size for report in reports] == [4, 2, 1]


def test_later_zone_rests_on_the_fixed_spheres_and_does_not_return_them():
    first, _, _, walls = pack(radii(30, 0.1, 0.1))
    fixed = torch.from_numpy(first.position), torch.from_numpy(first.radius)
    second, _, _, _ = pack(radii(30, 0.1, 0.1, seed=2), fixed=fixed, seed=3)
    assert len(second.radius) == 30
    assert second.position[:, 2].mean() > first.position[:, 2].mean() + 0.2  # 20 seeds: 0.233 to 0.273.
    overlap_mean, *_ = measure_batch(
        torch.from_numpy(second.position), torch.from_numpy(second.radius), *fixed, walls
    )
    assert overlap_mean <= SHORT.overlap_limit


@pytest.mark.parametrize("height", [0.8, 5.0])
def test_spheres_higher_up_do_not_lift_the_start(height):
    above = torch.tensor([[0.5, 0.5, height]], dtype=torch.float64), torch.tensor([0.1], dtype=torch.float64)
    beds = [pack(radii(10), fixed=fixed)[0].position for fixed in (NOTHING, above)]
    assert np.array_equal(*beds)


def test_zone_beside_earlier_spheres_fills_the_space_they_leave():
    column = np.array([[0.25, y, z] for y in np.arange(0.1, 1.0, 0.2) for z in np.arange(0.1, 1.0, 0.2)])
    fixed = torch.from_numpy(column), torch.full((len(column),), 0.1, dtype=torch.float64)
    zone, *_ = pack(radii(60, 0.1, 0.1), fixed=fixed)
    # The space beyond is 0.65 wide: 3 x 5 x 5 spheres in a regular pattern. 20 seeds: 50 to 57 of 60.
    assert np.count_nonzero(zone.position[:, 0] > 0.3) > 46
    assert zone.position[:, 2].min() < 0.11  # 20 seeds: 0.099 to 0.100.


def test_zone_without_room_for_a_sphere_stays_empty():
    places = np.arange(0.1, 1.0, 0.2)
    full = np.stack(np.meshgrid(places, places, places), axis=-1).reshape(-1, 3)
    fixed = torch.from_numpy(full), torch.full((len(full),), 0.1, dtype=torch.float64)
    zone, supply, reports, _ = pack(radii(5, 0.1, 0.1), fixed=fixed)
    assert len(zone.radius) == len(reports) == 0
    assert len(supply.queue) == 5


def test_supply_that_runs_dry_ends_the_zone():
    class Dry(Supply):
        finished = False

    zone, *_ = pack(radii(10), supply_type=Dry)
    assert len(zone.radius) == 10


def test_same_seed_gives_the_same_bed_bit_for_bit_and_another_seed_another():
    beds = [pack(radii(20), seed=seed)[0].position for seed in (0, 0, 1)]
    assert np.array_equal(beds[0], beds[1])
    assert not np.array_equal(beds[0], beds[2])


def test_thread_count_is_restored_also_after_an_error():
    def fail_inside(count):
        with torch_threads(count):
            raise RuntimeError(f"with {torch.get_num_threads()} threads")

    before = torch.get_num_threads()
    with pytest.raises(RuntimeError, match=f"with {before + 1} threads"):
        fail_inside(before + 1)
    assert torch.get_num_threads() == before


@pytest.mark.physics
@pytest.mark.slow
def test_paper_box_holds_what_the_paper_reports():
    # section V-A: a 2x2x2 box, r = 0.1: 950 to 1006 spheres, core densities from 0.571 to 0.619
    from overlap import Hexahedron, Sphere, overlap_volume

    zone, _, _, walls = pack(np.full(3000, 0.1), size=2.0, settings=AdamSettings())
    # 20 seeds: 942 to 1004 spheres, and a core of 0.579 +- 0.008.
    assert 920 <= len(zone.radius) <= 1020
    low, high = 1.0 / 3.0, 5.0 / 3.0
    corners = [(low, low), (high, low), (high, high), (low, high)]
    core = Hexahedron([(*corner, height) for height in (low, high) for corner in corners])
    inside = np.abs(zone.position - 1.0).max(axis=1) < 2.0 / 3.0 + 0.1
    solid = sum(overlap_volume(Sphere(tuple(center), 0.1), core) for center in zone.position[inside])
    assert 0.55 <= solid / (high - low) ** 3 <= 0.62
    assert overlaps(zone, walls)[0] < 0.011
