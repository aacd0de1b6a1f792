"""The scene file: reading it, checking it, and what it says in SI units."""

from packgen.scene.load import DEFAULT_MATERIAL, Scene, load_scene
from packgen.scene.models import (
    BoxSpec,
    ConeSpec,
    ContainerSpec,
    CylinderSpec,
    LocationSpec,
    MaterialSpec,
    SliceSpec,
    SphereSpec,
    StartSpec,
    ValidationSpec,
    ZoneSpec,
)
from packgen.scene.sets import ParticleSetSpec, SetKeys

__all__ = [
    "DEFAULT_MATERIAL", "BoxSpec", "ConeSpec", "ContainerSpec", "CylinderSpec",
    "LocationSpec", "MaterialSpec", "ParticleSetSpec", "Scene", "SetKeys", "SliceSpec",
    "SphereSpec", "StartSpec", "ValidationSpec", "ZoneSpec", "load_scene",
]  # fmt: skip
