"""The scene file: reading it, checking it, and what it says in SI units."""

from packgen.scene.document import COLLECTIVE_ARRANGEMENT
from packgen.scene.load import DEFAULT_MATERIAL, Scene, load_scene
from packgen.scene.models import (
    BoxSpec,
    ConeSpec,
    ContainerSpec,
    CylinderSpec,
    LocationSpec,
    MaterialSpec,
    Params,
    SliceSpec,
    SphereSpec,
    ValidationSpec,
    ZoneSpec,
)
from packgen.scene.sets import ParticleSetSpec, SetKeys

__all__ = [
    "COLLECTIVE_ARRANGEMENT", "DEFAULT_MATERIAL", "BoxSpec", "ConeSpec", "ContainerSpec", "CylinderSpec",
    "LocationSpec", "MaterialSpec", "Params", "ParticleSetSpec", "Scene", "SetKeys", "SliceSpec",
    "SphereSpec", "ValidationSpec", "ZoneSpec", "load_scene",
]  # fmt: skip
