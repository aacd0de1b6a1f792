"""A setting that is ``auto``, true or false."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator

__all__ = ["AutoOrFlag"]


def _auto_or_flag(value: object) -> object:
    """Return ``auto``, true or false as it is.

    Raises:
        ValueError: It is none of them.
    """
    if value == "auto" or isinstance(value, bool):
        return value
    raise ValueError("auto, true or false")


AutoOrFlag = Annotated[Literal["auto"] | bool, BeforeValidator(_auto_or_flag)]
