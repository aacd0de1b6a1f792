"""What 1e9 spheres would take on a cluster, by simulation of the units of their bed: what breaks first.

    python tests/benchmarks/plan_1e9/simulate.py --out DIR [--measured tests/benchmarks/results/workers.csv]

The units, and which waits for which, are those that packgen hands out for equal spheres in a cube. What each
takes is measured: the time of a sphere on one core, the bytes that a unit writes a sphere, and the
scheduler's time for a call, all from workers.csv. Two numbers are assumed, as no cluster was at hand: how
well a machine's cores share a unit, and how fast a machine reads and writes files that all see.

The scheduler does one thing at a time: each unit takes it the time of a call, half of it before the unit
starts and half after its end. A machine works on one unit at a time, with all its cores.

Writes plan_1e9.csv and plan_1e9.txt into DIR.
"""

from __future__ import annotations

import argparse
import csv
import heapq
import sys
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))

import machine
import output

from packgen.arrange.collective.tiles.layout import TileLayout, Unit
from packgen.arrange.space.columns import ColumnMap

RESULTS = Path(__file__).resolve().parents[1] / "results"
SPHERES = 1_000_000_000
A_CUBE_DIAMETER = 1.15  # spheres in a cube as wide as one
LAYER = 2.0  # thickness of a layer, in diameters
FRONT = 7.0  # depth of the spheres that units hand on, in diameters
ROW = 40  # bytes of a sphere in a file
ARRAYS = 390  # bytes a sphere of a process that checks and measures a bed: 3.9 GB of 10,000,000
SATURATED = 0.5  # share of its time from which on a scheduler holds machines up
DRAWN = 12  # bytes of a radius and a set


