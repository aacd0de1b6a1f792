"""LIGGGHTS and LAMMPS settle a bed: their deck, run in parts until it is still, and kept as it goes on."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from packgen.bed import Bed
from packgen.errors import SolverError
from packgen.settling.run import RUN_MAX, SILENCE_MAX, Left, Order
from packgen.validation import lammps as lammps_judge
from packgen.validation import liggghts as liggghts_judge
from packgen.validation.dump import read_dump
from packgen.validation.lammps_family import (
    INCLUDE,
    Dialect,
    deck_text,
    length_unit,
    printed_number,
    run_script,
)
from packgen.validation.process import describe_output
from packgen.validation.still import LOOKS, Look, Looks, look_of, loop_input, speed_unit, was_still

SCRIPT = "in.packgen_settle"
TIMESTEP_SCRIPT = "in.packgen_timestep"
KEPT, END = "packgen_kept", "packgen_end"
KEPT_COUNT = 2  # of the newest: the last one may be cut short

TIMESTEP = """\
variable packgen_timestep equal dt
print "packgen timestep ${packgen_timestep}"
"""
# At the start, and every free-fall time: where the spheres are, and a state to go on from.
KEEP = """\
dump packgen_kept all custom {every} {kept}_*.dump id xu yu zu
dump_modify packgen_kept format {line}"%d %.17g %.17g %.17g"
restart {every} {kept}_*.restart
variable packgen_count equal atoms
"""
LOST = 'if "${{packgen_count}} < {count}" then "jump SELF packgen_end"\n'
# The state comes before the last run, which lists neighbours anew.
FINISH = """\
restart 0
write_restart {end}.restart
undump packgen_kept
dump packgen_end all custom 1 {end}.dump id xu yu zu
dump_modify packgen_end format {line}"%d %.17g %.17g %.17g"
run 0 post no
"""


def _run(dialect: Dialect, order: Order) -> Left:
    """Settle a bed.

    Raises:
        SolverError: The solver does not run the deck to the end.
    """
    deck = deck_text(dialect.name, order.folder)
    unit = length_unit(deck)
    output = run_script(
        dialect.name, order.folder, TIMESTEP_SCRIPT, INCLUDE + TIMESTEP, SILENCE_MAX, RUN_MAX, None
    )
    found = re.search(dialect.version, "\n".join(output))
    files = _Files(
        order.bed, order.folder, unit, unit * printed_number(dialect.name, output, "packgen timestep"),
        found.group() if found else "",
    )  # fmt: skip
    order.kept.read = files.newest
    looks = order.looks(files.timestep)
    tell = order.progress(looks, files.timestep)

    def on_line(line: str) -> None:
        look = look_of(line)
        if look is not None:
            files.looks.append(look)
            files.forget_older()
            tell(look.step, look.speed)

    text = script_of(looks, order.bed.count, dialect.format_word, deck)
    output = run_script(dialect.name, order.folder, SCRIPT, text, SILENCE_MAX, RUN_MAX, on_line)
    still = was_still(output, looks)
    last = files.looks[-1] if files.looks else Look(0, 0, 0.0, 0.0)
    if not (still or last.step == looks.steps or last.count < order.bed.count):
        raise SolverError(
            f"{dialect.name}: ended before step {looks.steps}; it said:\n{describe_output(output)}"
        )
    try:
        return files.left(END, last, still=still)
    except SolverError as error:
        raise SolverError(f"{dialect.name}: {error}; it said:\n{describe_output(output)}") from error


def script_of(looks: Looks, count: int, format_word: str, deck: str = "") -> str:
    """Return the input that settles a bed.

    Args:
        looks: When it is looked at.
        count: Spheres; the run ends where one is lost.
        format_word: What stands before the format of a dump of spheres.
        deck: The text of the deck.
    """
    keep = KEEP.format(every=LOOKS * looks.every, kept=KEPT, line=format_word)
    loop = loop_input(looks, deck=deck, before=keep, each=LOST.format(count=count))
    return INCLUDE + loop + FINISH.format(end=END, line=format_word)


class _Files:
    """What a run writes, and the looks at it.

    Args:
        bed: The bed.
        folder: Where it runs.
        unit: The deck's unit of length [m].
        timestep: Its time step [s].
        version: What the solver calls itself.
    """

    def __init__(self, bed: Bed, folder: Path, unit: float, timestep: float, version: str) -> None:
        self._speed_unit, self._folder, self._unit = speed_unit(bed), folder, unit
        self.timestep, self._version = timestep, version
        self.looks: list[Look] = []

    def left(self, name: str, look: Look, *, still: bool = False) -> Left:
        """Return what a dump has, with the state of the same name where there is one.

        Raises:
            SolverError: The dump cannot be read.
        """
        rows = read_dump(self._folder / f"{name}.dump", 4)
        restart = self._folder / f"{name}.restart"
        return Left(
            index=rows[:, 0].astype(np.int64) - 1,
            position=self._unit * rows[:, 1:4],
            steps=look.step,
            time=look.step * self.timestep,
            speed=look.speed / self._speed_unit,
            still=still,
            version=self._version,
            restart=restart if restart.exists() else None,
        )

    def newest(self) -> Left | None:
        """Return what was kept last; None where nothing whole was."""
        for step in reversed(self._steps()):
            speeds = [each.speed for each in self.looks if each.step <= step]
            look = Look(step, 0, 0.0, speeds[-1] if speeds else 0.0)
            try:
                return self.left(f"{KEPT}_{step}", look)
            except SolverError:  # cut short
                continue
        return None

    def forget_older(self) -> None:
        """Remove what was kept before the newest."""
        for step in self._steps()[:-KEPT_COUNT]:
            for suffix in ("dump", "restart"):
                (self._folder / f"{KEPT}_{step}.{suffix}").unlink(missing_ok=True)

    def _steps(self) -> list[int]:
        """Return the steps of which something is kept, that are surely written."""
        reached = self.looks[-1].step if self.looks else -1
        names = [path.stem.rpartition("_")[2] for path in self._folder.glob(f"{KEPT}_*.dump")]
        return sorted(int(name) for name in names if name.isdigit() and int(name) <= reached)


liggghts: Callable[[Order], Left] = partial(_run, liggghts_judge.DIALECT)
lammps: Callable[[Order], Left] = partial(_run, lammps_judge.DIALECT)
