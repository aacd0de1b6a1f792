"""Periodic cells of any shape: three vectors from the origin, whose lattice repeats the spheres.

A cell of a container lies as LAMMPS has it: the first vector along x, the second one in the plane of x and y.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.geometry.shapes import Container, Polyhedron, Surface
from packgen.portable import inverse, length, matrix_product

CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
ROUNDING = 1.0e-12
"""Share of a vector that is rounding."""

QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def cell_container(vectors: Float64Array, name: str = "cell") -> Container:
    """Return the container that a cell is: it repeats along its vectors and has no walls.

    Args:
        vectors: Its vectors as rows [m], lower triangular, positive along the diagonal, shape (3, 3).
        name: What messages and decks call it.
    """
    vertices = matrix_product(CORNERS, vectors)
    faces = [triangle for a, b, c, d in QUADS for triangle in ((a, b, c), (a, c, d))]
    normal = np.array([np.cross(vectors[(k + 1) % 3], vectors[(k + 2) % 3]) for k in range(3)])
    normal /= np.sqrt((normal * normal).sum(axis=1))[:, None]
    offset = np.concatenate([(normal * vectors).sum(axis=1), np.zeros(3)])
    surface = Surface(vertices, np.array(faces))
    return Container(
        name,
        Polyhedron(np.concatenate([normal, -normal]), offset, surface),
        surface,
        np.stack([vertices.min(axis=0), vertices.max(axis=0)]),
        float(np.prod(np.diag(vectors))),
        (True, True, True),
        cell=vectors,
    )


def upright_cell(vectors: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return a cell turned so that it is lower triangular and hardly tilted, and the turn.

    Args:
        vectors: Vectors of a cell as rows [m], shape (3, 3).

    Returns:
        Vectors of the same lattice, turned [m], shape (3, 3); the matrix that turns rows, shape (3, 3).
    """
    vectors = np.array(vectors)
    if (np.cross(vectors[0], vectors[1]) * vectors[2]).sum() < 0.0:
        vectors[2] *= -1.0  # the lattice is the same
    x = vectors[0] / length(vectors[0])
    y = vectors[1] - (vectors[1] * x).sum() * x
    y /= length(y)
    turn = np.stack([x, y, np.cross(x, y)], axis=1)
    upright = np.tril(matrix_product(vectors, turn))
    for row, along in ((1, 0), (2, 1), (2, 0)):
        upright[row] -= np.round(upright[row, along] / upright[along, along]) * upright[along]
    return upright, turn


def into_cell(position: Float64Array, vectors: Float64Array) -> Float64Array:
    """Return positions [m] moved by whole vectors into a cell, shape (N, 3)."""
    place = matrix_product(position, inverse(vectors))
    # What is inside but for rounding keeps its digits.
    steps = np.floor(place + ROUNDING)
    return np.asarray(
        np.where(
            (steps != 0.0).any(axis=1, keepdims=True), position - matrix_product(steps, vectors), position
        )
    )


def cell_images(
    position: Float64Array, vectors: Float64Array, reach: Float64Array | float
) -> tuple[Float64Array, Int64Array, Int64Array]:
    """Return the images of spheres that come within a distance of their cell, those in it left out.

    Args:
        position: Centres in the cell [m], shape (N, 3).
        vectors: Vectors of the cell as rows [m], shape (3, 3).
        reach: The distance from the cell's faces [m], one or one a sphere, shape (N,).

    Returns:
        Centres [m], shape (M, 3); the sphere that each is an image of, shape (M,); its place in whole
        vectors, shape (M, 3).
    """
    back = inverse(vectors)
    place = matrix_product(position, back)
    spacing = 1.0 / np.sqrt((back * back).sum(axis=0))
    share = np.broadcast_to(np.asarray(reach, float), (len(position),))[:, None] / spacing
    most = np.ceil(share.max(axis=0, initial=0.0) + 1.0).astype(int)
    found = []
    for shift in product(*[range(-each, each + 1) for each in most.tolist()]):
        if shift == (0, 0, 0):
            continue
        moved = place + np.array(shift)
        near = np.flatnonzero(((moved >= -share) & (moved <= 1.0 + share)).all(axis=1))
        if len(near):
            found.append((near, np.broadcast_to(np.array(shift), (len(near), 3))))
    if not found:
        return np.empty((0, 3)), np.empty(0, np.int64), np.empty((0, 3), np.int64)
    owner, steps = (np.concatenate(each) for each in zip(*found, strict=True))
    return position[owner] + matrix_product(steps, vectors), owner, steps
