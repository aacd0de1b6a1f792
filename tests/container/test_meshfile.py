"""Mesh files that are not what they claim: one line, whatever the library that reads them does."""

from __future__ import annotations

import pytest

from packgen.container.meshfile import read_surface
from packgen.errors import GeometryError

CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"
)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("lost.obj", CORNERS + "f 1 2 3\nf 2 3 9\n", "cannot be read as a mesh"),
        ("lost.ply", PLY, "facets with corners that it lacks, of 3 corners"),
        ("nan.obj", CORNERS.replace("1 0 0", "1 0 nan") + "f 1 2 3\n", "1 corners that are not finite"),
        ("none.obj", CORNERS, "holds no triangles"),
        ("words.off", "OFF\n3 1 0\n0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", "cannot be read as a mesh"),
    ],
)
def test_a_mesh_that_lacks_something_is_told_in_a_line(tmp_path, name, content, words):
    (tmp_path / name).write_text(content)
    with pytest.raises(GeometryError, match=rf"^here: {name.split('.')[0]}.*{words}") as caught:
        read_surface(tmp_path / name, 1.0, "here")
    assert "\n" not in str(caught.value)
