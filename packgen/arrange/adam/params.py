"""The settings of ADAM."""

from __future__ import annotations

from typing import ClassVar

from packgen.arrange.paper_params import PaperParams
from packgen.geometry import Container


class Params(PaperParams):
    """Settings of ADAM: those of the paper."""

    holds: ClassVar[tuple[str, ...]] = ("fixed",)

    def unsupported(self, container: Container) -> list[tuple[str, str]]:
        """Return the settings that cannot fill a container, as (place in the scene, found and expected)."""
        if not any(container.periodic):
            return []
        expected = "expected COLLECTIVE_ARRANGEMENT in a periodic box; adam knows walls only"
        return [("algorithm", f"found ADAM, {expected}")]
