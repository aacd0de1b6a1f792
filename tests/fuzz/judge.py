"""What is wrong with a run's result, by the judge's own arithmetic: nothing of packgen is used."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tests.fuzz.generator import Case, Zone, number_shares, sum_shares
from tests.fuzz.laws import Law
from tests.fuzz.solids import Array, Box, Slab

ROUNDING = 1e-9  # of the container's size and place: what float64 loses there
SLACK = 1e-3  # of the tolerance
ACROSS = 0.999999  # cosine to gravity from which a slice bounds centres
LAW_ERROR = 3e-3  # of the judge's own curves, which are sums over points
LOOSEST = 0.35  # solid fraction over that of a bed, below which a container is not full
FULL_FROM = 100.0  # spheres from which that is asked
ARRAYS = {"position": "<f8", "radius": "<f8", "set_index": "<i4", "zone_index": "<i4", "batch_index": "<i4"}


@dataclass(frozen=True)
class Bed:
    """The arrays of ``bed.npz``."""

    position: Array
    radius: Array
    set_index: NDArray[np.int32]
    zone_index: NDArray[np.int32]
    batch_index: NDArray[np.int32]


def read_bed(path: Path) -> Bed:
    """Read ``bed.npz``; ValueError where an array is missing or of another shape or type."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in ARRAYS}
        json.loads(str(file["provenance"]))
    count = len(arrays["radius"])
    for name, kind in ARRAYS.items():
        shape = (count, 3) if name == "position" else (count,)
        if arrays[name].shape != shape or arrays[name].dtype != np.dtype(kind):
            raise ValueError(f"{name} is {arrays[name].dtype} {arrays[name].shape}, expected {kind} {shape}")
    return Bed(**arrays)


def judge_refusal(text: str, output: Path, exports: Sequence[str] = ()) -> list[str]:
    """Return what is wrong with a run that ended with exit code 2; an exporter's name is a place, too."""
    lines = text.splitlines()
    faults = judge_lines(text)
    places = "|".join([r"scene\.yaml(:\d+){0,2}", *(rf"packgen: {name}" for name in exports)])
    if not any(re.search(rf"({places}): ", line) for line in lines):
        faults.append(f"refused without a place: {lines[-1:]}")
    left = [each.name for each in output.parent.iterdir() if output.name in each.name]
    return faults + [f"refused, but {name} is there" for name in left]


def judge_lines(text: str) -> list[str]:
    """Return what is wrong with what a run said on the error stream."""
    faults = [f"says {line!r}" for line in text.splitlines() if re.search("sorry|Traceback", line)]
    said = [line for line in text.splitlines() if line.strip() and not _is_progress(line)]
    faults += [f"prints {line[:300]!r}" for line in said if not line.startswith("packgen: ")][:3]
    return faults


def _is_progress(line: str) -> bool:
    return re.match(r"(arrange|liggghts|lammps|yade)\b", line) is not None


def judge_folder(case: Case, output: Path, code: int) -> list[str]:
    """Return what is wrong with the result of a run that ended with exit code 0 or 1.

    A scene that was broken and is valid all the same is held against what every result has in common.
    """
    try:
        bed, report = read_bed(output / "bed.npz"), json.loads((output / "report.json").read_text("utf-8"))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        return [f"result cannot be read: {type(error).__name__}: {error}"]
    faults = list(of_files(case, output, report))
    faults += of_report(bed, report)
    if bool(report["missed"]) != (code == 1):
        faults.append(f"exit code {code}, but missed is {report['missed']}")
    if not (np.isfinite(bed.position).all() and np.isfinite(bed.radius).all() and (bed.radius > 0.0).all()):
        return [*faults, "a position or radius is no number"]
    if case.broken:
        return faults
    faults += of_overlaps(case, bed, report)
    faults += of_places(case, bed)
    faults += of_radii(case, bed)
    return faults + list(of_amounts(case, bed, report, code))


def of_files(case: Case, output: Path, report: dict[str, Any]) -> Iterator[str]:
    there = {each.relative_to(output).as_posix() for each in output.rglob("*") if each.is_file()}
    if there != set(report["files"]):
        yield f"files differ from those in report.json: {sorted(there ^ set(report['files']))}"
    if ("report.html" in there) == ("--no-report" in case.options):
        yield "report.html is there though unwanted, or is missing"
    for name in case.exports:
        refused = [line for line in report["missed"] if line.startswith(f"no {name} deck: ")]
        if any("exporter or a template failed" in line for line in refused):
            yield f"{name}: {refused}"
        if bool(refused) == any(each.startswith(f"{name}/") for each in there):
            yield f"{name}: a deck and a refusal, or neither: {refused}"