@dataclass(frozen=True, slots=True)
class Plan:
    """A cluster and what things take on it.

    Attributes:
        nodes: Machines.
        cores: Cores of each.
        tile: Least width of a tile, in diameters; None: packgen's choice.
        call: The scheduler's time for a unit [s].
        sphere: Time of a sphere on one core [s].
        shared: Share of a unit's time that its cores divide, from 0 to 1: what Amdahl's law wants.
        written: Bytes that a unit writes a sphere that it adds.
        bandwidth: Of a machine's files [bytes/s].
        spheres: How many spheres.
    """

    nodes: int
    cores: int
    tile: float | None
    call: float
    sphere: float
    shared: float
    written: float
    bandwidth: float
    spheres: int = SPHERES

    @property
    def side(self) -> float:
        """Side of the cube, in diameters."""
        return float((self.spheres / A_CUBE_DIAMETER) ** (1.0 / 3.0))

    @property
    def layers(self) -> int:
        """Layers of the bed."""
        return int(self.side / LAYER)

    def unit_time(self, area: float) -> float:
        """Return what a unit takes whose tile has some area [square diameters], in seconds."""
        spheres = area * LAYER * A_CUBE_DIAMETER
        speed = 1.0 / (1.0 - self.shared + self.shared / self.cores)
        return spheres * self.sphere / speed + 2.0 * spheres * self.written / self.bandwidth


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a simulation finds.

    Attributes:
        units: Units of the bed.
        tiles: Tiles of a layer.
        seconds: From the first unit to the last.
        busy: Share of the machines' time in units.
        scheduler: Share of the scheduler's time that it is busy.
        ideal: Seconds, if all machines were always busy.
    """

    units: int
    tiles: int
    seconds: float
    busy: float
    scheduler: float
    ideal: float


def layout_of(side: float, tile: float | None) -> TileLayout:
    """Return the tiles of a cube so many diameters wide."""
    count = round(side)
    columns = ColumnMap(np.eye(3), np.ones(2), (count, count), np.zeros(2), (False, False))
    return TileLayout.over(columns, tile, 1.0)


def simulate(plan: Plan, layers: int | None = None) -> Outcome:
    """Run the units of a plan on its machines.

    Args:
        plan: The plan.
        layers: How many layers are simulated, from which the time of all of them follows; None: all.
    """
    layout = layout_of(plan.side, plan.tile)
    simulated = min(layers or plan.layers, plan.layers)
    waits, followers = _graph(plan.side, plan.tile, simulated)
    waits = dict(waits)
    taken = {
        unit: plan.unit_time(float(np.prod([end - begin for begin, end in layout.tile(unit)])))
        for unit in waits
    }
    ready = deque(unit for unit, count in waits.items() if count == 0)
    ended: list[tuple[float, Unit]] = []
    free, now, work, calls = plan.nodes, 0.0, 0.0, 0
    while ready or ended:
        # The scheduler hears of ends first: they are what others wait for.
        if ended and (ended[0][0] <= now or not ready or free == 0):
            at, unit = heapq.heappop(ended)
            now = max(now, at) + 0.5 * plan.call
            free += 1
            for other in followers.get(unit, ()):
                waits[other] -= 1
                if waits[other] == 0:
                    ready.append(other)
        else:
            unit = ready.popleft()
            now += 0.5 * plan.call
            free -= 1
            heapq.heappush(ended, (now + taken[unit], unit))
            work += taken[unit]
        calls += 1
    scale = plan.layers / simulated
    return Outcome(
        round(len(taken) * scale),
        len(layout.tiles),
        now * scale,
        work / (plan.nodes * now),
        0.5 * plan.call * calls / now,
        work * scale / plan.nodes,
    )


@cache
def _graph(
    side: float, tile: float | None, layers: int
) -> tuple[Mapping[Unit, int], Mapping[Unit, list[Unit]]]:
    """Return how many units each one waits for, and which wait for each."""
    layout = layout_of(side, tile)
    waits: dict[Unit, int] = {}
    followers: dict[Unit, list[Unit]] = {}
    for layer in range(layers):
        for unit in layout.order(layer):
            sources = layout.sources(unit)
            waits[unit] = len(sources)
            for each in sources:
                followers.setdefault(each, []).append(unit)
    return waits, followers


def measured(path: Path) -> dict[str, float]:
    """Return what workers.csv says: seconds of a call and a sphere, bytes that a unit writes a sphere."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    by_what: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        by_what.setdefault(row["what"], []).append(row)
    alone = by_what["1 process"]
    spheres, units = float(alone[0]["spheres"]), float(alone[0]["units"])
    return {
        "call": float(by_what["call"][0]["seconds"]),
        "sphere": median(float(row["seconds"]) for row in alone) / spheres,
        "written": 1e6 * float(by_what["unit"][0]["written_MB"]) / (spheres / units),
    }


def cases(found: Mapping[str, float], shared: float, bandwidth: float) -> list[tuple[str, Plan]]:
    """Return the plans by name: each changes one thing of the first."""
    first = Plan(64, 16, None, found["call"], found["sphere"], shared, found["written"], bandwidth)
    return [
        ("as it is", first),
        ("tiles of 30 diameters", replace(first, tile=30.0)),
        ("tiles of 100 diameters", replace(first, tile=100.0)),
        ("a scheduler 5 times as fast", replace(first, call=0.2 * first.call)),
        ("a scheduler 5 times as slow", replace(first, call=5.0 * first.call)),
        ("cores that share all of a unit", replace(first, shared=1.0)),
        ("files 10 times as slow", replace(first, bandwidth=0.1 * first.bandwidth)),
        ("16 machines", replace(first, nodes=16)),
        ("256 machines", replace(first, nodes=256)),
        ("one machine of 16 cores", replace(first, nodes=1)),
    ]


