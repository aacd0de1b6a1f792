"""Lines of text for the user."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TextIO


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


def table(rows: Sequence[tuple[str, str]]) -> str:
    """Return rows of a label and a value as aligned text."""
    width = max((len(label) for label, _ in rows), default=0)
    return "\n".join(f"{label:<{width}}  {value}" for label, value in rows)
