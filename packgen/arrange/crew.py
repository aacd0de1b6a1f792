"""Who does the work of a bed that is divided: this process, or others."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol


class Done(NamedTuple):
    """A call that has been made.

    Attributes:
        key: What it was handed out as.
        result: What it returned.
    """

    key: Any
    result: Any


class Crew(Protocol):
    """Makes calls in some process, each at least once and in any order."""

    @property
    def folder(self) -> Path | None:
        """Folder that all processes see, where what they make is kept; None: a temporary one here."""

    @property
    def threads(self) -> int | None:
        """Threads of a call at most; None: as many as the run has."""

    def hand_out(self, key: Any, call: Callable[..., Any], *arguments: Any) -> None:
        """Have a call made; where its process ends before it does, it is made again."""

    def next_done(self) -> Done:
        """Wait for a call that was handed out; each is told of once."""


@dataclass(slots=True)
class Alone:
    """This process does all of it, one call after the other.

    Attributes:
        folder: Where what is made is kept; None: in a temporary folder.
        threads: Threads of a call at most; None: as many as the run has.
    """

    folder: Path | None = None
    threads: int | None = None
    _calls: deque[tuple[Any, Callable[..., Any], tuple[Any, ...]]] = field(default_factory=deque)

    def hand_out(self, key: Any, call: Callable[..., Any], *arguments: Any) -> None:
        """Put a call in line."""
        self._calls.append((key, call, arguments))

    def next_done(self) -> Done:
        """Make the next call."""
        key, call, arguments = self._calls.popleft()
        return Done(key, call(*arguments))
