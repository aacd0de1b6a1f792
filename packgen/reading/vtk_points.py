"""A program of its own: ``vtk_points.py FILE OUT`` writes the points of a VTK file as an archive of numpy.

On a damaged file VTK may end the process that it runs in (``std::bad_alloc``): it gets one of its own.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np


def main(path: str, target: str) -> int:
    """Read a file's points and their arrays; return 0 where VTK has read all of it.

    Args:
        path: The file; its ending says what it is.
        target: Archive to write: ``points`` (N, 3) float64, ``names``, and ``array_0``, ``array_1``, ...
    """
    from vtkmodules.util import numpy_support
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

    to_numpy: Any = numpy_support.vtk_to_numpy
    # VTK prints what is wrong and goes on with a part of the file: what it prints is an error here.
    said = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(said)
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    reader = reader_of(Path(path).suffix.lower())
    reader.SetFileName(path)
    reader.Update()
    mesh = reader.GetOutput()
    if said.GetOutput().strip() or mesh is None or mesh.GetPoints() is None:
        return 1
    points = np.asarray(to_numpy(mesh.GetPoints().GetData()), dtype=np.float64)
    data = mesh.GetPointData()
    found = [data.GetArray(index) for index in range(data.GetNumberOfArrays())]
    arrays = [each for each in found if each is not None]
    content = {f"array_{place}": to_numpy(each) for place, each in enumerate(arrays)}
    np.savez(target, points=points, names=np.array([str(each.GetName()) for each in arrays]), **content)
    return 0


def reader_of(suffix: str) -> Any:
    """Return VTK's reader of files with an ending."""
    if suffix == ".vtk":
        from vtkmodules.vtkIOLegacy import vtkDataSetReader

        reader = vtkDataSetReader()
        reader.ReadAllScalarsOn()
        reader.ReadAllFieldsOn()
        return reader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

    return vtkXMLPolyDataReader() if suffix == ".vtp" else vtkXMLUnstructuredGridReader()


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
