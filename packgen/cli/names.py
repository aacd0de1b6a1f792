"""File names that are not valid text: results, pages and decks are UTF-8."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable

from packgen.errors import PackgenError


def refuse_unreadable(names: Iterable[str]) -> None:
    """Refuse names of files with bytes that are not valid text.

    Args:
        names: Arguments, or names of files, as Python gives them: such bytes are lone surrogates.

    Raises:
        PackgenError: One is not text.
    """
    for name in names:
        try:
            name.encode()
        except UnicodeEncodeError as error:
            shown = os.fsencode(name).decode("utf-8", "backslashreplace")
            encoding = sys.getfilesystemencoding()
            other = "" if encoding == "utf-8" else ", or set PYTHONUTF8=1"
            raise PackgenError(
                f"{shown}: found a name that is not {encoding}, expected one that is; rename it{other}"
            ) from error
