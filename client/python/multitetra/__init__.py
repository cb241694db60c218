"""Crack-free isosurfaces from a Multi-Tetra server.

    import multitetra

    with multitetra.connect("ws://127.0.0.1:7480") as server:
        mesh = server.isosurface("head", 500.5, error=1.0)
        print(mesh.vertices.shape, mesh.faces.shape)
        for step in server.steps("head", 500.5, error=0.25):
            show(step.mesh)

What comes is checked before it is given: every tile against its counts and its digest, every step against its
manifest and its digest, and that no edge is shared by more than two triangles.
"""

from .conversation import CheckError, ServerError, connect
from .mesh import Mesh
from .request import ball, box, half_space

__all__ = ["CheckError", "Mesh", "ServerError", "ball", "box", "connect", "half_space"]
