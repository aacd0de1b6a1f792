"""Lines of text for the user."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TextIO

DEBUG_VARIABLE = "PACKGEN_DEBUG"  # set: faults of packgen show where they happened


def say(text: str, stream: TextIO) -> None:
    """Write a line; a reader that has gone away is no error."""
    try:
        stream.write(text + "\n")
        stream.flush()
    except BrokenPipeError:
        # What is still buffered would raise again at exit.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def table(rows: Sequence[tuple[str, ...]]) -> str:
    """Return rows as text in columns."""
    widths = [max(len(text) for text in column) for column in zip(*rows, strict=True)]
    lines = ("  ".join(f"{text:<{width}}" for text, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)
