"""The settings that the paper's scene files have, whichever algorithm reads them."""

from __future__ import annotations

from typing import ClassVar

from packgen.values import Count, Keys, NonNegative, Positive, Tolerance, WholeNumber


class PaperParams(Keys):
    """Settings with the paper's names and the paper's meaning.

    Attributes:
        batch_size: Spheres in one batch; None: the optimiser's own choice. Layers of projection are at least
            half a sphere thick.
        lr: Learning rate of adam for spheres as large as the paper's, 0.1 m; it scales with the radius.
        n_epoch: Most steps for one batch (the paper's max_steps).
        patience: Steps without progress after which adam gives a batch up.
        alpha: Weight of the overlaps (paper, eq. 5).
        beta: Weight of the height.
        gamma: Weight of the distance outside the container.
        tolerance: Largest overlap, as a fraction of the smaller radius; None: as the optimiser left it.
        verbosity: Steps of adam between two reports of progress; 0: one report a batch.
    """

    may_change: ClassVar[str] = "nothing"

    batch_size: Count | None = None
    lr: Positive = 0.01
    n_epoch: Count = 2000
    patience: Count = 50
    alpha: NonNegative = 100.0
    beta: NonNegative = 10.0
    gamma: NonNegative = 100.0
    tolerance: Tolerance | None = 1.0e-6
    verbosity: WholeNumber = 10
