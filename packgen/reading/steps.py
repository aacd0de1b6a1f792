"""Which step of a file of several is read: the last one, or the one that is named."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from packgen.filefaults import fault

SHOWN_MAX = 10


def place_of_step(path: Path, steps: Sequence[int | None], wanted: int | None) -> int:
    """Return the place of a step among those of a file; the last one where none is named.

    Raises:
        ReadError: The file does not have it.
    """
    if wanted is None:
        return len(steps) - 1
    if wanted not in steps:
        known = [str(each) for each in steps if each is not None]
        rest = f" and {len(known) - SHOWN_MAX} more" if len(known) > SHOWN_MAX else ""
        there = ", ".join(known[:SHOWN_MAX]) + rest if known else "one that has no number"
        raise fault(
            path, f"no step {wanted}", f"one of its steps, {there}", remedy="name another with --step"
        )
    return len(steps) - 1 - list(reversed(steps)).index(wanted)


def refuse_step(path: Path, kind: str, wanted: int | None) -> None:
    """Refuse a step of a file that has no steps.

    Raises:
        ReadError: One is named.
    """
    if wanted is not None:
        raise fault(
            path, f"a {kind}, which has no steps", f"a file with step {wanted}", remedy="leave --step out"
        )
