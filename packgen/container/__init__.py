"""From a scene's container and locations to shapes: primitives as they are, meshes read and mended."""

from __future__ import annotations

from packgen.container.amounts import checked_locations
from packgen.container.load import load_container, load_location

__all__ = ["checked_locations", "load_container", "load_location"]
