"""A number gives a scene: its files in a folder, its command line, and what the judge must know of it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tests.fuzz.laws import Law, random_law
from tests.fuzz.shapes import odd, random_direction, random_mesh, random_primitive, save_mesh
from tests.fuzz.solids import Array, Ball, Box, Cone, Hull, Slab, Solid, Solidmesh

EXPORTERS = ("liggghts", "lammps", "yade", "vtk", "csv", "cfdem", "fraction", "mfix", "mercury", "esys",
             "kratos", "geotaichi", "chrono")  # fmt: skip
COUNT_MAX = 800
FULL_MAX = 1000  # spheres of a zone that is filled until full
DENSITY_OF_BEDS = 0.55
POINTS = 600
ADAM_MAX = 20.0
REFUSED = 0.1  # of the scenes with a deck that packgen refuses early, those that keep it
AXES = {"x": (-1, 0, 0), "y": (0, -1, 0), "z": (0, 0, -1), "-x": (1, 0, 0), "-y": (0, 1, 0), "-z": (0, 0, 1)}


@dataclass
class Zone:
    """A zone: where, and in a scene's words; the amount and the key that asks for it, ``""`` until full."""

    location: Solid | None
    place: dict[str, Any] | None
    capacity: float
    shares: list[float]
    shares_by: str = "number"
    key: str = ""
    amount: float = 0.0

    def spec(self) -> dict[str, Any]:
        """Return the zone as a scene has it."""
        spec: dict[str, Any] = {self.key: self.amount} if self.key else {}
        if self.place is not None:
            spec["location"] = self.place
        if len(self.shares) > 1:
            spec |= {"set_proportions": self.shares, "proportions_by": self.shares_by}
        return spec


@dataclass
class Case:
    """A scene and what the judge must know of it; ``down`` is where things fall, (3,)."""

    number: int
    folder: Path
    data: dict[str, Any]
    container: Solid
    down: Array
    laws: list[Law]
    zones: list[Zone]
    tolerance: float | None
    exports: list[str]
    options: list[str] = field(default_factory=list)
    broken: str = ""

    @property
    def path(self) -> Path:
        """The scene file."""
        return self.folder / "scene.yaml"

    @property
    def densities(self) -> Array:
        """Density of each set [kg/m3]."""
        return np.array([each.get("density", 2500.0) for each in self.data["particle_sets"]])

    @property
    def arguments(self) -> list[str]:
        """What the command line gets besides the scene and the output folder."""
        return [*self.options, *(["--export", ",".join(self.exports)] if self.exports else [])]

    def write(self) -> None:
        """Write the scene file."""
        plain = json.loads(json.dumps(self.data))  # numpy's numbers become Python's, to the last digit
        self.path.write_text(yaml.safe_dump(plain, sort_keys=False), encoding="utf-8")


def make_case(number: int, folder: Path) -> Case:
    """Make a scene; its mesh files and files of radii are written into a folder, and the scene file itself.

    Args:
        number: Which scene.
        folder: An existing folder.
    """
    rng = np.random.default_rng([number, 22])
    axis, down = _gravity(rng)
    laws = _laws(rng, folder)
    sets = [{**law.spec, **_set_keys(rng, index)} for index, law in enumerate(laws)]
    wanted = float(COUNT_MAX ** rng.beta(1.0, 1.4))
    params = _params(rng)
    adam = params.get("optimizer") == "adam"
    wanted = min(wanted, ADAM_MAX) if adam else wanted
    spec, container = _container(rng, laws, wanted, -down, folder, adam=adam)
    density = np.array([each.get("density", 2500.0) for each in sets])
    zones = _zones(rng, container, laws, down, folder)
    for zone in zones:
        _ask(rng, zone, laws, density, wanted / len(zones), must=adam)
    data: dict[str, Any] = {"container": spec, "gravity_axis": axis, "seed": int(rng.integers(2**31))}
    if rng.random() < 0.2:
        data["gravity"] = float(np.exp((3.0 if odd(rng) else 1.0) * rng.uniform(-3.0, 3.0)))
    data |= {"params": params} if params else {}
    data |= {"particle_sets": sets} | _materials(rng, sets)
    if len(zones) > 1 or zones[0].spec() or rng.random() < 0.5:
        data["zones"] = [zone.spec() for zone in zones]
    tolerance = params.get("tolerance", 1e-6)
    case = Case(number, folder, data, container, down, laws, zones, tolerance, _exports(rng), _options(rng))
    if not has_lammps_walls(container) and rng.random() > REFUSED:
        case.exports = [each for each in case.exports if each != "lammps"]
    case.write()
    return case


