"""Crack-free isosurfaces with a certified error, in this process or from a Multi-Tetra server.

    import multitetra

    mesh = multitetra.isosurface(array, 300.5, error=0.25, spacing=(0.7, 0.7, 1.0))
    print(mesh.certificate)
    mesh.save("bone.stl")

    volume = multitetra.Volume("ct.nii.gz")
    skin, bone = volume.isosurface([300.5, 700.5], max_triangles=500_000)
    print(multitetra.certify("other.stl", volume, 300.5, error=1))

    with multitetra.connect("ws://127.0.0.1:7480") as server:
        for step in server.steps("head", 500.5, error=0.25):
            show(step.mesh)
        print(step.mesh.components()[0].area, server.slice("head", "z", 40).values.mean())
        hot = server.isosurface("density", 1.0, color_by="temperature").scalars

Every mesh has passed the checks of clients before it is given: no crack, and the topology that it promises; tiles of a server
against counts and digests.
"""

import importlib
from typing import TYPE_CHECKING

from ._client import CheckError, Estimate, ServerError, __version__  # noqa: F401
from ._client import grid
from .connection import connect
from .mesh import Certificate, Mesh
from .requests import EmptySurfaceWarning
from .thresholds import ball, box, camera, half_space

if TYPE_CHECKING:
    from .certification import Comparison, certify  # noqa: F401
    from .viewer import Viewer, view  # noqa: F401
    from .volume import Step, Volume, VolumeError, VolumeWarning, isosurface, prepare  # noqa: F401

# Loaded on first use: clients of servers need no engine, and only the viewer needs ipywidgets.
_FURTHER = {
    "certification": ("Comparison", "certify"),
    "viewer": ("Viewer", "view"),
    "volume": ("Step", "Volume", "VolumeError", "VolumeWarning", "isosurface", "prepare"),
}


def __getattr__(name):
    for module, names in _FURTHER.items():
        if name in names:
            return getattr(importlib.import_module(f".{module}", __name__), name)
    raise AttributeError(f"module 'multitetra' has no attribute '{name}'")


__all__ = [
    "Certificate",
    "CheckError",
    "EmptySurfaceWarning",
    "Estimate",
    "Mesh",
    "ServerError",
    "ball",
    "box",
    "camera",
    "connect",
    "grid",
    "half_space",
]
