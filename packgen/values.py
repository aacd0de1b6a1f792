"""The kinds of values a scene file holds: each turns what the YAML says into SI, or says what it expected.

The validators raise ``ValueError`` with the expectation alone; ``packgen.scene.faults`` adds the place and
the value found.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetJsonSchemaHandler,
    TypeAdapter,
    ValidationInfo,
    WithJsonSchema,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import PydanticCustomError

from packgen.units import UNITS, to_si

__all__ = [
    "Acceleration", "AxisIndex", "BedPath", "Count", "Density", "Direction", "FileOrCount", "FilePath",
    "Flag", "Fraction", "Fractions", "Frequency", "InnerFraction", "Keys", "Length", "LengthUnit",
    "Lengths", "Mass", "Name", "NonNegative", "NonNegativeLength", "Period", "Periodic", "Point",
    "PoissonsRatio", "Positive", "PositiveLength", "Pressure", "PrimitiveAxis", "Seed", "SolidVolume",
    "Tolerance", "Turning", "Unit3", "Velocity", "Where", "WholeNumber", "fault", "number", "plainly",
]  # fmt: skip

ABOVE_ZERO = "greater than 0"
NAME_RULE = "a name of at most 64 letters (A-Z, a-z), digits, _ - or ., with a letter, digit or _ first"
MEMBERS_MAX = 1000  # spheres of one particle
TILT_MIN = 1.0e-6  # component of a direction of gravity over the largest; a smaller one is rounding
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_LETTERS: dict[Any, str] = {"x": "x", "y": "y", "z": "z", 0: "x", 1: "y", 2: "z"}

Unit3 = tuple[float, float, float]


class Keys(BaseModel):
    """A mapping of a scene file: frozen, and without keys that packgen does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)


Where = str | int | tuple[str | int, ...]


def fault(*faults: tuple[Where, Any, str]) -> PydanticCustomError:
    """Return the error for faults at places inside a value: (place, found, expected) each."""
    return PydanticCustomError("packgen", "faults inside a value", {"faults": faults})


def number(value: Any, quantity: str = "number") -> float:
    """Return a finite SI number.

    Args:
        value: What the YAML held.
        quantity: A key of ``packgen.units.UNITS``.

    Returns:
        The value in SI units.

    Raises:
        ValueError: No finite number, or a unit that does not fit.
    """
    if isinstance(value, str) and quantity != "number":
        result = to_si(value, quantity)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        result = float(value)
    else:
        units = ", ".join(UNITS[quantity])
        raise ValueError(f"a number, or a number with a unit ({units})" if units else "a number")
    if not math.isfinite(result):
        raise ValueError("a finite number")
    most = _most(quantity)
    if abs(result) > most:
        raise ValueError(f"a {quantity} of at most {most:g} {next(iter(UNITS[quantity]))}")
    return result


def _most(quantity: str) -> float:
    """Return the largest value [SI] of a quantity; cubes of lengths must stay floating point numbers."""
    return {"number": math.inf, "length": 1.0e12}.get(quantity, 1.0e30)


def _quantity(
    quantity: str, rule: str = "", holds: Callable[[float], bool] = lambda _: True
) -> BeforeValidator:
    """Return a validator of a number of some quantity that has to obey a rule."""
    return BeforeValidator(lambda value: _ruled(value, quantity, rule, holds))


def _ruled(value: Any, quantity: str, rule: str, holds: Callable[[float], bool]) -> float:
    """Return an SI number that obeys a rule; where it has to be above 0, its cube is, too."""
    result = number(value, quantity)
    if not holds(result):
        raise ValueError(f"a number {rule}")
    least = 1.0 / _most(quantity)
    if rule == ABOVE_ZERO and result < least:
        raise ValueError(f"a {quantity} of at least {least:g} {next(iter(UNITS[quantity]))}")
    return result


def _positive(quantity: str) -> BeforeValidator:
    return _quantity(quantity, ABOVE_ZERO, lambda value: value > 0.0)