def has_lammps_walls(container: Solid) -> bool:
    """Tell whether LAMMPS has walls for a container: it is convex, and a cone is steep and along an axis."""
    if isinstance(container, Cone):
        slope = abs(container.top - container.bottom) / container.height
        return bool((np.abs(container.axis) == 1.0).any() and slope < np.tan(np.radians(60.0)))
    return not isinstance(container, Solidmesh) or container.is_convex


def _gravity(rng: np.random.Generator) -> tuple[Any, Array]:
    """Return what a scene may say of gravity, and where things fall then."""
    kind = rng.random()
    if kind < 0.75:
        axis = str(rng.choice(list(AXES))) if kind < 0.4 else "z"
        return axis, np.array(AXES[axis], float)
    down = random_direction(rng)
    if kind < 0.87:
        down = np.eye(3)[int(rng.integers(3))] * rng.choice([-1.0, 1.0])
    if kind > 0.85 and kind < 0.87:  # nearly along an axis
        down = down + 10.0 ** rng.uniform(-5.0, -1.0) * random_direction(rng)
        down = down / np.linalg.norm(down)
    length = float(np.exp(rng.uniform(-2.0, 3.0)))
    return (length * down).tolist(), down


def _laws(rng: np.random.Generator, folder: Path) -> list[Law]:
    low = float(10.0 ** (rng.uniform(-7.0, 5.0) if odd(rng) else rng.uniform(-4.0, 1.0)))
    ratio = float(np.exp(rng.uniform(0.0, np.log(20.0 if rng.random() < 0.15 else 4.0))))
    high = low if rng.random() < 0.15 else low * ratio
    count = int(rng.choice([1, 2, 3, 4], p=[0.5, 0.25, 0.15, 0.1]))
    laws = []
    for index in range(count):
        ends = np.sort(low * (high / low) ** rng.random(2)) if rng.random() < 0.5 else (low, high)
        laws.append(random_law(rng, float(ends[0]), float(ends[1]), folder, f"radii_{index}"))
    return laws


def _set_keys(rng: np.random.Generator, index: int) -> dict[str, Any]:
    keys: dict[str, Any] = {}
    if rng.random() < 0.5:
        keys["density"] = float(10.0 ** (rng.uniform(-3.0, 7.0) if odd(rng) else rng.uniform(1.7, 4.3)))
    if rng.random() < 0.3:
        keys["name"] = f"kind-{index}.of_{index}"
    return keys


def _params(rng: np.random.Generator) -> dict[str, Any]:
    params: dict[str, Any] = {}
    if rng.random() < 0.015:
        params |= {
            "optimizer": "adam",
            "n_epoch": int(rng.integers(50, 200)),
            "batch_size": int(rng.integers(3, 40)),
        }
    elif rng.random() < 0.08:
        params["batch_size"] = int(np.exp(rng.uniform(2.0, 7.0)))
    if rng.random() < 0.4:
        params["tolerance"] = [1e-3, None, 1e-6, 1e-2, 1e-9][int(rng.integers(5))]
    if odd(rng):
        params["tolerance"] = [1e-12, 0.1, 0.5, 0.99][int(rng.integers(4))]
    return params


