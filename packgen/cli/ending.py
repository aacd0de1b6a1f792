"""What is true of a run's results, at every moment: what the last line may claim, and the exit code."""

from __future__ import annotations

import sys

from packgen.cli.screen import say
from packgen.stopping import heed

EXIT_INTERRUPTED = 130
NOTHING = "nothing was written"
WHOLE_PAGES = "each page is whole, the new one or the one before"


class Ending:
    """How a run stands.

    Attributes:
        claim: What is true of its results, as the end of a sentence.
        code: The exit code of the results; None as long as they have not their final name.
        was_interrupted: Whether the last line says so.
    """

    def __init__(self) -> None:
        self.claim = NOTHING
        self.code: int | None = None
        self.was_interrupted = False
        self._told = False

    def done(self, code: int, claim: str) -> None:
        """Note that the results have their final name.

        Args:
            code: Exit code that they have, whatever happens to the lines about them.
            claim: What is true from now on.
        """
        self.code, self.claim = code, claim
        heed()

    def interrupted(self) -> int:
        """Say that the run was interrupted, and what there is; return the exit code."""
        self.was_interrupted = True
        joint = "" if self.code is None else " but"
        return self.fail(f"interrupted,{joint} {self.claim}", EXIT_INTERRUPTED)

    def fail(self, message: str, code: int) -> int:
        """Say why the run ends.

        Args:
            message: The reason; a line each.
            code: Exit code where there are no results.

        Returns:
            The exit code.
        """
        lines, self._told = ([] if self._told else message.splitlines() or [""]), True
        for line in lines:
            say(f"packgen: {line}", sys.stderr)
        return code if self.code is None else self.code
