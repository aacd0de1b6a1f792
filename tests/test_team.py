"""Threads of a team meet, lend each other arrays, and end together where one fails."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.projection.shares import paced
from packgen.compiled import loop
from packgen.team import BROKEN, lent, meet, new_board, share, together

SIZES = [1, 2, 3, 5]


@loop
def sums(board, shared, rank, size, times):
    """Each thread writes its number, and after a meeting reads all."""
    wrong = 0
    for turn in range(times):
        shared[turn % 2, rank] = turn * (rank + 1)
        meet(board, size)
        total = 0
        for other in range(size):
            total += shared[turn % 2, other]
        wrong += total != turn * size * (size + 1) // 2
    return wrong


@loop
def passed_round(board, outbox, rank, size):
    """Each thread reads what the next one has made."""
    made = np.full((3, 2), rank, np.int32)
    outbox[rank, 0] = made.ctypes.data
    meet(board, size)
    got = lent(outbox[(rank + 1) % size, 0], 3, 2).copy()
    meet(board, size)
    made[0, 0] = 0
    return got


@loop
def failing(board, rank, size):
    """One thread fails, and the others wait for it."""
    if rank == size - 1:
        raise ValueError("no more")
    meet(board, size)


@pytest.mark.parametrize("size", SIZES)
def test_what_threads_write_before_a_meeting_all_read_after_it(size):
    board, shared = new_board(), np.zeros((2, size), np.int64)
    arguments = [(board, shared, rank, size, 3000) for rank in range(size)]
    for _ in range(3):
        assert together(sums, board, arguments) == [0] * size


@pytest.mark.parametrize("size", SIZES)
def test_a_thread_reads_an_array_that_another_has_made(size):
    board, outbox = new_board(), np.zeros((size, 2), np.int64)
    got = together(passed_round, board, [(board, outbox, rank, size) for rank in range(size)])
    assert [each.tolist() for each in got] == [[[(rank + 1) % size] * 2] * 3 for rank in range(size)]


@pytest.mark.parametrize("size", [2, 4])
def test_where_one_thread_fails_none_waits_for_ever(size):
    board = new_board()
    with pytest.raises((ValueError, RuntimeError)):
        together(failing, board, [(board, rank, size) for rank in range(size)])
    assert board[BROKEN] == 1
    shared = np.zeros((2, size), np.int64)
    assert together(sums, board, [(board, shared, rank, size, 5) for rank in range(size)]) == [0] * size


@pytest.mark.parametrize("count", [0, 1, 7, 100])
@pytest.mark.parametrize("size", SIZES)
def test_shares_are_even_and_leave_nothing_out(count, size):
    parts = [share.py_func(count, rank, size) for rank in range(size)]
    assert [begin for begin, _ in parts[1:]] == [end for _, end in parts[:-1]]
    assert (parts[0][0], parts[-1][1]) == (0, count)
    assert max(end - begin for begin, end in parts) - min(end - begin for begin, end in parts) <= 1


def test_a_slow_thread_gets_less_until_all_take_as_long():
    pace = np.array([1.0, 0.5, 1.0, 1.0])
    ends = np.array([0.25, 0.5, 0.75, 1.0])
    for _ in range(20):
        spheres = 1000.0 * np.diff(ends, prepend=0.0)
        paced.py_func(ends, spheres, spheres / pace)
    assert np.diff(ends, prepend=0.0) == pytest.approx(pace / pace.sum(), rel=1e-3)
    assert ends[-1] == 1.0


def test_where_it_is_not_known_how_long_a_thread_took_the_shares_stay():
    for spheres, spent in (([5.0, 0.0], [1.0, 1.0]), ([5.0, 5.0], [0.0, 1.0])):
        ends = np.array([0.5, 1.0])
        paced.py_func(ends, np.array(spheres), np.array(spent))
        assert ends.tolist() == [0.5, 1.0]


def test_a_thread_that_stood_still_for_a_moment_keeps_a_share():
    ends = np.array([0.5, 1.0])
    for _ in range(50):
        paced.py_func(ends, np.array([100.0, 100.0]), np.array([1.0, 1e6]))
    assert 0.15 < 1.0 - ends[0] < 0.25
