"""The two update rules that the paper takes from torch, written for one tensor and without overhead a step.

`AmsGrad` is Adam with a running maximum of the squared gradients: Reddi, Kale, Kumar, "On the Convergence of
Adam and Beyond" (2018), in the form and with the defaults of ``torch.optim.Adam(amsgrad=True)``. `Plateau` is
``torch.optim.lr_scheduler.ReduceLROnPlateau(mode="min", threshold_mode="abs", eps=0)``. Both equal torch's.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

BETA_1 = 0.9
BETA_2 = 0.999
EPSILON = 1.0e-8


class AmsGrad:
    """The moments of an AMSGrad descent.

    Args:
        parameter: What is to be optimised, any shape; it gives shape, dtype and device.
    """

    def __init__(self, parameter: Tensor) -> None:
        self._mean = torch.zeros_like(parameter)
        self._square = torch.zeros_like(parameter)
        self._square_max = torch.zeros_like(parameter)
        self._step = 0

    def step(self, parameter: Tensor, gradient: Tensor, rate: float) -> None:
        """Move ``parameter``, in place, one step of learning rate ``rate`` against ``gradient``."""
        self._step += 1
        self._mean.lerp_(gradient, 1.0 - BETA_1)
        self._square.mul_(BETA_2).addcmul_(gradient, gradient, value=1.0 - BETA_2)
        torch.maximum(self._square_max, self._square, out=self._square_max)
        correction = math.sqrt(1.0 - BETA_2**self._step)
        divisor = self._square_max.sqrt().div_(correction).add_(EPSILON)
        parameter.addcdiv_(self._mean, divisor, value=-rate / (1.0 - BETA_1**self._step))


class Plateau:
    """Lowers a learning rate when the objective stops improving.

    Args:
        rate: Learning rate to start with.
        factor: Factor on the rate.
        patience: Number of steps without an improvement that are tolerated.
        threshold: Smallest improvement that counts. It is absolute: relative to an objective that holds
            altitudes it would depend on where the origin lies, and fail where the objective is negative.
    """

    def __init__(self, rate: float, *, factor: float, patience: int, threshold: float) -> None:
        self.rate = rate
        self._factor = factor
        self._patience = patience
        self._threshold = threshold
        self._best = math.inf
        self._bad_steps = 0

    def step(self, value: float) -> None:
        """Take note of the objective's value after a step."""
        if value < self._best - self._threshold:
            self._best = value
            self._bad_steps = 0
            return
        self._bad_steps += 1
        if self._bad_steps > self._patience:
            self.rate *= self._factor
            self._bad_steps = 0
