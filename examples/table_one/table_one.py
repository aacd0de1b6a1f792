"""The paper's Table I, row by row, as runs: each approach by its algorithm, and other programmes beside them.

    python examples/table_one/table_one.py

It writes results/table_one.csv, and the table of README.md from it. Each bed is made in a process of its own,
or by the other programme, then checked and measured by packgen.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests" / "benchmarks"))

import machine
import peers
import yaml

from packgen.summary import main_figures

HERE = Path(__file__).resolve().parent
RESULTS, PAGE = HERE / "results" / "table_one.csv", HERE / "README.md"
BEGIN, END = "<!-- table -->\n", "<!-- end of table -->\n"
COLUMNS = (
    "approach", "by", "scene", "may_change", "sphere_count", "solid_fraction_filled", "solid_fraction_core",
    "overlap_max", "coordination", "rattlers", "crystal", "law_distance", "seconds", "message",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Entry:
    """A row: the approach of the paper's table, the algorithm that is it, the scene, what else is asked."""

    approach: str
    algorithm: str
    scene: str = "box"
    may_change: str = "nothing"
    options: tuple[str, ...] = ()


ENTRIES = (
    Entry("Lubachevsky-Stillinger", "JAMMED", may_change="container"),
    Entry("Adaptive Shrinking Cell", "SHRINKING_CELL", "cell", "container"),
    Entry("Sutou & Dai", "OPTIMAL", "few", "count"),
    Entry("Campello & Cassares", "COLLECTIVE_ARRANGEMENT", options=("--settle", "liggghts")),
    Entry("ProtoSphere, XProtoSphere", "VOID_FILLING"),
    Entry("Jerier et al.", "ADVANCING_FRONT"),
    Entry("the paper's Adam", "ADAM"),
    Entry("packgen", "COLLECTIVE_ARRANGEMENT"),
)


def run(entry: Entry, folder: Path) -> dict[str, Any]:
    """Return the row of an algorithm of packgen."""
    command = [
        sys.executable, "-m", "packgen", str(HERE / f"{entry.scene}.yaml"), "-o", str(folder), "--quiet",
        "--json", "--no-report", "--set", f"algorithm={entry.algorithm}", *entry.options,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    by = " ".join([entry.algorithm, *entry.options])
    row = {"approach": entry.approach, "by": by, "scene": entry.scene, "may_change": entry.may_change}
    if done.returncode > 1:
        return row | {"message": done.stderr.strip().splitlines()[-1]}
    found = json.loads(done.stdout)
    seconds = sum(found["timings"].get(stage, 0.0) for stage in ("arrange", "settle"))
    return {**found, **row, "seconds": seconds, "message": "; ".join(found["missed"])}


def run_peer(peer: peers.Peer, folder: Path) -> dict[str, Any]:
    """Return the row of another programme, on the spheres that packgen draws for the box."""
    scene = yaml.safe_load((HERE / "box.yaml").read_text(encoding="utf-8"))
    law, extent = scene["particle_sets"][0], np.array(scene["container"]["box"]["max"], float)
    count = scene["zones"][0]["n_particles"]
    radius = np.random.default_rng(0).uniform(law["radius_min"], law["radius_max"], count)
    start = time.perf_counter()
    position, radius, extent = peer.make(radius, extent, 0)
    seconds = time.perf_counter() - start
    folder.mkdir()
    np.savetxt(folder / "bed.csv", np.column_stack([position, radius]), "%.17g", ",", header="x,y,z,radius",
               comments="")  # fmt: skip
    scene["container"]["box"]["max"] = extent.tolist()
    (folder / "box.yaml").write_text(yaml.safe_dump(scene), encoding="utf-8")
    command = [
        sys.executable, "-m", "packgen", "measure", str(folder / "bed.csv"), "--scene",
        str(folder / "box.yaml"), "-o", str(folder / "measured"), "--no-report", "--quiet",
    ]  # fmt: skip
    subprocess.run(command, capture_output=True, text=True, check=False)
    report = json.loads((folder / "measured" / "report.json").read_text(encoding="utf-8"))
    return {
        **main_figures(report), "approach": "another programme", "by": peer.name, "scene": "box",
        "may_change": peer.may_change, "seconds": seconds, "message": "; ".join(report["missed"]),
    }  # fmt: skip


def measure(entries: Sequence[Entry], others: Sequence[peers.Peer]) -> Iterator[dict[str, Any]]:
    """Yield the rows; what is not installed is left out."""
    with tempfile.TemporaryDirectory() as folder:
        for place, entry in enumerate(entries):
            yield run(entry, Path(folder) / f"packgen_{place}")
        for place, peer in enumerate(each for each in others if each.is_there):
            yield run_peer(peer, Path(folder) / f"peer_{place}")


def markdown(rows: Sequence[dict[str, str]]) -> str:
    """Return the table of the page."""

    def number(row: dict[str, str], name: str, form: str) -> str:
        return format(float(row[name]), form) if row[name] else "-"

    head = (
        "Approach in the paper's table", "here", "scene", "may change", "spheres", "solid fraction", "core",
        "largest overlap [r]", "contacts", "rattlers", "crystal", "time [s]",
    )  # fmt: skip
    lines = [head, ("---",) * len(head)]
    lines += [
        (
            row["approach"], f"`{row['by']}`", row["scene"], row["may_change"],
            number(row, "sphere_count", ",.0f"), number(row, "solid_fraction_filled", ".4f"),
            number(row, "solid_fraction_core", ".4f"), number(row, "overlap_max", ".0e"),
            number(row, "coordination", ".2f"), number(row, "rattlers", ".1%"),
            number(row, "crystal", ".1%"), number(row, "seconds", ".3g"),
        )
        for row in rows
    ]  # fmt: skip
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def read() -> list[dict[str, str]]:
    """Return the rows of the committed file."""
    with RESULTS.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))


def page() -> str:
    """Return README.md with the table of the committed file."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + markdown(read()) + END + rest.split(END)[1]


def main() -> None:
    """Read the command line, run, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.parse_args()
    facts = machine.facts(0)
    RESULTS.parent.mkdir(exist_ok=True)
    with RESULTS.open("w", encoding="utf-8", newline="") as stream:
        stream.writelines(f"# {key}: {value}\n" for key, value in facts.items())
        table = csv.DictWriter(stream, COLUMNS, extrasaction="ignore", lineterminator="\n")
        table.writeheader()
        for row in measure(ENTRIES, peers.PEERS):
            table.writerow(row)
            stream.flush()
            print({name: row.get(name) for name in COLUMNS}, flush=True)
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
