"""A scene file as a whole, before names, materials and proportions are filled in."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model, model_validator

from packgen.arrange.registry import DEFAULT
from packgen.scene.models import ContainerSpec, MaterialSpec, StartFrom, ValidationSpec, ZoneSpec
from packgen.scene.sets import ParticleSetSpec
from packgen.scene.walls import WallSpec
from packgen.values import Acceleration, Direction, Flag, Keys, Name, Seed, Tolerance, Unit3

__all__ = ["FreeParams", "SceneFile", "scene_file"]

_DOWN: Unit3 = (0.0, 0.0, -1.0)


def _not_empty(values: tuple[Any, ...]) -> tuple[Any, ...]:
    # pydantic's own min_length counts only the items that are valid, and would fault the list as well.
    if not values:
        raise ValueError("a list of at least one")
    return values


class SceneFile(Keys):
    """The keys of a scene file.

    Attributes:
        container: What holds the spheres.
        gravity_axis: Where things fall; once read, the unit vector along which they do.
        gravity: Acceleration of gravity; DISPERSED, JAMMED and VOID_FILLING have none.
        seed: Seed of everything random.
        algorithm: Name of the algorithm, packgen's own or a plug-in's.
        params: Settings of the algorithm; each has its own.
        start_from: A bed that is there before the zones are filled: a file of spheres, or a result folder.
        particle_sets: The kinds of spheres.
        materials: Materials for the solver decks, by name.
        allow_soft: ``allow_soft`` of every material.
        wall_material: Name of the walls' material; None: that of the first set.
        walls: Named parts of the walls, beside the container; decks have a wall for each.
        zones: What to fill, in this order; left out: the whole container until it is full.
        validation: Limits of a solver's verdict.
    """

    container: ContainerSpec
    gravity_axis: Direction = _DOWN
    gravity: Acceleration = 9.81
    seed: Seed = 0
    algorithm: Name = DEFAULT
    params: Any = None
    start_from: StartFrom | None = None
    particle_sets: Annotated[tuple[ParticleSetSpec, ...], AfterValidator(_not_empty)]
    materials: dict[Name, MaterialSpec] = Field(default_factory=dict)
    allow_soft: Flag = False
    wall_material: Name | None = None
    walls: tuple[WallSpec, ...] = ()
    zones: Annotated[tuple[ZoneSpec, ...], AfterValidator(_not_empty)] = (ZoneSpec(),)
    validation: ValidationSpec = ValidationSpec()

    @model_validator(mode="before")
    @classmethod
    def _empty_sections_are_absent(cls, data: Any) -> Any:
        """Drop keys without a value: a section whose lines are all commented out."""
        if not isinstance(data, dict):
            return data
        optional = {name for name, each in cls.model_fields.items() if not each.is_required()}
        return {key: value for key, value in data.items() if value is not None or key not in optional}


class FreeParams(Keys):
    """Settings of an algorithm that has no model of them: any keys.

    Attributes:
        tolerance: Largest overlap, as a fraction of the smaller radius; None: as the algorithm left it.
    """

    model_config = ConfigDict(extra="allow")

    tolerance: Tolerance | None = 1.0e-6


@cache
def scene_file(params: type[BaseModel]) -> type[SceneFile]:
    """Return the model of scene files whose algorithm has these settings; it refuses unknown ones."""
    if params.model_config.get("extra") is None:
        params = type(params.__name__, (params,), {"model_config": ConfigDict(extra="forbid")})
    return create_model("SceneFile", __base__=SceneFile, __doc__=SceneFile.__doc__, params=(params, ...))