def of_report(bed: Bed, report: dict[str, Any]) -> list[str]:
    """Return where the report's numbers are not those of the arrays."""
    zones, sets = report["zones"], report["sets"]
    volume = 4.0 / 3.0 * np.pi * bed.radius**3
    faults = []
    if report["sphere_count"] != len(bed.radius):
        faults.append(f"report.json counts {report['sphere_count']} spheres, bed.npz has {len(bed.radius)}")
    if np.bincount(bed.zone_index, minlength=len(zones)).tolist() != [each["placed"] for each in zones]:
        faults.append("report.json and bed.npz differ in the spheres of a zone")
    if np.bincount(bed.set_index, minlength=len(sets)).tolist() != [each["count"] for each in sets]:
        faults.append("report.json and bed.npz differ in the spheres of a set")
    else:
        solid = np.bincount(bed.set_index, volume, len(sets))
        if not np.allclose(solid, [each["volume"] for each in sets], rtol=1e-9, atol=0.0):
            faults.append("report.json and bed.npz differ in the volume of a set")
    return faults


def overlaps(position: Array, radius: Array, period: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return overlaps as fractions of the smaller radius, (P,), and their pairs, (P, 2); periods [m] or 0.

    Sizes are sorted by octaves, a tree each, and spheres near a side are there again beyond the other one.
    """
    points, owner = position, np.arange(len(position))
    low = points.min(axis=0, initial=np.inf)
    reach = 2.0 * radius.max(initial=0.0)
    for axis in np.flatnonzero(period):
        near, far = points[:, axis] < low[axis] + reach, points[:, axis] > low[axis] + period[axis] - reach
        step = np.eye(3)[axis] * period[axis]
        points = np.concatenate([points, points[near] + step, points[far] - step])
        owner = np.concatenate([owner, owner[near], owner[far]])
    octave = np.floor(np.log2(radius / radius.min(initial=np.inf))).astype(int)
    found, pairs = [np.empty(0)], [np.empty((0, 2), np.int64)]
    for level in np.unique(octave):
        members = np.flatnonzero(octave[owner] == level)
        tree, queries = cKDTree(points[members]), np.flatnonzero(octave <= level)
        hits = tree.query_ball_point(position[queries], radius[queries] + radius[owner[members]].max())
        first = np.repeat(queries, [len(each) for each in hits])
        image = members[np.concatenate([np.array(each, np.int64) for each in hits])]
        first, image = first[image != first], image[image != first]
        distance = np.linalg.norm(position[first] - points[image], axis=1)
        second = owner[image]
        overlap = (radius[first] + radius[second] - distance) / np.minimum(radius[first], radius[second])
        found.append(overlap[overlap > 0.0])
        pairs.append(np.column_stack([first, second])[overlap > 0.0])
    return np.concatenate(found), np.concatenate(pairs)


def of_overlaps(case: Case, bed: Bed, report: dict[str, Any]) -> list[str]:
    """Return overlaps beyond the tolerance, and where the report says another number."""
    if len(bed.radius) == 0:
        return []
    box = case.container if isinstance(case.container, Box) else None
    period = np.where(box.periodic, box.high - box.low, 0.0) if box else np.zeros(3)
    found, pairs = overlaps(bed.position, bed.radius, period)
    worst = float(found.max(initial=0.0))
    faults = []
    rounding = _rounding(case) / float(bed.radius.min())
    if case.tolerance is not None and worst > case.tolerance * (1.0 + SLACK) + rounding:
        pair = pairs[int(found.argmax())].tolist()
        faults.append(f"spheres {pair} overlap by {worst:.3g} r, tolerance {case.tolerance:g}")
    said = report["overlap"]["overlap_max"]
    if abs(said - worst) > rounding + 1e-9:
        faults.append(f"report.json says that spheres overlap by {said:.6g}, found {worst:.6g}")
    return faults


def _rounding(case: Case) -> float:
    return ROUNDING * float(np.abs(case.container.bounds).max()) * 1e-3


def of_places(case: Case, bed: Bed) -> list[str]:
    """Return spheres that are outside the container or their zone's location."""
    if len(bed.radius) == 0:
        return []
    allowed = (case.tolerance if case.tolerance is not None else 1.0) * (1.0 + SLACK) * bed.radius
    allowed += _rounding(case)
    faults = []
    depth = bed.radius - case.container.clearance(bed.position)
    if (depth > allowed).any():
        worst = int(np.argmax(depth / bed.radius))
        faults.append(
            f"{int((depth > allowed).sum())} spheres are not inside the container, sphere {worst} by "
            f"{depth[worst] / bed.radius[worst]:.3g} r"
        )
    for index, zone in enumerate(case.zones):
        own = np.flatnonzero(bed.zone_index == index)
        if zone.location is None or len(own) == 0:
            continue
        images = _images(case, bed.position[own])
        depth = -np.max([zone.location.clearance(each) for each in images], axis=0)
        if not _bounds_centres(zone, case):
            depth += bed.radius[own]
        if (depth > allowed[own]).any():
            worst = int(np.argmax(depth / bed.radius[own]))
            faults.append(
                f"{int((depth > allowed[own]).sum())} spheres are outside zone {index}'s location, sphere "
                f"{own[worst]} by {depth[worst] / bed.radius[own[worst]]:.3g} r"
            )
    return faults


def _images(case: Case, position: Array) -> list[Array]:
    """Return positions (N, 3), for each periodic axis again: on one of its sides is on the other one, too."""
    images = [position]
    box = case.container
    for axis in np.flatnonzero(box.periodic) if isinstance(box, Box) else ():
        period = box.high[axis] - box.low[axis]
        step = np.eye(3)[axis] * period
        on_low = position[:, [axis]] - box.low[axis] < ROUNDING * period
        on_high = box.high[axis] - position[:, [axis]] < ROUNDING * period
        images += [np.where(on_low, each + step, np.where(on_high, each - step, each)) for each in images]
    return images


def _bounds_centres(zone: Zone, case: Case) -> bool:
    """Tell whether a location is a slice across gravity, or across what periodic sides leave of gravity."""
    if not isinstance(zone.location, Slab):
        return False
    walls = np.array([not wraps for wraps in getattr(case.container, "periodic", (False,) * 3)])
    held = np.where(walls, case.down, 0.0)
    down = held / np.linalg.norm(held) if np.linalg.norm(held) > 1e-6 else case.down
    return bool(abs(down[zone.location.axis]) > ACROSS)


def of_radii(case: Case, bed: Bed) -> list[str]:
    """Return radii that their laws do not have."""
    faults = []
    for index, law in enumerate(case.laws):
        radius = bed.radius[bed.set_index == index]
        outside = (radius < law.low * (1.0 - 1e-12)) | (radius > law.high * (1.0 + 1e-12))
        if outside.any():
            faults.append(
                f"set {index}: radius {radius[outside][0]:.17g} is outside {law.low:.17g} to {law.high:.17g}"
            )
        elif law.stepped and len(radius):
            near = np.abs(law.radius - radius[:, None]).min(axis=1)
            if (near > 1e-12 * radius).any():
                faults.append(f"set {index}: radius {radius[near.argmax()]:.17g} is none of its law's")
        if law.listed and not _is_part(radius, law.radius):
            faults.append(f"set {index}: a sphere of its file is there twice")
    return faults


def _is_part(radius: Array, listed: Array) -> bool:
    there, count = np.unique(radius, return_counts=True)
    return all(np.count_nonzero(listed == each) >= times for each, times in zip(there, count, strict=True))


def of_amounts(case: Case, bed: Bed, report: dict[str, Any], code: int) -> Iterator[str]:
    """Yield what a zone has too many or too few of; a run with exit code 1 may have too few."""
    for index, zone in enumerate(case.zones):
        own = bed.zone_index == index
        asked = report["zones"][index]["asked"]
        whole = code == 0 or (asked is not None and asked == own.sum())
        yield from (f"zone {index}: {each}" for each in _of_zone(case, zone, bed, own, whole=whole))
        if code == 0 and asked is not None and asked != own.sum():
            yield f"zone {index}: report.json asks for {asked} spheres, {own.sum()} are there, exit code 0"


def _of_zone(case: Case, zone: Zone, bed: Bed, own: NDArray[np.bool_], *, whole: bool) -> Iterator[str]:
    share = number_shares(zone, case.laws, case.densities)
    count = np.bincount(bed.set_index[own], minlength=len(case.laws))
    if (count[share == 0.0] > 0).any():
        yield f"sets of share 0 have spheres: {count.tolist()}"
    if not whole:
        if zone.key == "n_particles" and count.sum() > zone.amount:
            yield f"{count.sum()} spheres, {zone.amount} are asked for"
        return
    if zone.key == "n_particles":
        yield from _of_count(case.laws, zone, share, bed, own)
    elif zone.key:
        yield from _of_sum(case, zone, share, bed, own)
    elif count.sum() == 0:
        yield "exit code 0, but no sphere"
    elif any(law.listed and each > 0.0 for law, each in zip(case.laws, share, strict=True)):
        pairs = [(len(law.radius), each) for law, each in zip(case.laws, share, strict=True) if law.listed]
        total = min(round(files / each, 9) for files, each in pairs if each > 0.0)
        if abs(count.sum() - total) > 1.0:
            yield f"{count.sum()} spheres, the files of radii are used up by {total:.6g}"
    elif _must_be_full(case, share):
        expected = 0.55 * zone.capacity / float(share @ [law.mean_volume for law in case.laws])
        if expected > FULL_FROM and count.sum() < LOOSEST * expected:
            yield f"filled until full with {count.sum()} spheres, about {expected:.0f} have room"


def _of_sum(case: Case, zone: Zone, share: Array, bed: Bed, own: NDArray[np.bool_]) -> Iterator[str]:
    """Yield what is wrong with a zone that asks for a volume or mass: its sum, and the shares of its sets."""
    density = case.densities if zone.key == "mass" else np.ones(len(case.laws))
    set_index = bed.set_index[own]
    weight = 4.0 / 3.0 * np.pi * bed.radius[own] ** 3 * density[set_index]
    high = 4.0 / 3.0 * np.pi * np.array([law.high for law in case.laws]) ** 3 * density
    largest = high[share > 0.0].max()
    allowed = largest
    if zone.shares_by != "number":
        # The shares come first: each set is off by half a sphere of its own, and the sum by all of these.
        allowed = max(largest, 0.5 * high[share > 0.0].sum())
    if abs(weight.sum() - zone.amount) > allowed:
        yield f"{zone.key} is {weight.sum():.6g}, asked {zone.amount:.6g}, heaviest sphere {largest:.3g}"
    count = np.bincount(set_index, minlength=len(case.laws))
    if zone.shares_by == "number":
        if not _are_rounded(count, share):
            yield f"sets have {count.tolist()} spheres, expected {np.round(share * count.sum(), 2).tolist()}"
        return
    for index, asked in enumerate(sum_shares(zone, case.densities) * zone.amount):
        spheres, law = weight[set_index == index], case.laws[index]
        # Of a file the spheres are what they are, and no sphere comes after the last one.
        smallest = high[index] if law.listed else spheres.min(initial=high[index])
        missing = asked - spheres.sum()
        used_up = law.listed and len(spheres) == len(law.radius) and missing > 0.0
        if abs(missing) > (0.5 + 1e-6) * smallest + ROUNDING * zone.amount and not used_up:
            yield (
                f"set {index}: {zone.key} is {spheres.sum():.6g}, its share {asked:.6g}, "
                f"lightest sphere {smallest:.3g}"
            )


def _are_rounded(count: NDArray[np.int64], share: Array, error: float = 0.0) -> bool:
    """Tell whether counts are shares of their total by largest remainder, the shares being off by an error.

    Counts that are rounded up are above their quotas by one less their remainders, the others are below by
    their remainders. Where the largest remainders are rounded up, no two of these differ by more than one.
    """
    above = (count - share * count.sum())[share > 0.0]
    return bool(np.ptp(above) <= 1.0 + 1e-6 + 2.0 * error * count.sum())


def _must_be_full(case: Case, share: Array) -> bool:
    used = [law for law, each in zip(case.laws, share, strict=True) if each > 0.0]
    narrow = max(law.high for law in used) < 3.0 * min(law.low for law in used)
    return (
        narrow
        and len(case.zones) == 1
        and case.zones[0].location is None
        and not any(law.listed for law in used)
    )


def _of_count(laws: list[Law], zone: Zone, share: Array, bed: Bed, own: NDArray[np.bool_]) -> Iterator[str]:
    count = np.bincount(bed.set_index[own], minlength=len(laws))
    if count.sum() != zone.amount:
        yield f"{count.sum()} spheres, {zone.amount} are asked for"
        return
    if not _are_rounded(count, share, 0.0 if zone.shares_by == "number" else LAW_ERROR):
        yield f"sets have {count.tolist()} spheres, expected {np.round(share * zone.amount, 2).tolist()}"
    for index, law in enumerate(laws):
        radius = np.sort(bed.radius[own & (bed.set_index == index)])
        if law.listed or len(radius) == 0:
            continue
        # One radius from each of as many equal classes: the curve reached is within one class of the law.
        level = (np.arange(len(radius)) + 0.5) / len(radius)
        if law.stepped:
            reached = np.searchsorted(radius, law.radius * (1.0 + 1e-12), side="right") / len(radius)
            off = float(np.abs(reached - law.number).max())
        else:
            off = float(np.abs(np.interp(radius, law.radius, law.number) - level).max())
        if off > 1.5 / len(radius) + LAW_ERROR:
            yield f"set {index}: the curve of its {len(radius)} radii is off by {off:.3g}"