def _whole(lowest: int, highest: int) -> BeforeValidator:
    def check(value: Any) -> int:
        whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
        if isinstance(value, bool) or not whole or not lowest <= value <= highest:
            raise ValueError(f"a whole number from {lowest} to {highest}")
        return int(value)

    return BeforeValidator(check)


def _many(quantity: str, rule: str, holds: Callable[[float], bool]) -> BeforeValidator:
    """Return a validator of a list of numbers; the expectation names the first that is wrong."""

    def check(value: Any) -> tuple[float, ...]:
        if not isinstance(value, (list, tuple)) or not value:
            raise ValueError(f"a list of numbers {rule}")
        numbers = []
        for index, each in enumerate(value):
            try:
                numbers.append(_ruled(each, quantity, rule, holds))
            except ValueError as error:
                raise fault((index, each, str(error))) from error
        return tuple(numbers)

    return BeforeValidator(check)


def _point(value: Any) -> Unit3:
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ValueError("a list of three lengths [x, y, z]")
    x, y, z = (number(each, "length") for each in value)
    return (x, y, z)


def _velocity(value: Any) -> Unit3:
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ValueError("a list of three velocities [vx, vy, vz]")
    x, y, z = (number(each, "velocity") for each in value)
    return (x, y, z)


def _axis(value: Any) -> Unit3:
    """Return the unit vector of an axis: a letter, with or without a sign, an index, or a vector."""
    if isinstance(value, (list, tuple)) and len(value) == 3:
        vector = [number(each) for each in value]
        largest = max(abs(each) for each in vector)
        if largest == 0.0:
            raise ValueError("a vector that is not zero")
        # Scaled first: squares of very large or very small numbers leave float64's range.
        scaled = [each / largest for each in vector]
        length = math.sqrt(sum(each * each for each in scaled))
        return (scaled[0] / length, scaled[1] / length, scaled[2] / length)
    if isinstance(value, str) and value.lstrip("-") in _AXES and len(value) <= 2:
        sign = -1.0 if value.startswith("-") else 1.0
        x, y, z = _AXES[value.lstrip("-")]
        return (sign * x + 0.0, sign * y + 0.0, sign * z + 0.0)
    raise ValueError("x, y, z, -x, -y, -z or a vector [x, y, z]")


def _direction(value: Any) -> Unit3:
    """Return where things fall: a letter says up, a vector says down; a hair off an axis is the axis."""
    x, y, z = _axis(value)
    if isinstance(value, str):
        return (0.0 - x, 0.0 - y, 0.0 - z)
    largest = max(abs(x), abs(y), abs(z))
    return _axis([each if abs(each) >= TILT_MIN * largest else 0.0 for each in (x, y, z)])


def _letter(value: Any) -> str | None:
    """Return x, y or z for an axis written as a letter or an index; None for anything else."""
    plain = isinstance(value, (str, int)) and not isinstance(value, bool)
    return _LETTERS.get(value) if plain else None


def _primitive_axis(value: Any) -> Unit3:
    return _axis(_letter(value) or value)


def _slice_axis(value: Any) -> Unit3:
    letter = _letter(value)
    if letter is None:
        raise ValueError("0, 1, 2 or x, y, z")
    return _AXES[letter]


def _periodic(value: Any) -> tuple[bool, bool, bool]:
    letters = [_letter(each) for each in value] if isinstance(value, (list, tuple)) else [_letter(value)]
    if None in letters or len(set(letters)) != len(letters):
        raise ValueError("a list of different axes such as [x, y]")
    return ("x" in letters, "y" in letters, "z" in letters)


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError("true or false")
    return value


def _name(value: Any) -> str:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        raise ValueError(f"{NAME_RULE}; put a name that looks like a number into quotes")
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise ValueError(NAME_RULE)
    return value


def _file(value: Any, info: ValidationInfo) -> Path:
    """Return the path of a readable file, relative to the scene's folder."""
    if not isinstance(value, str) or not value or not value.isprintable():
        raise ValueError("the path of a file, relative to the scene file")
    return _readable(_in_folder(value, info))


