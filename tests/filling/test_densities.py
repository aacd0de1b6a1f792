"""Claims on zones that say how dense they are: the volume that counts, and what cannot be."""

from __future__ import annotations

import math

import pytest

from packgen.errors import PackingError
from packgen.filling.densities import densities
from packgen.filling.fit import checked_locations
from packgen.filling.room import volume_inside, volume_of
from tests.scenes import box, constant, read_scene

CUBE = box([0] * 3, [1] * 3)
UPPER = {"slice": {"axis": "z", "min_bound": 0, "max_bound": 1}}


def asked_of(folder, container, zone, sets=None, **keys):
    """The density of a scene's only zone, and its volume of spheres."""
    sets = constant(0.05) if sets is None else sets
    scene, vessel = read_scene(folder, container, sets, algorithm="DISPERSED", zones=[zone], **keys)
    solved, found = densities(scene, vessel, checked_locations(scene, vessel))
    return found[0], solved.zones[0].volume


def refusal(folder, container, zone, sets=None, **keys):
    with pytest.raises(PackingError) as caught:
        asked_of(folder, container, zone, sets, **keys)
    return str(caught.value)


def test_the_volume_of_a_zone_is_that_within_all_walls(tmp_path):
    sphere = 4 / 3 * math.pi * 0.4**3
    cases = [
        (CUBE, None, 1.0, 0.0),
        ({"sphere": {"radius": 0.4}}, None, sphere, 1e-12),
        (
            {"sphere": {"radius": 0.4}},
            {"slice": {"axis": "z", "min_bound": 0, "max_bound": 1}},
            sphere / 2,
            1e-9,
        ),
        (CUBE, box([0.5] * 3, [2] * 3), 0.125, 1e-12),
        (CUBE, {"sphere": {"radius": 0.4, "center": [0.5] * 3}}, sphere, 3e-4),
        (CUBE, {"sphere": {"radius": 0.4, "center": [0, 0.5, 0.5]}}, sphere / 2, 3e-4),
    ]
    for container, location, volume, error in cases:
        zone = {"solid_fraction": 0.3} | ({} if location is None else {"location": location})
        density, solid = asked_of(tmp_path, container, zone)
        assert density.room == pytest.approx(volume, abs=error)
        assert solid == pytest.approx(0.3 * density.room)


def test_the_volume_away_from_walls_is_that_of_a_smaller_container(tmp_path):
    _, vessel = read_scene(tmp_path, CUBE, constant(0.05))
    assert volume_inside(vessel, 0.1) == pytest.approx(0.512, abs=2e-3)
    assert volume_of(vessel, ()) == 1.0


def test_a_core_is_denser_than_the_whole_but_where_there_are_no_walls(tmp_path):
    zone = {"solid_fraction": {"value": 0.4, "of": "core"}}
    density, _ = asked_of(tmp_path, CUBE, zone)
    # 6 m2 of walls lack spheres of 0.05 m in a layer of 0.6 / 1.8 radii.
    assert density.fraction == pytest.approx(0.4 * (1 - 2 * 0.05 / 3) ** 3, abs=1e-3)
    density, _ = asked_of(tmp_path, {**CUBE, "periodic": ["x", "y", "z"]}, zone)
    assert density.fraction == 0.4


def test_denser_than_random_packings_is_refused_with_the_possible_fraction(tmp_path):
    assert "zones[0].solid_fraction: found 0.7, expected at most 0.640" in refusal(
        tmp_path, CUBE, {"solid_fraction": 0.7}
    )
    assert "zones[0].porosity: found 0.3, expected at least 0.360" in refusal(
        tmp_path, CUBE, {"porosity": 0.3}
    )
    assert "zones[0].void_ratio: found 0.5, expected at least 0.562" in refusal(
        tmp_path, CUBE, {"void_ratio": 0.5}
    )
    line = refusal(tmp_path, CUBE, {"solid_fraction": 0.55, "gap": 0.2})
    assert "expected at most 0.481: random packings of such spheres that keep this gap" in line
    broad = {"solid_fraction": 0.7, "set_proportions": [0.7, 0.3], "proportions_by": "volume"}
    density, _ = asked_of(tmp_path, CUBE, broad, [constant(0.1), constant(0.01)])
    assert density.fraction == 0.7


def test_all_faults_of_all_zones_are_told_at_once(tmp_path):
    zones = [{"solid_fraction": 0.7}, {"porosity": 0.1}]
    scene, vessel = read_scene(tmp_path, CUBE, constant(0.05), algorithm="DISPERSED", zones=zones)
    with pytest.raises(PackingError) as caught:
        densities(scene, vessel, checked_locations(scene, vessel))
    assert len(str(caught.value).splitlines()) == 2


def test_less_than_a_sphere_and_more_than_a_file_has_are_refused(tmp_path):
    assert "room for one sphere of mean size" in refusal(
        tmp_path, CUBE, {"solid_fraction": 0.001}, constant(0.1)
    )
    (tmp_path / "radii.csv").write_text("radius\n" + "0.05\n" * 20)
    listed = {"radius_distribution": "file", "path": "radii.csv"}
    line = refusal(tmp_path, CUBE, {"solid_fraction": 0.1}, listed)
    assert "found 191 spheres to draw from a file of radii, expected at most 20; ask for 0.01047" in line


def test_a_part_of_a_container_has_no_core(tmp_path):
    zone = {"solid_fraction": {"value": 0.3, "of": "core"}, "location": box([0] * 3, [0.5] * 3)}
    assert "zones[0].solid_fraction.of: found core, expected filled" in refusal(tmp_path, CUBE, zone)
