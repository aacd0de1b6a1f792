"""From a scene's container and locations to shapes: primitives as they are, meshes read and mended."""

from __future__ import annotations

from packgen.container.load import closed_mesh, load_container, load_location, mesh_container

__all__ = ["closed_mesh", "load_container", "load_location", "mesh_container"]