def _bed_file(value: Any, info: ValidationInfo) -> Path:
    """Return the path of a file of spheres; of a result folder, that of its bed."""
    if not isinstance(value, str) or not value or not value.isprintable():
        raise ValueError("the path of a file of spheres or of a result folder, relative to the scene file")
    path = _in_folder(value, info)
    inside = path / "bed.npz"
    return _readable(inside if inside.is_file() else path)


def _file_or_count(value: Any, info: ValidationInfo) -> Path | int:
    """Return the path of a readable file, or a number of spheres of one particle."""
    if isinstance(value, str):
        return _file(value, info)
    if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= MEMBERS_MAX:
        raise ValueError(f"the path of a file of spheres, or a whole number from 1 to {MEMBERS_MAX}")
    return int(value)


def _turning(value: Any) -> str | Unit3:
    if isinstance(value, str) and value in ("random", "aligned"):
        return value
    try:
        return _axis(value)
    except ValueError as error:
        raise ValueError(f"random, aligned, {error}") from error


def _in_folder(value: str, info: ValidationInfo) -> Path:
    folder = info.context["folder"] if info.context else Path()
    return Path(folder) / value


def _readable(path: Path) -> Path:
    try:
        if path.is_dir():
            raise ValueError(f"a file, but {path} is a directory")
        if not path.is_file():
            raise ValueError(f"a file that exists; there is no {path}")
        with path.open("rb"):
            return path
    except OSError as error:
        raise ValueError(f"a file that can be read; {error.strerror}: {path}") from error


_ABOVE, _FROM_0 = {"exclusiveMinimum": 0}, {"minimum": 0}
_SHARE, _INNER = {"minimum": 0, "maximum": 1}, {"exclusiveMinimum": 0, "exclusiveMaximum": 1}


def _numbers(quantity: str, **bounds: float) -> dict[str, Any]:
    """Return the JSON schema of a number, with or without a unit of its quantity."""
    plain: dict[str, Any] = {"type": "number", **bounds}
    units = UNITS[quantity]
    if not units:
        return plain
    # Written as people do: um or with a Greek letter, m3, m^3 or with a raised digit.
    spelled = (re.sub(r"([23])", r"\\^?[\1²³]", each).replace("um", "[uµμ]m") for each in units)
    names = "|".join(spelled)
    text = rf"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*({names})?\s*$"
    return {"anyOf": [plain, {"type": "string", "pattern": text}]}


def _listed(item: dict[str, Any]) -> WithJsonSchema:
    return WithJsonSchema({"type": "array", "items": item, "minItems": 1})


def _of(quantity: str, **bounds: float) -> WithJsonSchema:
    return WithJsonSchema(_numbers(quantity, **bounds))


def _counted(lowest: int) -> WithJsonSchema:
    return WithJsonSchema({"type": "integer", "minimum": lowest})


