"""Crack-free isosurfaces from a Multi-Tetra server.

    import multitetra

    with multitetra.connect("ws://127.0.0.1:7480") as server:
        vertices, faces = server.isosurface("head", 500.5, error=1.0)
        print(server.estimate("head", 500.5, error=0.25).triangles)
        for step in server.steps("head", 500.5, error=0.25):
            show(step.mesh)
        skin, bone = server.isosurfaces("head", [500.5, 1200.5], max_triangles=500_000)
        print(bone.components()[0].area, server.slice("head", "z", 40).values.mean())
        hot = server.isosurface("density", 1.0, color_by="temperature").scalars

Every step has passed the checks of the C++ client before it is given: tiles against counts and digests, no crack, and one
topology in all steps that promise that of the full surface.
"""

from ._client import CheckError, Estimate, ServerError, __version__  # noqa: F401
from ._client import grid
from .connection import EmptySurfaceWarning, connect
from .mesh import Mesh
from .thresholds import ball, box, half_space, view


def __getattr__(name):
    """`Viewer` alone needs ipywidgets, so that it is no part of `from multitetra import *`."""
    if name == "Viewer":
        from .viewer import Viewer

        return Viewer
    raise AttributeError(f"module 'multitetra' has no attribute '{name}'")


__all__ = [
    "CheckError",
    "EmptySurfaceWarning",
    "Estimate",
    "Mesh",
    "ServerError",
    "ball",
    "box",
    "connect",
    "grid",
    "half_space",
    "view",
]