def _container(
    rng: np.random.Generator, laws: list[Law], wanted: float, up: Array, folder: Path, *, adam: bool
) -> tuple[dict[str, Any], Any]:
    """Return a container for about so many spheres, in a scene's words and as a body."""
    kind = rng.random()
    body: Any = random_primitive(rng, up) if kind < 0.6 else random_mesh(rng, up, open_top=kind > 0.8)
    periodic = (
        rng.random(3) < 0.5
        if isinstance(body, Box) and not adam and rng.random() < 0.7
        else np.zeros(3, bool)
    )
    widest = max(law.high for law in laws)
    room = (
        wanted * rng.uniform(1.0, 1.6) * float(np.mean([law.mean_volume for law in laws])) / DENSITY_OF_BEDS
    )
    scale = float(np.cbrt(room / body.volume))
    low, high = body.bounds
    within = body.clearance(low + rng.random((300, 3)) * (high - low)).max()
    scale = max(scale, 1.03 * widest / within)
    if periodic.any():
        scale = max(scale, (4.01 * widest / (high - low)[periodic]).max())
    if odd(rng) and isinstance(body, Box | Ball) and not periodic.any():  # as narrow as its widest sphere
        within = float((high - low).min()) / 2.0
        scale = widest / within * float(rng.choice([1.0, 1.0 + 1e-12, 1.0 + 1e-6]))
    far = 2.0
    if kind < 0.6 and odd(rng):
        far = float(rng.choice([100.0, 1e4, 1e5]))
    shift = rng.uniform(-far, far, 3) * scale * (rng.random() < 0.6)
    body = body.moved(scale, shift)
    if isinstance(body, Box):
        body = Box(body.low, body.high, tuple(bool(each) for each in periodic))  # type: ignore[arg-type]
        axes = {"periodic": [name for name, wraps in zip("xyz", periodic, strict=True) if wraps]}
        return body.spec() | (axes if periodic.any() else {}), body
    return save_mesh(rng, body, folder, "vessel") if kind >= 0.6 else (body.spec(), body)


def _zones(
    rng: np.random.Generator, container: Any, laws: list[Law], down: Array, folder: Path
) -> list[Zone]:
    """Return zones without an amount yet, each with the volume of the room that it has for itself [m3]."""
    count = int(rng.choice([1, 2, 3, 6], p=[0.65, 0.24, 0.09, 0.02]))
    count = 1 if all(law.listed for law in laws) else count
    places = [_location(rng, container, down, folder, index) for index in range(count)]
    low, high = container.bounds
    points = low + rng.random((POINTS, 3)) * (high - low)
    points = points[container.clearance(points) > 0.0]
    owned = [
        np.ones(len(points), bool) if body is None else body.clearance(points) > 0.0 for _, body in places
    ]
    rivals = np.maximum(np.sum(owned, axis=0), 1)
    users = [int(rng.integers(count)) for _ in laws]  # a file's spheres exist once: one zone has them
    zones = []
    for index, (place, body) in enumerate(places):
        room = float((owned[index] / rivals).sum()) / max(len(points), 1) * container.volume
        shares = _shares(rng, laws, [user == index for user in users])
        by = str(rng.choice(["number", "volume", "mass"])) if len(laws) > 1 else "number"
        zones.append(Zone(body, place, room, shares, by))
    return zones


def _location(
    rng: np.random.Generator, container: Any, down: Array, folder: Path, index: int
) -> tuple[dict[str, Any] | None, Any]:
    """Return a location that the container has a part of, in a scene's words and as a body; mostly none."""
    low, high = container.bounds
    kind = rng.random()
    if kind < 0.45:
        return None, None
    if kind < 0.75:
        axis = int(np.argmax(np.abs(down))) if rng.random() < 0.8 else int(rng.integers(3))
        ends = np.sort(rng.uniform(-0.1, 1.1, 2))
        if odd(rng):  # exactly the container, or a thin slice
            ends = np.array([0.0, 1.0]) if rng.random() < 0.5 else ends[0] + np.array([0.0, 0.01])
        body: Any = Slab(axis, *(float(each) for each in low[axis] + ends * (high - low)[axis]))
        return body.spec(), body
    size = float((high - low).min() * rng.uniform(0.5, 1.2))
    middle = low + rng.uniform(0.2, 0.8, 3) * (high - low)
    if (
        odd(rng)
        and not isinstance(container, Hull | Solidmesh)
        and not any(getattr(container, "periodic", ()))
    ):
        return container.spec(), container
    if kind < 0.92:
        body = random_primitive(rng).moved(size, middle)
        return body.spec(), body
    return save_mesh(
        rng, random_mesh(rng, -down, open_top=False).moved(size, middle), folder, f"place_{index}"
    )


