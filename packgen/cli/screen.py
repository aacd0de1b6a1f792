"""Lines of text for the user. A line that cannot be shown is lost, and the run goes on."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Sequence
from typing import Any, TextIO

DEBUG_VARIABLE = "PACKGEN_DEBUG"  # set: faults of packgen show where they happened


def open_streams() -> None:
    """Give closed standard streams somewhere to go: a file opened later would take their place."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115


def say(text: str, stream: TextIO) -> None:
    """Write a line; where that fails, this and all that follows on the stream is lost and nothing else."""
    show(text + "\n", stream)


def show(text: str, stream: TextIO) -> None:
    """Write text as it is. Characters that the stream's encoding lacks are written as their codes.

    Raises:
        KeyboardInterrupt: It came while nobody read; the stream is given up.
    """
    try:
        try:
            stream.write(text)
        except UnicodeEncodeError as error:
            stream.write(text.encode(error.encoding, "backslashreplace").decode(error.encoding))
        stream.flush()
    except (OSError, ValueError) as error:  # full, gone, or closed
        _give_up(stream)
        if stream is sys.stdout and not isinstance(error, BrokenPipeError):
            reason = getattr(error, "strerror", None) or error
            say(f"packgen: standard output cannot be written: {reason}", sys.stderr)
    except KeyboardInterrupt:
        _give_up(stream)
        raise


def _give_up(stream: TextIO) -> None:
    """Send a stream nowhere: what is still buffered would fail, or wait, again at exit."""
    with contextlib.suppress(OSError, ValueError):
        number = stream.fileno()
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, number)
        os.close(nowhere)


def say_json(content: Any) -> None:
    """Write plain data as JSON on standard output; what JSON has no number for becomes null."""
    finite = json.loads(json.dumps(content), parse_constant=lambda _: None)
    say(json.dumps(finite, indent=2, ensure_ascii=False), sys.stdout)


class Screen:
    """A stream for libraries that write by themselves: as `show` does, without an error.

    Args:
        stream: Where to write.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write text."""
        show(text, self._stream)
        return len(text)

    def flush(self) -> None:
        """Do nothing: all is written at once."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def table(rows: Sequence[tuple[str, ...]]) -> str:
    """Return rows as text in columns."""
    widths = [max(len(text) for text in column) for column in zip(*rows, strict=True)]
    lines = ("  ".join(f"{text:<{width}}" for text, width in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)
