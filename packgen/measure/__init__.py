"""What a bed is like: solid fraction, contacts, sizes."""

from packgen.measure.contacts import Contacts, Gaps, contacts, contacts_and_gaps
from packgen.measure.core import Core, find_core
from packgen.measure.fraction import SolidFraction, against_gravity, solid_fraction, solid_volume
from packgen.measure.profile import HeightProfile, height_profile
from packgen.measure.sizes import SizeCurve, Sizes, sizes

__all__ = [
    "Contacts",
    "Core",
    "Gaps",
    "HeightProfile",
    "SizeCurve",
    "Sizes",
    "SolidFraction",
    "against_gravity",
    "contacts",
    "contacts_and_gaps",
    "find_core",
    "height_profile",
    "sizes",
    "solid_fraction",
    "solid_volume",
]
