"""The cell list against measuring every pair, and against scipy's k-d tree."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from packgen.arrange.neighbors import torch_pairs as neighbors
from packgen.arrange.neighbors.torch_pairs import (
    neighbor_pairs,
    neighbor_pairs_between,
    neighbor_pairs_between_brute_force,
    neighbor_pairs_brute_force,
)


def cloud(rng, count, *, span=4.0, center=0.0, decades=0.0, grid=0.0):
    position = rng.uniform(-span, span, size=(count, 3))
    if grid:
        # multiples of the cell width, and many of them in the same place
        position = np.round(position / grid) * grid
    reach = 0.5 * 10.0 ** rng.uniform(-decades, 0.0, size=count)
    return torch.from_numpy(position + center), torch.from_numpy(reach)


def pairs_of(tree, distance):
    pairs = tree.query_pairs(distance, output_type="ndarray")
    return torch.from_numpy(pairs[np.lexsort(pairs.T[::-1])])


lengths_of_box = st.tuples(*[st.sampled_from([None, 0.7, 1.9, 2.1, 5.0, 30.0])] * 3)
clouds = {
    "count": st.integers(0, 60),
    "seed": st.integers(0, 2**32 - 1),
    "span": st.sampled_from([0.0, 0.5, 4.0, 1.0e6]),
    "center": st.sampled_from([0.0, -7.25, 1.0e7]),
    "decades": st.sampled_from([0.0, 1.0, 4.0]),
    "grid": st.sampled_from([0.0, 0.25, 1.0]),
    "lengths": lengths_of_box,
}


@settings(max_examples=60, deadline=None, derandomize=True)
@given(**clouds)
def test_cell_list_finds_the_same_pairs_as_brute_force(count, seed, lengths, **shape):
    position, reach = cloud(np.random.default_rng(seed), count, **shape)
    found = neighbor_pairs(position, reach, lengths)
    assert torch.equal(found, neighbor_pairs_brute_force(position, reach, lengths))
    assert found.dtype == torch.int64
    assert found.shape == (len(found), 2)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(other_count=st.integers(0, 60), **clouds)
def test_bipartite_form_finds_the_same_pairs_as_brute_force(count, other_count, seed, lengths, **shape):
    rng = np.random.default_rng(seed)
    spheres = (*cloud(rng, count, **shape), *cloud(rng, other_count, **shape))
    found = neighbor_pairs_between(*spheres, lengths)
    assert torch.equal(found, neighbor_pairs_between_brute_force(*spheres, lengths))


def test_pairs_equal_those_of_a_kd_tree():
    position, reach = cloud(np.random.default_rng(3), 2000)
    reach[:] = 0.4
    tree = cKDTree(position.numpy())
    assert torch.equal(neighbor_pairs(position, reach), pairs_of(tree, 0.8))


def test_pairs_equal_those_of_a_periodic_kd_tree():
    position, reach = cloud(np.random.default_rng(4), 2000)
    position, reach[:] = position.remainder(3.0), 0.1
    tree = cKDTree(position.numpy(), boxsize=3.0)
    assert torch.equal(neighbor_pairs(position, reach, (3.0, 3.0, 3.0)), pairs_of(tree, 0.2))


def test_memory_bound_does_not_change_the_pairs(monkeypatch):
    position, reach = cloud(np.random.default_rng(5), 300, decades=1.0, grid=0.5)
    expected = neighbor_pairs_brute_force(position, reach)
    for bound in (1, 7, 1000):
        monkeypatch.setattr(neighbors, "CANDIDATES_MAX", bound)
        assert torch.equal(neighbor_pairs(position, reach), expected)


def test_touching_spheres_are_no_pair_and_closer_ones_are():
    reach = torch.tensor([0.5, 0.5], dtype=torch.float64)
    for distance, count in ((1.0, 0), (np.nextafter(1.0, 0.0), 1), (0.0, 1)):
        position = torch.tensor([[0.0, 0.0, 0.0], [0.0, distance, 0.0]], dtype=torch.float64)
        assert len(neighbor_pairs(position, reach)) == count


def test_small_spheres_do_not_pay_for_a_large_one(monkeypatch):
    measured = []
    close = neighbors._close
    monkeypatch.setattr(neighbors, "_close", lambda *args: (measured.append(len(args[0])), close(*args))[1])
    position, reach = cloud(np.random.default_rng(6), 4000)
    reach[:], reach[0] = 0.05, 4.0
    neighbor_pairs(position, reach)
    assert sum(measured) < 10 * len(position)


def test_a_single_sphere_and_none_have_no_neighbors():
    for count in (0, 1):
        position, reach = cloud(np.random.default_rng(7), count)
        assert neighbor_pairs(position, reach).shape == (0, 2)
        assert neighbor_pairs_between(position, reach, position[:0], reach[:0]).shape == (0, 2)


@pytest.mark.parametrize(
    ("position", "reach", "lengths", "message"),
    [
        ([[0.0, 0.0]], [1.0], (None,) * 3, "expected \\(N, 3\\)"),
        ([[0.0, 0.0, np.nan]], [1.0], (None,) * 3, "positions must be finite"),
        ([[0.0, 0.0, 0.0]], [0.0], (None,) * 3, "reaches must be finite and positive"),
        ([[0.0, 0.0, 0.0]], [1.0], (None, 0.0, None), "three positive lengths"),
    ],
)
def test_unusable_input_is_refused(position, reach, lengths, message):
    as_tensor = [torch.tensor(value, dtype=torch.float64) for value in (position, reach)]
    with pytest.raises(ValueError, match=message):
        neighbor_pairs(*as_tensor, lengths)
