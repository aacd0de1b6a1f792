"""Groups of facets of meshes that meshio reads: parts by name, on the boundary and within."""

from __future__ import annotations

from itertools import permutations, product

import meshio
import numpy as np
import pytest

from packgen.errors import GeometryError
from tests.scenes import constant, read_scene

SIDE = 3  # points a side of the cube 2 m wide; its cells are cubes of 1 m
CORNERS = np.array(list(product(range(SIDE), repeat=3)), float)
CUBE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
OUTLET, SHELL, GATE = "outlet", "shell", "gate"
TAGS = {OUTLET: 7, SHELL: 8, GATE: 9}


def node(point):
    x, y, z = point
    return (x * SIDE + y) * SIDE + z


def cells(shape):
    """The cells of the cube: eight cubes, or six tetrahedra in each, along its diagonal."""
    found = []
    for low in product(range(SIDE - 1), repeat=3):
        if shape == "hexahedron":
            found.append([node(np.add(low, corner)) for corner in CUBE])
            continue
        for order in permutations(range(3)):
            path = [np.array(low)]
            for axis in order:
                path.append(path[-1] + np.eye(3, dtype=int)[axis])
            found.append([node(each) for each in path])
    return np.array(found)


def facets(shape):
    """The facets of the cube's cells on its boundary and on its middle plane, with the group of each."""
    corners = {"hexahedron": 4, "tetra": 3}[shape]
    faces = {}
    for cell in cells(shape).tolist():
        sides = meshio_faces(cell, shape)
        for side in sides:
            points = CORNERS[list(side)]
            assert len(side) == corners
            if (points[:, 0] == 1.0).all():
                faces[tuple(sorted(side))] = (side, GATE)
            elif (points[:, 2] == 0.0).all() and points[:, :2].max() <= 1.0:
                faces[tuple(sorted(side))] = (side, OUTLET)
            elif any((points[:, axis] == end).all() for axis in range(3) for end in (0.0, 2.0)):
                faces[tuple(sorted(side))] = (side, SHELL)
    return np.array([side for side, _ in faces.values()]), [group for _, group in faces.values()]


def meshio_faces(cell, shape):
    if shape == "tetra":
        return [[cell[k] for k in range(4) if k != left] for left in range(4)]
    return [[cell[k] for k in face] for face in ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5),
                                                 (2, 3, 7, 6), (3, 0, 4, 7))]  # fmt: skip


def gmsh_text(shape="tetra", names=TAGS):
    """The cube as gmsh's text of version 2.2, which most programs write."""
    sides, groups = facets(shape)
    kinds = {"tetra": (2, 4), "hexahedron": (3, 5)}[shape]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
    lines += [f'2 {tag} "{name}"' for name, tag in names.items()]
    lines += ['3 1 "room"', "$EndPhysicalNames", "$Nodes", str(len(CORNERS))]
    lines += [f"{k} {x:g} {y:g} {z:g}" for k, (x, y, z) in enumerate(CORNERS, 1)]
    lines += ["$EndNodes", "$Elements", str(len(sides) + len(cells(shape)))]
    rows = [(kinds[0], TAGS[group], side) for side, group in zip(sides.tolist(), groups, strict=True)]
    rows += [(kinds[1], 1, cell) for cell in cells(shape).tolist()]
    for number, (kind, tag, corners) in enumerate(rows, 1):
        lines.append(f"{number} {kind} 2 {tag} {tag} {' '.join(str(each + 1) for each in corners)}")
    return "\n".join([*lines, "$EndElements", ""])


def gmsh_text_4():
    """The cube as gmsh's text of version 4.1, its default: groups belong to entities, some to two."""
    sides, groups = facets("tetra")
    groups = np.array(groups)
    bounds = "0 0 0 2 2 2"
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", "3"]
    lines += [f'2 7 "{OUTLET}"', '2 8 "every_wall"', '3 1 "room"']
    lines += ["$EndPhysicalNames", "$Entities", "0 0 3 1"]
    tags = {OUTLET: "2 7 8", SHELL: "1 8", GATE: "1 9"}
    lines += [f"{TAGS[name]} {bounds} {tags[name]} 0" for name in (OUTLET, SHELL, GATE)]
    lines += [f"1 {bounds} 1 1 0", "$EndEntities", "$Nodes", f"1 {SIDE**3} 1 {SIDE**3}", f"3 1 0 {SIDE**3}"]
    lines += [str(k + 1) for k in range(SIDE**3)] + [f"{x:g} {y:g} {z:g}" for x, y, z in CORNERS]
    count = len(sides) + len(cells("tetra"))
    lines += ["$EndNodes", "$Elements", f"4 {count} 1 {count}"]
    number = 1
    blocks = [(2, TAGS[name], 2, sides[groups == name]) for name in (OUTLET, SHELL, GATE)]
    for dim, entity, kind, rows in [*blocks, (3, 1, 4, cells("tetra"))]:
        lines.append(f"{dim} {entity} {kind} {len(rows)}")
        for row in (rows + 1).tolist():
            lines.append(f"{number} {' '.join(map(str, row))}")
            number += 1
    return "\n".join([*lines, "$EndElements", ""])


