"""What an algorithm says of itself."""

from __future__ import annotations

from dataclasses import fields
from typing import ClassVar

import pytest

from packgen.arrange.collective.params import Params as Collective
from packgen.arrange.jammed.params import Params as Jammed
from packgen.arrange.registry import BUILTIN, find
from packgen.arrange.traits import UNSAID, Traits, traits_of
from packgen.geometry import Container
from tests.beds import box_container

NAMES = {each.name for each in fields(Traits)}


@pytest.mark.parametrize("name", BUILTIN)
def test_all_that_a_built_in_algorithm_declares_is_a_trait(name):
    model = find(name).params
    declared = {
        attribute
        for each in model.__mro__
        if each.__module__.startswith("packgen.arrange.")
        for attribute in vars(each)
        if not attribute.startswith("_") and attribute not in model.model_fields
    }
    assert {each for each in declared - NAMES if not each.startswith("model_")} == set()
    assert traits_of(model()).may_change != UNSAID


def test_what_hangs_on_settings_is_said_by_an_instance_alone():
    assert traits_of(Jammed).may_change == UNSAID
    assert traits_of(Jammed(adjust="count")).may_change == "count"
    assert not traits_of(Jammed).fits_container
    assert traits_of(Jammed()).fits_container
    assert traits_of(Collective(optimizer="adam")).instead == "ADAM"
    assert traits_of(Collective).instead is None


def test_settings_that_say_nothing_have_the_traits_of_every_algorithm():
    assert traits_of({"spacing": 0.05}) == traits_of(None) == Traits()


class Own:
    zone_keys: ClassVar[frozenset[str]] = frozenset({"gap"})
    spacing = 0.05

    def unsupported(self, container: Container) -> list[tuple[str, str]]:
        return [("container.box", f"found {container.name}, expected a sphere")]


def test_a_plug_ins_settings_need_no_base_class():
    found = traits_of(Own())
    assert found.zone_keys == {"gap"}
    assert found.unsupported is not None
    [(path, said)] = found.unsupported(box_container((0, 0, 0), (1, 1, 1)))
    assert path == "container.box"
    assert said.endswith("expected a sphere")
