"""The settings of COLLECTIVE_ARRANGEMENT."""

from __future__ import annotations

from typing import Literal

from packgen.arrange.paper_params import PaperParams
from packgen.geometry import Container


class Params(PaperParams):
    """Settings of COLLECTIVE_ARRANGEMENT; the paper's names keep the paper's meaning.

    Attributes:
        optimizer: ``projection`` (fast), or ``adam`` (the paper's Algorithm 1, see the algorithm ADAM).
    """

    optimizer: Literal["projection", "adam"] = "projection"

    @property
    def instead(self) -> str | None:
        """Name of the algorithm that arranges in place of this one; None: this one does."""
        return "ADAM" if self.optimizer == "adam" else None

    def unsupported(self, container: Container) -> list[tuple[str, str]]:
        """Return the settings that cannot fill a container, as (place in the scene, found and expected)."""
        if self.optimizer != "adam" or not any(container.periodic):
            return []
        expected = "expected projection in a periodic box; adam knows walls only"
        return [("params.optimizer", f"found adam, {expected}")]
