"""Reading the text dumps that a solver was told to write: one step a file, of spheres, pairs or walls.

What a solver writes may be no number where a bed is faulty: nan is passed on. `packgen.reading.dump` reads
the dumps of others, and says what is wrong with them.
"""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.errors import ReadError, SolverError
from packgen.reading.dump import head_of
from packgen.reading.text import decoded, read_text


def read_dump(path: Path, column_count: int) -> Float64Array:
    """Return the rows of a dump file of one step, shape (rows, column_count), float64.

    Raises:
        SolverError: The file is missing or is not what the dump command was to write.
    """
    try:
        text = read_text(path)
        head = head_of(text, 0, len(text.data), pairs=True)
        count = int(head.count)
        lines = io.StringIO(decoded(text.data[head.start :]))
        rows = np.loadtxt(lines, dtype=np.float64, ndmin=2) if count > 0 else np.zeros((0, column_count))
    except FileNotFoundError:
        raise SolverError(f"the solver ended without writing {path.name}") from None
    except (OSError, ReadError, ValueError) as error:
        raise SolverError(f"the solver wrote a {path.name} that cannot be read: {error}") from error
    if rows.shape != (count, column_count):
        raise SolverError(
            f"the solver wrote a {path.name} of shape {rows.shape}, expected {(count, column_count)}"
        )
    return rows
