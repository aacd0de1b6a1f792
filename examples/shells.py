"""Make the surfaces of the examples: ``python examples/shells.py`` writes the STL files beside itself.

Binary STL holds single precision: corners are rounded to it before the normals are computed.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

# Height and radius [m] of a Midrex-type shaft furnace, the one that the paper packs.
FURNACE = ((0.0, 1.2), (7.0, 3.25), (26.0, 3.25), (32.0, 1.0))
# The paper does not give the cone of its Fig. 9. In this one the 200 small spheres of the first zone reach up
# to about 0.77 m, so that the 300 large ones of the second, between 0.8 and 1.5 m, rest on them.
CONE = ((0.0, 0.02), (1.8, 0.812))
SPHERE_HEIGHT, SPHERE_RADIUS = 0.5, 0.55
# A standard stirred tank [m]: four baffles a tenth of its diameter wide.
TANK_RADIUS, TANK_HEIGHT, BAFFLES, BAFFLE_WIDTH, BAFFLE_GAP = 0.5, 1.0, 4, 0.1, 0.05
# A silo with a flat floor [m], whose outlet is a surface of its own.
SILO_RADIUS, SILO_HEIGHT, OUTLET_RADIUS = 0.15, 0.5, 0.05
# A gate across a tank [m]: at x, as wide and high as the tank.
GATE_PLACE, GATE_WIDTH, GATE_HEIGHT = 0.1, 0.1, 0.25
# Corners of a mixer's blade [m].
BLADE = np.array([[-0.08, -0.01, 0.03], [0.08, 0.01, 0.07]])


def revolved(
    profile: tuple[tuple[float, float], ...], facets: int, *, bottom: bool = True, top: bool = True
) -> np.ndarray:
    """Return a surface of revolution about z, closed but for the ends that it has not.

    Args:
        profile: Height and radius [m] from the bottom to the top; a radius of 0 is a tip.
        facets: Number of facets round the axis.
        bottom: Whether it has its lower end.
        top: Whether it has its upper end.

    Returns:
        Triangles [m], counter-clockwise from outside, shape (F, 3, 3), float64.
    """
    angle = 2.0 * np.pi * np.arange(facets) / facets
    rings = [np.stack([r * np.cos(angle), r * np.sin(angle), np.full(facets, z)], axis=1) for z, r in profile]
    triangles = []
    for lower, upper in pairwise(rings):
        after_lower, after_upper = np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0)
        triangles.append(np.stack([lower, after_lower, after_upper], axis=1))
        triangles.append(np.stack([lower, after_upper, upper], axis=1))
    if bottom:
        triangles.append(disc(profile[0][0], profile[0][1], facets))
    if top:
        triangles.append(disc(profile[-1][0], profile[-1][1], facets)[:, [0, 2, 1]])
    return without_degenerate(np.concatenate(triangles))


def disc(height: float, radius: float, facets: int) -> np.ndarray:
    """Return a disc across z that is seen from below, triangles [m], shape (F, 3, 3), float64."""
    angle = 2.0 * np.pi * np.arange(facets) / facets
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(facets, height)], axis=1)
    middle = np.broadcast_to([0.0, 0.0, height], rim.shape)
    return np.stack([middle, np.roll(rim, -1, axis=0), rim], axis=1)


def without_degenerate(triangles: np.ndarray) -> np.ndarray:
    """Return the triangles that have an area: a tip leaves some that have none."""
    edge = triangles[:, 1:] - triangles[:, :1]
    area = np.linalg.norm(np.cross(edge[:, 0], edge[:, 1]), axis=1)
    return triangles[area > 1e-12 * area.max()]


def write_stl(path: Path, triangles: np.ndarray) -> None:
    """Write binary STL: 80 bytes of header, the number of facets, then 50 bytes a facet."""
    corners = triangles.astype("<f4")
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    facets = np.zeros(
        len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    )
    facets["normal"] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    facets["corners"] = corners
    # The header must not begin with "solid", by which readers know the text form.
    header = f"packgen example {path.stem}, metres".encode().ljust(80)
    path.write_bytes(header + np.uint32(len(facets)).tobytes() + facets.tobytes())


def tank() -> np.ndarray:
    """Return a tank without its stirrer: a cylinder with baffles, sheets of no thickness at its wall."""
    shell = revolved(((0.0, TANK_RADIUS), (TANK_HEIGHT, TANK_RADIUS)), 96)
    angle = 2.0 * np.pi * np.arange(BAFFLES) / BAFFLES
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(BAFFLES)], axis=1)
    low, high = np.array([0.0, 0.0, BAFFLE_GAP]), np.array([0.0, 0.0, TANK_HEIGHT - BAFFLE_GAP])
    # A corner of the 96-gon lies behind each baffle: it reaches the wall.
    outer, inner = TANK_RADIUS * outward, (TANK_RADIUS - BAFFLE_WIDTH) * outward
    halves = [(outer + low, inner + low, inner + high), (outer + low, inner + high, outer + high)]
    return np.concatenate([shell, *(np.stack(half, axis=1) for half in halves)])


def gate() -> np.ndarray:
    """Return a gate across a tank, a sheet of no thickness."""
    corners = ((0.0, 0.0), (GATE_WIDTH, 0.0), (GATE_WIDTH, GATE_HEIGHT), (0.0, GATE_HEIGHT))
    points = np.array([(GATE_PLACE, y, z) for y, z in corners])
    return points[np.array([[0, 1, 2], [0, 2, 3]])]


def block(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return a closed block between two corners [m], triangles of shape (12, 3, 3), float64."""
    ring = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corners = low + np.concatenate([ring, ring + np.array([0, 0, 1])]) * (high - low)
    quads = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return corners[np.array([each for a, b, c, d in quads for each in ((a, b, c), (a, c, d))])]


def main() -> None:
    """Write all surfaces."""
    folder = Path(__file__).parent
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 25)
    ball = tuple(
        (SPHERE_HEIGHT + SPHERE_RADIUS * np.sin(each), max(SPHERE_RADIUS * np.cos(each), 0.0))
        for each in latitude
    )
    write_stl(folder / "furnace.stl", revolved(FURNACE, 96))
    write_stl(folder / "cone.stl", revolved(CONE, 96))
    write_stl(folder / "sphere.stl", revolved(ball, 48))
    write_stl(folder / "tank.stl", tank())
    silo = ((0.0, OUTLET_RADIUS), (0.0, SILO_RADIUS), (SILO_HEIGHT, SILO_RADIUS))
    write_stl(folder / "silo.stl", revolved(silo, 48, bottom=False, top=False))
    write_stl(folder / "outlet.stl", disc(0.0, OUTLET_RADIUS, 48))
    write_stl(folder / "gate.stl", gate())
    write_stl(folder / "blade.stl", block(*BLADE))


if __name__ == "__main__":
    main()
