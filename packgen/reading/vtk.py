"""VTK's files of points (vtp, vtu, vtk), as packgen, LIGGGHTS and ParaView write them.

Arrays of the points: ``radius`` or ``diameter``, and where there are any ``id``, ``set``, ``type``,
``density``, ``zone``, ``batch``, in capitals or not.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import Float64Array
from packgen.reading.faults import Faults, fault
from packgen.reading.rows import NUMBER, RULES, SIZE, WHOLE
from packgen.reading.spheres import SphereFile, from_columns

KIND = "VTK file"
WANTED = {"radius": SIZE, "diameter": SIZE, "density": SIZE} | dict.fromkeys(
    ("id", "set", "type", "zone", "batch", "body"), WHOLE
)


def read_vtk(path: Path) -> SphereFile:
    """Read a file of points.

    Raises:
        ReadError: VTK cannot read it, or it has no points or no radii.
    """
    with path.open("rb"):  # VTK itself is silent about files that it cannot open
        points, arrays = _load(path)
    if not len(points):
        raise fault(path, "no points", "one a sphere", remedy="is the file complete?")
    columns = {axis: points[:, index] for index, axis in enumerate("xyz")}
    for name, values in arrays.items():
        plain = name.lower()
        if plain in WANTED and values.shape == (len(points),) and values.dtype.kind in "iuf":
            columns[plain] = values.astype(np.float64)
    if not {"radius", "diameter"} & set(columns):
        there = ", ".join(arrays) or "none"
        raise fault(path, f"the arrays {there} of its points", "radius or diameter as well")
    if "radius" in columns:
        columns.pop("diameter", None)
    faults = Faults(path)
    for name, values in columns.items():
        rule = WANTED.get(name, NUMBER)
        for index in np.flatnonzero(~RULES[rule](values)).tolist():
            faults.add(f"{name} {values[index]:g}", rule, place=f"point {index}")
    faults.check()
    return from_columns(path, KIND, columns)


def _load(path: Path) -> tuple[Float64Array, dict[str, Any]]:
    """Return points (N, 3) and their arrays by name."""
    from vtkmodules.util import numpy_support
    from vtkmodules.vtkCommonCore import vtkLogger, vtkOutputWindow, vtkStringOutputWindow

    to_numpy: Any = numpy_support.vtk_to_numpy
    said, window = vtkStringOutputWindow(), vtkOutputWindow.GetInstance()
    verbosity = vtkLogger.GetCurrentVerbosityCutoff()
    try:
        # VTK prints what is wrong and goes on with a part of the file: what it prints is an error here.
        vtkOutputWindow.SetInstance(said)
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
        reader = _reader(path.suffix.lower())
        reader.SetFileName(str(path))
        reader.Update()
        mesh = reader.GetOutput()
        if said.GetOutput().strip() or mesh is None or mesh.GetPoints() is None:
            raise ValueError
        points = np.array(to_numpy(mesh.GetPoints().GetData()), dtype=np.float64)
        data = mesh.GetPointData()
        arrays = [data.GetArray(index) for index in range(data.GetNumberOfArrays())]
        return points, {str(each.GetName()): to_numpy(each) for each in arrays if each is not None}
    except (ValueError, AttributeError) as error:
        raise fault(
            path, "what VTK cannot read as points", f"a whole file of the kind {path.suffix}",
            remedy="is it complete, and of the format that its ending says?",
        ) from error  # fmt: skip
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)
        vtkOutputWindow.SetInstance(window)


def _reader(suffix: str) -> Any:
    """Return VTK's reader of files with an ending."""
    if suffix == ".vtk":
        from vtkmodules.vtkIOLegacy import vtkDataSetReader

        reader = vtkDataSetReader()
        reader.ReadAllScalarsOn()
        reader.ReadAllFieldsOn()
        return reader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

    return vtkXMLPolyDataReader() if suffix == ".vtp" else vtkXMLUnstructuredGridReader()