class Plainly:
    """Says in a JSON schema that a plain value may stand for a mapping; see `plainly`."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind

    def __get_pydantic_json_schema__(
        self, core_schema: Any, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [TypeAdapter(self.kind).json_schema(), handler(core_schema)]}


def plainly(kind: Any) -> Plainly:
    """Return the mark of a mapping in whose place a plain value of some kind may stand."""
    return Plainly(kind)


_LETTER = {"enum": ["x", "y", "z", 0, 1, 2]}
_VECTOR = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
_SIGNED = {"enum": ["x", "y", "z", "-x", "-y", "-z"]}
_TURNED = {"enum": ["random", "aligned"]}
_PATH = {"type": "string", "minLength": 1}
_MEMBERS = {"type": "integer", "minimum": 1, "maximum": MEMBERS_MAX}
_THREE_LENGTHS = {"type": "array", "items": _numbers("length"), "minItems": 3, "maxItems": 3}
_THREE_VELOCITIES = {"type": "array", "items": _numbers("velocity"), "minItems": 3, "maxItems": 3}

Length = Annotated[float, _quantity("length"), _of("length")]
PositiveLength = Annotated[float, _positive("length"), _of("length", **_ABOVE)]
NonNegativeLength = Annotated[
    float, _quantity("length", "of at least 0", lambda value: value >= 0.0), _of("length", **_FROM_0)
]
Lengths = Annotated[
    tuple[float, ...],
    _many("length", ABOVE_ZERO, lambda value: value > 0.0),
    _listed(_numbers("length", **_ABOVE)),
]
Fractions = Annotated[
    tuple[float, ...],
    _many("number", "from 0 to 1", lambda value: 0.0 <= value <= 1.0),
    _listed(_numbers("number", **_SHARE)),
]
Fraction = Annotated[
    float, _quantity("number", "from 0 to 1", lambda value: 0.0 <= value <= 1.0), _of("number", **_SHARE)
]
Positive = Annotated[float, _positive("number"), _of("number", **_ABOVE)]
NonNegative = Annotated[
    float, _quantity("number", "of at least 0", lambda value: value >= 0.0), _of("number", **_FROM_0)
]
PoissonsRatio = Annotated[
    float,
    _quantity("number", "from 0 to 0.5", lambda value: 0.0 <= value <= 0.5),
    _of("number", minimum=0, maximum=0.5),
]
Tolerance = Annotated[
    float,
    _quantity("number", "greater than 0 and below 1", lambda value: 0.0 < value < 1.0),
    _of("number", **_INNER),
]
InnerFraction = Annotated[
    float,
    _quantity("number", "greater than 0 and below 1", lambda value: 0.0 < value < 1.0),
    _of("number", **_INNER),
]
SolidVolume = Annotated[float, _positive("volume"), _of("volume", **_ABOVE)]
Mass = Annotated[float, _positive("mass"), _of("mass", **_ABOVE)]
Density = Annotated[float, _positive("density"), _of("density", **_ABOVE)]
Pressure = Annotated[float, _positive("pressure"), _of("pressure", **_ABOVE)]
Period = Annotated[float, _positive("time"), _of("time", **_ABOVE)]
Frequency = Annotated[float, _positive("frequency"), _of("frequency", **_ABOVE)]
Acceleration = Annotated[float, _positive("acceleration"), _of("acceleration", **_ABOVE)]
Count = Annotated[int, _whole(1, 2**31 - 1), _counted(1)]
WholeNumber = Annotated[int, _whole(0, 2**31 - 1), _counted(0)]
Seed = Annotated[int, _whole(0, 2**63 - 1), _counted(0)]
Point = Annotated[Unit3, BeforeValidator(_point), WithJsonSchema(_THREE_LENGTHS)]
Velocity = Annotated[Unit3, BeforeValidator(_velocity), WithJsonSchema(_THREE_VELOCITIES)]
Direction = Annotated[Unit3, BeforeValidator(_direction), WithJsonSchema({"anyOf": [_SIGNED, _VECTOR]})]
PrimitiveAxis = Annotated[
    Unit3, BeforeValidator(_primitive_axis), WithJsonSchema({"anyOf": [_SIGNED, _LETTER, _VECTOR]})
]
AxisIndex = Annotated[Unit3, BeforeValidator(_slice_axis), WithJsonSchema(_LETTER)]
Periodic = Annotated[
    tuple[bool, bool, bool],
    BeforeValidator(_periodic),
    WithJsonSchema({"anyOf": [_LETTER, {"type": "array", "items": _LETTER, "uniqueItems": True}]}),
]
Flag = Annotated[bool, BeforeValidator(_flag)]
Name = Annotated[
    str, BeforeValidator(_name), WithJsonSchema({"type": "string", "pattern": f"^{_NAME.pattern}$"})
]
FilePath = Annotated[Path, BeforeValidator(_file), WithJsonSchema(_PATH)]
BedPath = Annotated[Path, BeforeValidator(_bed_file), WithJsonSchema(_PATH)]
LengthUnit = Literal["m", "cm", "mm", "um", "in", "ft"]
FileOrCount = Annotated[
    int | Path, BeforeValidator(_file_or_count), WithJsonSchema({"anyOf": [_MEMBERS, _PATH]})
]
Turning = Annotated[
    str | Unit3, BeforeValidator(_turning), WithJsonSchema({"anyOf": [_TURNED, _SIGNED, _VECTOR]})
]
