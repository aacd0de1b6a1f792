"""The one door through which arrays enter the project's data types."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]
Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]


def read_only(value: Any, dtype: type[np.generic], shape: tuple[int | None, ...], name: str) -> NDArray[Any]:
    """Return ``value`` as a read-only, C-contiguous array of the wanted dtype and shape.

    Args:
        value: Anything that numpy turns into an array; an array that already fits is not copied.
        dtype: Wanted dtype.
        shape: Wanted shape; None stands for any length.
        name: What to call the array in the error.

    Returns:
        A view (or a copy, where conversion was needed) that cannot be written to.

    Raises:
        ValueError: The shape differs; the message gives both.
    """
    array = np.ascontiguousarray(value, dtype=dtype)
    fits = array.ndim == len(shape) and all(
        want is None or want == got for want, got in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = tuple("any" if want is None else want for want in shape)
        raise ValueError(f"{name}: shape {array.shape}, expected {wanted}")
    view = array.view()
    view.flags.writeable = False
    return view
