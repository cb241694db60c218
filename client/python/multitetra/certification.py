"""Comparison of any mesh with the full-resolution isosurface of a volume."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from . import _engine
from .mesh import Mesh
from .volume import Progress, Volume, _shown, use_reader


@dataclass(frozen=True)
class Comparison:
    """What `certify` found. True if the mesh passes: no point beyond the error, and the topology of the surface.

    Attributes
    ----------
    kept : bool
    distance : float
        The largest two-sided distance between the mesh and the surface, in world units, is at most this; infinite if one of them is empty.
    proven : bool or None
        Whether the error is proven, not only not exceeded at any measured point. None: no error was given. Errors are those before the
        rounding of vertices to a lattice, which is allowed besides: see `lattice` of `certify`.
    topology_kept, watertight : bool
    report : dict
        All of it, with the keys of ``multitetra-server certify --json``.
    text : str
        All of it for people, which `print` shows.
    """

    kept: bool
    distance: float
    proven: Optional[bool]
    topology_kept: bool
    watertight: bool
    report: dict = field(repr=False)
    text: str = field(repr=False)

    def __bool__(self) -> bool:
        return self.kept

    def __str__(self) -> str:
        return self.text


def certify(
    mesh: Any, volume: Any, isovalue: float, error: Optional[float] = None, *, unit: str = "voxel", any_topology: bool = False,
    min_component: Optional[float] = None, self_intersections: bool = False, inside_out: bool = False, allow_rounding: bool = False,
    lattice: Optional[int] = None, threads: int = 0, progress: Progress = None,
) -> Comparison:  # fmt: skip
    """Compares a mesh from any program with the full-resolution isosurface of a volume.

    Parameters
    ----------
    mesh : Mesh, path, or mesh of another library
        A mesh file (.ply, .stl, .obj, .glb, .3mf, .drc, .vtp), vertices and faces, or an object of trimesh, pyvista, open3d or meshio that has
        them, in the volume's world coordinates.
    volume : Volume, array_like or path
    isovalue : float
    error : float, optional
        The largest allowed two-sided distance; None: distances are only measured.
    unit : {"voxel", "world"}
        The unit of `error`: the smallest spacing, or that of coordinates.
    any_topology : bool, optional
        Compare distances only.
    min_component : float, optional
        Components with a shorter diagonal, in samples, were removed from the mesh.
    self_intersections : bool, optional
        Count self-intersecting triangles, exactly.
    inside_out : bool, optional
        Triangles face high values, as those of scikit-image do by default.
    allow_rounding : bool, optional
        Also allow for the rounding of 32-bit coordinates.
    lattice : int, optional
        Also allow for vertices at multiples of 2**-lattice grid steps. By default what a Mesh or a file of ours says.

    Returns
    -------
    Comparison

    Examples
    --------
    >>> import numpy as np, multitetra
    >>> x, y, z = np.mgrid[-1:1:33j, -1:1:33j, -1:1:33j]
    >>> ball = multitetra.Volume(1 - np.sqrt(x**2 + y**2 + z**2))
    >>> mesh = ball.isosurface(0.5, error=0.5)
    >>> bool(multitetra.certify(mesh, ball, 0.5, error=0.5))
    True
    >>> bool(multitetra.certify((mesh.vertices + 1, mesh.faces), ball, 0.5, error=0.5))
    False
    """
    if unit not in ("voxel", "world"):
        raise ValueError(f"unit is '{unit}'; it must be 'voxel' or 'world'.")
    for name, value, least in (("isovalue", isovalue, -np.inf), ("error", error, 0), ("min_component", min_component, 0)):
        if value is not None and not (np.isfinite(value) and value >= least):
            raise ValueError(f"{name} is {value}; it must be a finite number{', 0 or greater' if least == 0 else ''}.")
    if not isinstance(volume, Volume):
        volume = Volume(volume, threads=threads, progress=progress)
    name = "mesh"
    if isinstance(mesh, (str, os.PathLike)):
        name = os.fspath(mesh)
        use_reader()
        triangles = _engine.mesh_of_file(name)
    else:
        if lattice is None and isinstance(mesh, Mesh) and mesh.certificate:
            lattice = mesh.certificate.lattice
        vertices, faces = _vertices_and_faces(mesh)
        if isinstance(mesh, Mesh) and {mesh.space, volume.info.space or ""} == {"LPS", "RAS"}:
            vertices = vertices * [-1, -1, 1]
        triangles = _engine.mesh_of_arrays(vertices, faces, lattice)
    how = _engine.CertifyCall(
        float(isovalue), None if error is None else float(error), unit == "voxel", any_topology, self_intersections, inside_out,
        allow_rounding, min_component, lattice,
    )  # fmt: skip
    with _shown(progress) as report:
        text_of_report, text = _engine.certify(triangles, name, volume._volume, how, threads, report)
    found = json.loads(text_of_report)
    most = max(_number(found["distances"][way]["world"]["maximum_at_most"]) for way in ("mesh_to_full", "full_to_mesh"))
    return Comparison(
        kept=found["kept"], distance=most, proven=found["error"]["proven"] if error is not None else None,
        topology_kept=found["topology_kept"], watertight=found["watertight"], report=found, text=text,
    )  # fmt: skip


def _number(value):
    return float("inf") if value is None else value


def _vertices_and_faces(mesh):
    """The arrays of meshes of several libraries."""
    if hasattr(mesh, "points"):
        vertices, faces = _of_meshio(mesh) if isinstance(getattr(mesh, "cells", None), list) else _of_pyvista(mesh)
    elif hasattr(mesh, "vertices"):  # Ours, trimesh; open3d's faces are triangles.
        vertices, faces = mesh.vertices, mesh.faces if hasattr(mesh, "faces") else mesh.triangles
    else:
        vertices, faces = mesh[:2]
    faces = np.asarray(faces)
    if faces.dtype.kind not in "iu" and not (faces.dtype.kind == "f" and (faces == np.round(faces)).all()):
        raise TypeError(f"Faces are numbers of vertices; these are of type {faces.dtype}.")
    return np.asarray(vertices, float), faces.astype(np.int64)


def _of_meshio(mesh):
    parts = {}
    for block in mesh.cells:
        parts.setdefault(block.type, []).append(block.data)
    others = sorted(kind for kind in parts if kind not in ("triangle", "line", "vertex"))
    if others:
        raise ValueError(f"The mesh has cells of type {', '.join(others)}; make triangles of them first.")
    return mesh.points, np.concatenate(parts.get("triangle", [np.empty((0, 3), int)]))


def _of_pyvista(mesh):
    if not hasattr(mesh, "faces"):
        raise TypeError("Give a surface, such as mesh.extract_surface().")
    mesh = mesh.triangulate() if hasattr(mesh, "triangulate") else mesh
    return mesh.points, np.asarray(mesh.faces).reshape(-1, 4)[:, 1:]