def what_breaks(outcome: Outcome, plan: Plan) -> list[str]:
    """Return the limits in the order in which they are met."""
    gigabytes = plan.spheres / 1e9
    front = (plan.side**2) * FRONT * A_CUBE_DIAMETER * ROW / 1e9
    minutes = outcome.units * plan.call / 60.0
    last = 1.5 / plan.layers * outcome.ideal * plan.nodes
    memory = [
        "1. The memory of the process that hands units out, whatever the cluster. It draws all radii",
        f"   ({DRAWN * gigabytes:.0f} GB), gathers the bed ({ROW * gigabytes:.0f} GB), checks and measures "
        f"it ({ARRAYS * gigabytes:.0f} GB). A tenth of these spheres",
        "   is what a machine of 64 GB takes. What units leave is in files by unit: check, measures, decks",
        "   have to go through these.",
    ]
    scheduler = [
        f"2. The scheduler, busy for {outcome.scheduler:.0%} of the time: machines wait for it. At",
        f"   {1e3 * plan.call:.1f} ms a unit, {outcome.units:,} units take {minutes:.1f} min.",
    ]
    others = [
        f"3. The number of tiles: a quarter of {outcome.tiles} work at a time, more than "
        f"{outcome.tiles // 4} machines have nothing to do.",
        f"4. The last layers, one piece on one machine: one or two of {plan.layers}, {last:.0f} s.",
    ]
    unbroken = [
        f"A worker's memory does not break: the surface of {front:.1f} GB is divided among the tiles, "
        f"{1e3 * front / outcome.tiles:.1f} MB each.",
        f"Disks hold {ROW * gigabytes:.0f} GB of spheres, and the blocks of two layers.",
    ]
    held_up = scheduler if outcome.scheduler > SATURATED else []
    return ["What breaks first, and next:", "", *memory, *held_up, *others, "", *unbroken]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the simulation."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--measured", type=Path, default=RESULTS / "workers.csv")
    parser.add_argument(
        "--layers", type=int, default=40, help="layers that are simulated, of all that there are"
    )
    parser.add_argument("--shared", type=float, default=0.9, help="share of a unit that its cores divide")
    parser.add_argument("--bandwidth", type=float, default=5e8, help="of a machine's files [bytes/s]")
    given = parser.parse_args(arguments)
    found = measured(given.measured)
    plans = cases(found, given.shared, given.bandwidth)
    outcomes = [simulate(plan, given.layers) for _, plan in plans]
    facts = machine.facts(0) | {
        "measured": f"{1e6 * found['sphere']:.1f} us a sphere, {1e3 * found['call']:.2f} ms a call, "
        f"{found['written']:.0f} bytes written a sphere",
        "assumed": f"cores share {given.shared:.0%} of a unit, "
        f"files at {given.bandwidth / 1e6:.0f} MB/s a machine",
        "simulated": f"{given.layers} of {plans[0][1].layers} layers",
    }
    given.out.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Any]] = []
    lines = []
    for (name, plan), each in zip(plans, outcomes, strict=True):
        rows.append(
            {"case": name, "machines": plan.nodes, "tiles": each.tiles, "units": each.units}
            | {"seconds": each.seconds, "ideal": each.ideal, "busy": each.busy, "scheduler": each.scheduler}
        )
        lines.append(
            (
                name,
                f"{each.tiles:,}",
                f"{each.units:,}",
                f"{each.seconds / 60:.1f}",
                f"{each.ideal / 60:.1f}",
                f"{each.busy:.0%}",
                f"{each.scheduler:.0%}",
            )
        )
    output.write_csv(given.out / "plan_1e9.csv", rows, facts)
    head = (
        "64 machines of 16 cores, but for",
        "tiles",
        "units",
        "min",
        "ideal [min]",
        "busy",
        "scheduler busy",
    )
    title = f"{SPHERES:.0e} equal spheres in a cube of {plans[0][1].side:.0f} diameters, by simulation"
    notes = what_breaks(outcomes[0], plans[0][1])
    output.write_text(given.out / "plan_1e9.txt", title, facts, [output.table(head, lines)], notes)


if __name__ == "__main__":
    main()
