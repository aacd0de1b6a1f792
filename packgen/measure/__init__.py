"""What a bed is like: solid fraction, profiles, pair correlation, contacts, order, sizes, forces at rest.

All lengths are in metres, arrays float64. Every measure is a function of a `packgen.bed.Bed`::

    core = core_of(bed)
    pair_correlation(bed, core).g
    slab_fraction(bed, [0, 0, 1], 0.2, 0.4)
"""

from packgen.measure.close_packing import ClosePacking, close_packing
from packgen.measure.contacts import Contacts, Gaps, contacts, contacts_and_gaps
from packgen.measure.core import Core, find_core
from packgen.measure.correlation import PairCorrelation, pair_correlation
from packgen.measure.cylinders import volume_in_cylinder, volume_in_cylinder_between
from packgen.measure.fraction import (
    SolidFraction,
    against_gravity,
    core_of,
    solid_fraction,
    solid_fraction_with,
    solid_volume,
)
from packgen.measure.order import LocalOrder, crystal_bonds, local_order
from packgen.measure.profile import HeightProfile, height_profile
from packgen.measure.radial import RadialProfile, de_klerk_porosity, mueller_porosity, radial_profile
from packgen.measure.regions import box_fraction, container_fraction, shell_fraction, slab_fraction
from packgen.measure.roundness import RoundPart, round_part
from packgen.measure.sizes import SizeCurve, Sizes, sizes
from packgen.measure.standing import Standing, standing
from packgen.measure.volumes import mean_diameter

__all__ = [
    "ClosePacking",
    "Contacts",
    "Core",
    "Gaps",
    "HeightProfile",
    "LocalOrder",
    "PairCorrelation",
    "RadialProfile",
    "RoundPart",
    "SizeCurve",
    "Sizes",
    "SolidFraction",
    "Standing",
    "against_gravity",
    "box_fraction",
    "close_packing",
    "contacts",
    "contacts_and_gaps",
    "container_fraction",
    "core_of",
    "crystal_bonds",
    "de_klerk_porosity",
    "find_core",
    "height_profile",
    "local_order",
    "mean_diameter",
    "mueller_porosity",
    "pair_correlation",
    "radial_profile",
    "round_part",
    "shell_fraction",
    "sizes",
    "slab_fraction",
    "solid_fraction",
    "solid_fraction_with",
    "solid_volume",
    "standing",
    "volume_in_cylinder",
    "volume_in_cylinder_between",
]
