"""Reading the text dumps of LIGGGHTS and LAMMPS, one frame a file (LAMMPS manual, page "dump")."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from packgen.arrays import Float64Array
from packgen.errors import SolverError


def read_dump(path: Path, column_count: int) -> Float64Array:
    """Return the rows of a dump file of one frame, shape (rows, column_count), float64.

    Raises:
        SolverError: The file is missing or is not what the dump command was to write.
    """
    try:
        with path.open(encoding="ascii", errors="replace") as file:
            count = -1
            for line in file:
                if line.startswith("ITEM: NUMBER OF"):
                    count = int(next(file))
                if line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
                    break
            rows = np.loadtxt(file, dtype=np.float64, ndmin=2) if count > 0 else np.zeros((0, column_count))
    except FileNotFoundError:
        raise SolverError(f"the solver ended without writing {path.name}") from None
    except (ValueError, StopIteration) as error:
        raise SolverError(f"the solver wrote a {path.name} that cannot be read: {error}") from error
    if rows.shape != (count, column_count):
        raise SolverError(
            f"the solver wrote a {path.name} of shape {rows.shape}, expected {(count, column_count)}"
        )
    return rows
