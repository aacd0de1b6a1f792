"""``bed.npz``: the spheres of a bed as plain arrays that any numpy reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from packgen.bed import Bed


def save_bed(bed: Bed, path: Path) -> None:
    """Write a bed's arrays; equal beds give equal files, byte for byte.

    Keys: ``position`` (N, 3) float64 [m]; ``radius`` (N,) float64 [m]; ``set_index``, ``zone_index``,
    ``batch_index`` (N,) int32; ``provenance``, JSON text.

    Args:
        bed: The bed.
        path: File to write.

    Raises:
        OSError: The file cannot be written.
    """
    arrays: dict[str, Any] = {
        "position": bed.position,
        "radius": bed.radius,
        "set_index": bed.set_index,
        "zone_index": bed.zone_index,
        "batch_index": bed.batch_index,
        "provenance": np.array(json.dumps(plain(bed.provenance), sort_keys=True)),
    }
    np.savez(path, **arrays)


def plain(value: Any) -> Any:
    """Return settings as JSON holds them: dicts, lists, strings, numbers; paths become text."""
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(each) for each in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)