def mesh_of(shape="tetra"):
    """The cube as meshio has it, its groups as an array of numbers."""
    sides, groups = facets(shape)
    kind = {"tetra": "triangle", "hexahedron": "quad"}[shape]
    numbers = [np.array([TAGS[each] for each in groups]), np.ones(len(cells(shape)), int)]
    return meshio.Mesh(CORNERS, [(kind, sides), (shape, cells(shape))], cell_data={"CellEntityIds": numbers})


def container_of(tmp_path, name, walls):
    return read_scene(tmp_path, {"path": name}, constant(0.05), walls=walls)[1]


def corners_of(container, name):
    (part,) = (each for each in container.parts if each.name == name)
    return container.surface.vertices[container.surface.faces[part.faces]]


@pytest.mark.parametrize("shape", ["tetra", "hexahedron"])
def test_a_named_patch_of_a_volume_mesh_is_a_part(tmp_path, shape):
    (tmp_path / "room.msh").write_text(gmsh_text(shape))
    walls = [{"name": OUTLET, "remove": True, "material": "default"}]
    container = container_of(tmp_path, "room.msh", walls)
    assert container.volume == pytest.approx(8.0)
    corners = corners_of(container, OUTLET)
    assert (corners[:, :, 2] == 0.0).all()
    assert corners[:, :, :2].min() == 0.0
    assert corners[:, :, :2].max() == 1.0
    assert container.parts[0].remove
    assert len(container.surface.faces) == 6 * 8
    assert np.count_nonzero(container.part_index == 0) == 2


def test_a_patch_within_a_volume_mesh_is_a_sheet_where_it_is_a_part(tmp_path):
    (tmp_path / "room.msh").write_text(gmsh_text())
    without = container_of(tmp_path, "room.msh", [{"name": OUTLET}])
    assert len(without.surface.faces) == 6 * 8
    container = container_of(tmp_path, "room.msh", [{"name": GATE}, {"name": OUTLET}])
    assert (corners_of(container, GATE)[:, :, 0] == 1.0).all()
    assert np.count_nonzero(container.part_index == 0) == 8
    assert container.volume == pytest.approx(8.0)


def test_a_surface_of_two_physical_groups_is_the_part_that_walls_name(tmp_path):
    (tmp_path / "room.msh").write_text(gmsh_text_4())
    container = container_of(tmp_path, "room.msh", [{"name": OUTLET}])
    assert len(container.surface.faces) == 6 * 8
    assert len(corners_of(container, OUTLET)) == 2
    both = r"2 facets are of outlet and of every_wall, expected each facet in one"
    with pytest.raises(GeometryError, match=both):
        container_of(tmp_path, "room.msh", [{"name": OUTLET}, {"name": "every_wall"}])


@pytest.mark.parametrize("ending", ["vtu", "vtk", "inp"])
def test_patches_are_told_apart_by_numbers_or_by_sets(tmp_path, ending):
    mesh, name = mesh_of(), "7"
    if ending == "inp":
        name = OUTLET
        numbers = mesh.cell_data.pop("CellEntityIds")[0]
        mesh.cell_sets = {OUTLET: [np.flatnonzero(numbers == TAGS[OUTLET]), np.array([], int)]}
    meshio.write(tmp_path / f"room.{ending}", mesh)
    container = container_of(tmp_path, f"room.{ending}", [{"name": name}])
    corners = corners_of(container, name)
    assert corners[:, :, 2].max() == 0.0
    assert corners[:, :, :2].max() == 1.0
    assert len(container.surface.faces) == 6 * 8


def test_groups_of_a_surface_mesh_are_parts_as_well(tmp_path):
    mesh = mesh_of()
    flat = meshio.Mesh(CORNERS, mesh.cells[:1], cell_data={"patch": mesh.cell_data["CellEntityIds"][:1]})
    meshio.write(tmp_path / "skin.vtu", flat)
    container = container_of(tmp_path, "skin.vtu", [{"name": "9"}, {"name": "7"}])
    assert (corners_of(container, "9")[:, :, 0] == 1.0).all()
    assert container.volume == pytest.approx(8.0)


def test_a_patch_that_is_not_there_and_a_mesh_without_patches_are_told(tmp_path):
    (tmp_path / "room.msh").write_text(gmsh_text())
    told = r"\(outlte\): found no surface of that name, expected one of the container's file: outlet, "
    with pytest.raises(GeometryError, match=told):
        container_of(tmp_path, "room.msh", [{"name": "outlte"}])
    mesh = mesh_of()
    mesh.cell_data = {}
    meshio.write(tmp_path / "plain.vtu", mesh)
    with pytest.raises(GeometryError, match=r"plain\.vtu has no groups of facets by name, expected physical"):
        container_of(tmp_path, "plain.vtu", [{"name": OUTLET}])
