"""The two update rules against torch's own."""

import pytest
import torch

from packgen.arrange.adam.update_rules import AmsGrad, Plateau


def gradients(seed, steps):
    rng = torch.Generator().manual_seed(seed)
    # some parameters get no gradient for a while, and some change their size by decades
    size = 10.0 ** (4.0 * torch.rand((steps, 7, 3), generator=rng, dtype=torch.float64) - 3.0)
    sparse = torch.rand((steps, 7, 3), generator=rng) < 0.7
    return size * torch.randn((steps, 7, 3), generator=rng, dtype=torch.float64) * sparse


@pytest.mark.parametrize("seed", [0, 1])
def test_amsgrad_moves_as_torch_does_while_the_rate_changes(seed):
    ours = torch.zeros((7, 3), dtype=torch.float64)
    theirs = torch.nn.Parameter(ours.clone())
    optimizer = torch.optim.Adam([theirs], lr=0.01, amsgrad=True)
    descent = AmsGrad(ours)
    for step, gradient in enumerate(gradients(seed, 300)):
        rate = 0.01 * 0.5 ** (step // 60)
        optimizer.param_groups[0]["lr"] = rate
        theirs.grad = gradient.clone()
        optimizer.step()
        descent.step(ours, gradient, rate)
    torch.testing.assert_close(ours, theirs.detach(), rtol=1e-12, atol=1e-14)
    assert ours.abs().max() > 0.05


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("factor", "patience", "threshold"), [(0.5, 0, 0.0), (0.1, 3, 0.1), (0.7, 10, 1e-3)])
def test_plateau_lowers_the_rate_when_torch_does(factor, patience, threshold, sign):
    optimizer = torch.optim.SGD([torch.nn.Parameter(torch.zeros(1))], lr=0.01)
    scheduler = torch.optim.lr_scheduler.ReduceLROnPlateau(
        optimizer, factor=factor, patience=patience, threshold=threshold, threshold_mode="abs", eps=0.0
    )
    plateau = Plateau(0.01, factor=factor, patience=patience, threshold=threshold)
    rng = torch.Generator().manual_seed(2)
    rates = []
    for step in range(200):
        value = sign * (2.0 ** (-step / 40) + 0.2 * torch.rand(1, generator=rng).item())
        scheduler.step(value)
        plateau.step(value)
        rates.append(plateau.rate)
        assert plateau.rate == optimizer.param_groups[0]["lr"]
    assert len(set(rates)) > 3
