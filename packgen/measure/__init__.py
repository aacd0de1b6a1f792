"""What a bed is like: solid fraction, contacts, sizes."""

from packgen.measure.contacts import Contacts, contacts
from packgen.measure.core import Core, find_core
from packgen.measure.fraction import SolidFraction, against_gravity, solid_fraction, solid_volume
from packgen.measure.sizes import SizeCurve, Sizes, sizes

__all__ = [
    "Contacts",
    "Core",
    "SizeCurve",
    "Sizes",
    "SolidFraction",
    "against_gravity",
    "contacts",
    "find_core",
    "sizes",
    "solid_fraction",
    "solid_volume",
]
