"""phasicFlow's files, read back by a reader written from its README and source."""

from __future__ import annotations

import re

import numpy as np
import pytest

from exporters import phasicflow
from packgen.errors import ExportError
from tests.beds import box_container, make_bed
from tests.exporters.test_vtk import mixed_bed


def read_case(folder):
    """Return positions, radii and materials of the spheres, in the order of the file."""
    position = np.loadtxt(folder / "positions", ndmin=2)
    shapes = (folder / "caseSetup" / "shapes").read_text()
    names, diameters, materials = (
        re.search(rf"^{key}\s+\(([^)]*)\);", shapes, re.MULTILINE)[1].split()
        for key in ("names", "diameters", "materials")
    )
    settings = (folder / "settings" / "particlesDict").read_text()
    assert "method file;" in settings
    assert "name positions;" in settings
    assert "mortonSorting No;" in settings
    assert settings.count("{") == settings.count("}")
    of = np.full(len(position), -1)
    for name, begin, end in re.findall(
        r"(\w+)\s*\{\s*selector stridedRange;\s*stridedRangeInfo \{begin (\d+); end (\d+); stride 1;\}",
        settings,
    ):
        of[int(begin) : int(end)] = names.index(name)
    assert (of >= 0).all()
    return position, np.array(diameters, dtype=float)[of] / 2, np.array(materials)[of]


def two_sizes(count=60):
    rng = np.random.default_rng(2)
    bed = mixed_bed(count)
    return make_bed(
        bed.position, rng.choice([0.1, 0.25], count), bed.container, set_index=bed.set_index,
        particle_sets=bed.particle_sets, materials=bed.materials,
    )  # fmt: skip


def test_an_independent_reader_gets_spheres_sizes_and_materials_back(tmp_path):
    bed = two_sizes()
    phasicflow.write(bed, tmp_path, phasicflow.Options())
    position, radius, material = read_case(tmp_path)
    order = np.lexsort(bed.position.T)
    again = np.lexsort(position.T)
    assert np.array_equal(position[again], bed.position[order])
    assert np.array_equal(radius[again], bed.radius[order])
    assert np.array_equal(material[again], np.array(["coke", "ore"])[bed.set_index[order]])


def test_very_many_radii_are_refused_with_the_remedy(tmp_path):
    bed = mixed_bed(30)
    with pytest.raises(
        ExportError, match=r"30 different radii, expected at most 10: .* phasicflow.shapes_max"
    ):
        phasicflow.write(bed, tmp_path, phasicflow.Options(shapes_max="10"))
    assert list(tmp_path.iterdir()) == []
    phasicflow.write(bed, tmp_path, phasicflow.Options())
    assert np.array_equal(np.sort(read_case(tmp_path)[1]), np.sort(bed.radius))


def test_one_sphere_is_a_case(tmp_path):
    bed = make_bed([[1, 1, 1]], 0.5, box_container((0, 0, 0), (2, 2, 2)))
    phasicflow.write(bed, tmp_path, phasicflow.Options())
    position, radius, _ = read_case(tmp_path)
    assert (position.tolist(), radius.tolist()) == ([[1, 1, 1]], [0.5])
