"""Hands out the units of a round, each once those that it stands on are done."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping

from packgen.arrange.collective.tiles.layout import TileLayout, Unit
from packgen.arrange.collective.tiles.store import Store, UnitReport
from packgen.arrange.collective.tiles.work import Deal, run_unit
from packgen.arrange.crew import Crew

OnUnit = Callable[[Unit, UnitReport], None]


class Driver:
    """Runs units in any order that their sources allow; each order makes the same bed.

    Args:
        layout: The tiles.
        store: What units hand on.
        crew: Who does the work.
        threads: Threads of a unit at most; None: as many as cores are free where it runs.
        on_unit: Called after each unit.
    """

    def __init__(
        self, layout: TileLayout, store: Store, crew: Crew, threads: int | None, on_unit: OnUnit
    ) -> None:
        self._layout, self._store, self._crew, self._threads = layout, store, crew, threads
        self._on_unit = on_unit

    def run(self, first: int, last: int, deals: Mapping[tuple[int, int], Deal]) -> None:
        """Run all units of some layers, whose spheres each tile has.

        Args:
            first: The first layer.
            last: The last one.
            deals: The spheres of each tile, by its place.
        """
        waits, followers = self._graph(first, last)
        left = Counter(unit.layer for unit in waits)

        def hand_out(unit: Unit) -> None:
            self._crew.hand_out(unit, run_unit, self._store, unit, deals[unit.u, unit.v], self._threads)

        for unit, count in waits.items():
            if count == 0:
                hand_out(unit)
        for _ in range(len(waits)):
            done = self._crew.next_done()
            unit = Unit(*done.key)
            self._on_unit(unit, done.result)
            for other in followers.get(unit, ()):
                waits[other] -= 1
                if waits[other] == 0:
                    hand_out(other)
            left[unit.layer] -= 1
            if left[unit.layer] == 0 and unit.layer > 0:
                # Blocks are read by their own layer and the next one alone.
                for below in self._layout.order(unit.layer - 1):
                    self._store.forget(below)

    def _graph(self, first: int, last: int) -> tuple[dict[Unit, int], dict[Unit, list[Unit]]]:
        """Return how many units of these layers each one waits for, and which wait for each."""
        waits: dict[Unit, int] = {}
        followers: dict[Unit, list[Unit]] = {}
        for layer in range(first, last + 1):
            for unit in self._layout.order(layer):
                sources = [each for each in self._layout.sources(unit) if each.layer >= first]
                waits[unit] = len(sources)
                for each in sources:
                    followers.setdefault(each, []).append(unit)
        return waits, followers
