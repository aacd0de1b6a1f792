"""Settings of the arrangement's tests."""

import pytest
import torch


@pytest.fixture(autouse=True)
def _one_thread():
    # the tensors here are small: more threads only wait for each other
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
