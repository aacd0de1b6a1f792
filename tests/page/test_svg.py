from __future__ import annotations

from xml.etree import ElementTree

import pytest

from packgen.page import svg


@pytest.mark.parametrize("values", [[0.0, 1.0], [0.52, 0.61], [3.0], [0.0], [-1e-9, 7e-9], [1e6, 2.3e6]])
def test_ticks_enclose_the_values_and_are_few(values):
    low, high, marks = svg.ticks(values)
    assert low <= min(values) + 1e-12
    assert high >= max(values) - 1e-12
    assert 3 <= len(marks) <= 9


def test_the_ends_of_a_curve_lie_in_the_frame():
    text = svg.curves("a < b", "x", "y", [svg.Series("", [0.0, 10.0], [5.0, 7.0])])
    line = next(each for each in ElementTree.fromstring(text).iter() if each.tag == "polyline")
    points = [tuple(map(float, pair.split(","))) for pair in line.attrib["points"].split()]
    assert points[0] == (svg.LEFT, svg.HEIGHT - svg.BOTTOM)
    assert points[1] == (svg.WIDTH - svg.RIGHT, svg.TOP)


def test_bars_are_as_tall_as_their_values():
    root = ElementTree.fromstring(svg.bars("t", "x", "y", ["a", "b"], [1.0, 3.0]))
    tall = [float(each.attrib["height"]) for each in root.iter() if each.tag == "rect"]
    assert tall[1] == pytest.approx(3.0 * tall[0], abs=0.2)


def test_names_of_lying_bars_have_room_and_bars_stay_in_the_frame():
    names = ["a", "liggghts, displacement"]
    root = ElementTree.fromstring(svg.lying_bars("t", names, [1.0, 4.0], "r"))
    ends = [float(each.attrib["x"]) for each in root.iter() if each.attrib.get("text-anchor") == "end"]
    assert min(ends) >= svg.LETTER * len(names[1])
    for bar in (each for each in root.iter() if each.tag == "rect"):
        assert float(bar.attrib["x"]) + float(bar.attrib["width"]) <= svg.WIDTH - 60.0