def _shares(rng: np.random.Generator, laws: list[Law], mine: list[bool]) -> list[float]:
    """Return shares of the sets that add up to 1: none of a file that another zone uses."""
    weight = rng.dirichlet(np.ones(len(laws))) + 0.01
    usable = [owns or not law.listed for owns, law in zip(mine, laws, strict=True)]
    weight = np.where(usable, weight, 0.0)
    if weight.sum() == 0.0 or len(laws) == 1:
        return [1.0] + [0.0] * (len(laws) - 1)
    weight = np.where(rng.random(len(laws)) < 0.1, 0.0, weight) if rng.random() < 0.3 else weight
    weight = weight if weight.sum() > 0.0 else np.asarray(usable, float)
    return [float(each) for each in weight / weight.sum()]


def number_shares(zone: Zone, laws: list[Law], density: Array) -> Array:
    """Return the shares by number of a zone's sets, shape (sets,)."""
    weight = np.ones(len(laws))
    if zone.shares_by != "number":
        weight = np.array([law.mean_volume for law in laws])
        weight = weight * density if zone.shares_by == "mass" else weight
    share = np.array(zone.shares) / weight
    return np.asarray(share / share.sum())


def sum_shares(zone: Zone, density: Array) -> Array:
    """Return the shares of a zone's sets in the volume or mass that it asks for, shape (sets,).

    Args:
        zone: A zone with shares by volume or mass, or with one set.
        density: Density of each set [kg/m3], shape (sets,).
    """
    share = np.array(zone.shares)
    if zone.shares_by != zone.key:
        share = share * density if zone.key == "mass" else share / density
    return np.asarray(share / share.sum())


def _ask(
    rng: np.random.Generator, zone: Zone, laws: list[Law], density: Array, most: float, *, must: bool
) -> None:
    """Give a zone an amount that mostly fits, by count, volume or mass; some are filled until full."""
    share = number_shares(zone, laws, density)
    volume = np.array([law.mean_volume for law in laws])
    full = DENSITY_OF_BEDS * zone.capacity / float(share @ volume)
    kind = rng.random()
    if kind < 0.25 and full < FULL_MAX and not must:
        return
    part = rng.uniform(0.05, 0.6) if kind < 0.88 else rng.uniform(0.6, 1.3)
    files = [
        law.radius.size / each for law, each in zip(laws, share, strict=True) if law.listed and each > 0.0
    ]
    count = max(1.0, min([part * full, 2.0 * most, *files]))
    zone.key = (
        str(rng.choice(["n_particles", "volume", "mass"], p=[0.5, 0.25, 0.25])) if not must else "n_particles"
    )
    each = {"n_particles": 1.0, "volume": share @ volume, "mass": share @ (volume * density)}[zone.key]
    zone.amount = int(count) if zone.key == "n_particles" else float(count * each)


def _materials(rng: np.random.Generator, sets: list[dict[str, Any]]) -> dict[str, Any]:
    """Return materials, if any, and give each set one."""
    if rng.random() < 0.5:
        return {}
    names = ["ore", "coke", "steel"][: int(rng.integers(1, 4))]
    materials = {}
    for name in names:
        friction = (
            float(rng.choice([0.0, 0.05, 0.1, 0.2, 0.33, 0.5, 1.0]))
            if rng.random() < 0.8
            else float(rng.random())
        )
        materials[name] = {"youngs_modulus": float(10.0 ** rng.uniform(7.0, 10.0)), "friction": friction}
        if rng.random() < 0.5:
            materials[name] |= {
                "poissons_ratio": float(rng.uniform(0.0, 0.45)),
                "restitution": float(rng.uniform(0.1, 1.0)),
            }
        if rng.random() < 0.2:
            materials[name]["rolling_friction"] = float(rng.uniform(0.0, 0.5))
    for each in sets:
        if len(names) > 1 or rng.random() < 0.5:
            each["material"] = str(rng.choice(names))
    return {"materials": materials} | ({"wall_material": names[-1]} if rng.random() < 0.5 else {})


def _exports(rng: np.random.Generator) -> list[str]:
    count = int(rng.choice([0, 1, 2, 4], p=[0.3, 0.4, 0.2, 0.1]))
    return [str(each) for each in rng.choice(EXPORTERS, count, replace=False)]


def _options(rng: np.random.Generator) -> list[str]:
    options = ["--quiet"] if rng.random() < 0.7 else []
    options += ["--no-report"] if rng.random() < 0.95 else []
    options += ["--threads", str(int(rng.integers(1, 3)))] if rng.random() < 0.5 else []
    return options + (["--seed", str(int(rng.integers(1000)))] if rng.random() < 0.2 else [])
