"""Voxels: ``voxels.npy`` and ``voxels.tif``, the exact solid share of each voxel, or 0 and 1.

The axes of the array are z, y, x; the image has a page for each z, from the bottom, rows along y and columns
along x. Shares are exact to rounding (closed forms of `exporters.fields.ball_cuts`): in the array float64, in
the image float32. With ``binary`` a voxel is solid, 1 in the array and 255 in the image, where its middle is
in a sphere. What lies beyond the walls is void. Spheres that overlap count twice, up to a share of 1;
``voxels.json`` says how much that cuts off, and has size, place and order of the voxels.

Reference: TIFF 6.0; pages are uncompressed, one strip each.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from exporters.fields.grid_cells import grid_volumes
from exporters.fields.grid_points import points_in_balls
from exporters.protocol import Outlook
from exporters.shared import deck
from exporters.shared.tiff import TIFF_BYTES_MAX, write_tiff
from packgen.arrays import Float64Array
from packgen.bed import Bed, with_images
from packgen.errors import ExportError

NAME = "voxels"
NEEDS: tuple[str, ...] = ()
VOXELS_MAX = 200_000_000  # 1.6 GB of shares
VOXELS_A_DIAMETER = 10.0


class Options(BaseModel):
    """Options of the voxels.

    Attributes:
        size: Edge of a voxel [m], made a little smaller where the container's size is no multiple of it;
            None: a tenth of the smallest diameter.
        binary: Whether voxels are solid or void as a whole, by their middles.
        format: Which files: npy, tif, or both.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    size: float | None = Field(default=None, gt=0)
    binary: bool = False
    format: Literal["npy", "tif", "both"] = "both"


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the files into an existing folder and return their paths.

    Raises:
        ExportError: The bed is empty, a number in it is not finite, or there would be too many voxels.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    low, high = bed.container.bounds
    size = 2 * float(bed.radius.min()) / VOXELS_A_DIAMETER if options.size is None else options.size
    shape = _shape(high - low, size, options)
    spacing = (high - low) / shape
    position, radius = with_images(bed)
    told: dict[str, Any] = {
        "axes": "z, y, x", "shape": list(shape[::-1]), "voxel_size_xyz": spacing.tolist(),
        "lower_corner_xyz": low.tolist(), "unit": "m", "binary": options.binary,
        "spheres_volume": 4 / 3 * np.pi * float((bed.radius**3).sum()),
    }  # fmt: skip
    if options.binary:
        array: Any = points_in_balls(position, radius, low, spacing, shape).astype(np.uint8)
        image: Any = array * np.uint8(255)
    else:
        array, cut = _shares(position, radius, low, spacing, shape)
        image = array.astype(np.float32)
        told["volume_cut_off_at_1"] = cut
    told["solid_volume_in_voxels"] = float(array.sum()) * float(spacing.prod())
    paths = [deck.write_text(folder / "voxels.json", json.dumps(told, indent=2) + "\n")]
    if options.format in ("npy", "both"):
        np.save(folder / "voxels.npy", np.ascontiguousarray(array.T))
        paths.append(folder / "voxels.npy")
    if options.format in ("tif", "both"):
        text = f"packgen voxels, x y z {' '.join(map(repr, spacing.tolist()))} m"
        paths.append(write_tiff(folder / "voxels.tif", image.T, text))
    return paths


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse more voxels than there may be.

    Raises:
        ExportError: There would be too many, whatever the spheres' sizes turn out to be.
    """
    low, high = outlook.container.bounds
    size = 2 * outlook.radius_max / VOXELS_A_DIAMETER if options.size is None else options.size
    _shape(high - low, size, options)


def _shape(extent: Float64Array, size: float, options: Options) -> tuple[int, int, int]:
    count = np.maximum(1, np.ceil(extent / size * (1 - 1e-12)))
    if count.prod() > VOXELS_MAX:
        enough = 1.02 * float(np.cbrt(extent.prod() / VOXELS_MAX))
        raise ExportError(
            f"{NAME}: {count.prod():.3g} voxels of {size:.3g} m, expected at most {VOXELS_MAX:,}; enlarge "
            f"{NAME}.size to {enough:.3g} or so"
        )
    octets = (1 if options.binary else 4) * count.prod()
    if options.format != "npy" and octets > TIFF_BYTES_MAX:
        raise ExportError(
            f"{NAME}: an image of {octets / 1e9:.1f} GB, expected at most 4; choose {NAME}.format=npy"
        )
    return int(count[0]), int(count[1]), int(count[2])


def _shares(
    position: Float64Array,
    radius: Float64Array,
    low: Float64Array,
    spacing: Float64Array,
    shape: tuple[int, int, int],
) -> tuple[Float64Array, float]:
    """Return the solid share of each voxel, x first, and the volume that overlaps count twice [m3]."""
    share = grid_volumes(position, radius, low, spacing, shape) / spacing.prod()
    above = float(np.maximum(share - 1.0, 0.0).sum()) * float(spacing.prod())
    share[np.abs(share - 1.0) < 1e-9] = 1.0
    np.clip(share, 0.0, 1.0, out=share)
    return share, above
