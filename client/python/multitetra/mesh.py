"""Surfaces as arrays."""

import os
from dataclasses import dataclass
from typing import Optional

import numpy as np

from . import _client


def _edges(mesh):
    """How many distinct edges there are, and how many have one triangle only."""
    faces = mesh.faces.astype(np.int64)
    begin, end = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).T
    count = len(mesh.vertices)
    distinct, times = np.unique(np.minimum(begin, end) * count + np.maximum(begin, end), return_counts=True)
    return len(distinct), np.count_nonzero(times == 1)


def _bends(mesh):
    """The sums of length times bending angle over edges of two triangles: around high values, and around low ones."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    faces = mesh.faces.astype(np.int64)
    begin, end, opposite = np.concatenate([faces, faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]]).T
    edge = np.minimum(begin, end) * len(mesh.vertices) + np.maximum(begin, end)
    order = np.argsort(edge, kind="stable")
    is_pair = np.flatnonzero(edge[order][1:] == edge[order][:-1])
    first, second = order[is_pair], order[is_pair + 1]
    here, there = normals[first % len(faces)], normals[second % len(faces)]
    angles = np.arctan2(np.linalg.norm(np.cross(here, there), axis=1), np.einsum("ij,ij->i", here, there))
    start = mesh.vertices[begin[first]]
    bends = angles * np.linalg.norm(mesh.vertices[end[first]] - start, axis=1)
    is_convex = np.einsum("ij,ij->i", here, mesh.vertices[opposite[second]] - start) < 0
    return bends[is_convex].sum(), bends[~is_convex].sum()


@dataclass(frozen=True)
class Certificate:
    """What is certain of a surface: it was computed with it, and checked on the mesh.

    `multitetra.certify` measures the same for any mesh.

    Attributes
    ----------
    error_bound : float or None
        Bounds the two-sided distance to the full-resolution surface, in world units, rounding included. None: nothing bounds it.
    topology_kept : bool
        Whether components, holes and handles are those of the full-resolution surface.
    euler_characteristic, components : int
    border_edges : int
        Edges of one triangle; all of them lie where the data ends.
    open_edges, nonmanifold_edges, degenerate_triangles : int
        Faults. Always 0, as meshes with any are refused.
    self_intersecting_triangles : int or None
        None: not counted. 0 with `intersection_free`.
    lattice : int
        Vertices are at multiples of 2**-lattice steps of the grid.
    content_digest : str
        The digest of all triangles, as in the reports of programs.
    """

    error_bound: Optional[float]
    topology_kept: bool
    euler_characteristic: int
    components: int
    border_edges: int
    open_edges: int
    nonmanifold_edges: int
    degenerate_triangles: int
    self_intersecting_triangles: Optional[int]
    lattice: int
    content_digest: str

    @property
    def is_watertight(self) -> bool:
        """Whether every edge has two triangles: the surface ends nowhere."""
        return self.border_edges == self.open_edges == self.nonmanifold_edges == 0


@dataclass(eq=False)
class Mesh:
    """An isosurface in world coordinates. Triangles face the side of low values."""

    vertices: np.ndarray  # (n, 3) float64
    faces: np.ndarray  # (m, 3) uint32
    normals: Optional[np.ndarray] = None
    scalars: Optional[np.ndarray] = None  # (n,) float32, the values of the color_by dataset; NaN where it has none.
    error_bound: Optional[float] = None  # Bounds the distance to the full-resolution surface, rounding included; None: no bound.
    is_full_resolution: bool = False  # Whether this is the full-resolution surface, as at error 0, but for the rounding of vertices (`lattice`).
    certificate: Optional[Certificate] = None  # None: the mesh is a part of a surface, or was made otherwise.
    unit: str = ""  # Of its coordinates, such as "mm"; empty: unknown.
    space: str = ""  # Their axes: "LPS", "RAS" or those of the volume.

    def __repr__(self):
        within = "" if self.error_bound is None else f", within {self.error_bound:.3g}"
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.faces)} triangles{within}>"

    def __iter__(self):
        """Permits `vertices, faces = mesh`."""
        return iter((self.vertices, self.faces))

    @property
    def euler_characteristic(self):
        return len(self.vertices) - _edges(self)[0] + len(self.faces)

    @property
    def bounds(self):
        """(2, 3): the smallest and the largest coordinates of its vertices; NaN without vertices."""
        if len(self.vertices) == 0:
            return np.full((2, 3), np.nan)
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def area(self):
        """The area of this mesh in square world units. If `is_full_resolution` is false, the area of the full-resolution surface differs, and no distance bounds the difference.

        If it is true, the area differs by the rounding of vertices alone: at `lattice` 5 by some thousandths, at 8 by less.
        """
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    @property
    def volume(self):
        """The volume that the surface encloses, in cubic world units: positive around high values.

        Raises ValueError if the surface has a border, such as where it ends with the data: it then encloses no volume.
        """
        if _edges(self)[1]:
            raise ValueError("The surface is open at the border of the data and does not enclose a volume; `prepare` with --pad-value VALUE --pad 1 closes it.")
        if len(self.faces) == 0:
            return 0.0
        # Centering reduces rounding errors.
        a, b, c = (self.vertices[self.faces[:, i]] - self.vertices.mean(axis=0) for i in range(3))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    @property
    def volume_bound(self):
        """How far `volume` may be from that of the full-resolution surface, unless this mesh intersects itself. None without a bound.

        All points between the two surfaces lie within error_bound of this one, which has area, edges and vertices (the tube formula
        of Steiner and Weyl). A simplified surface encloses too little where it is convex: its vertices lie on the full-resolution one.
        """
        if self.error_bound is None:
            return None
        d, bend = self.error_bound, max(_bends(self))
        return d * (self.area + d * (bend / 2 + d * 2 * np.pi / 3 * len(self.vertices)))

    def components(self):
        """A Mesh for each connected component, the one with the most triangles first."""
        parents = np.arange(len(self.vertices))
        edges = np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]]]).astype(np.int64)
        while True:  # Each vertex takes the smallest number of its neighbors, then that vertex's number.
            least = parents.copy()
            np.minimum.at(least, edges[:, 0], parents[edges[:, 1]])
            np.minimum.at(least, edges[:, 1], parents[edges[:, 0]])
            least = least[least]
            if np.array_equal(least, parents):
                break
            parents = least
        of_face = parents[self.faces[:, 0]]
        names, counts = np.unique(of_face, return_counts=True)
        return [self._part(of_face == name) for name in names[np.argsort(-counts, kind="stable")]]

    def _part(self, is_in):
        kept, faces = np.unique(self.faces[is_in], return_inverse=True)
        values = [None if one is None else one[kept] for one in (self.normals, self.scalars)]
        return Mesh(self.vertices[kept], faces.reshape(-1, 3).astype(np.uint32), *values, self.error_bound, self.is_full_resolution, None, self.unit, self.space)

    def save(self, path):
        """Writes a .ply, .stl, .obj, .glb, .3mf, .drc or .vtp file, in world coordinates; .glb and .3mf files have their unit.

        Coordinates have 64 bits where 32 would move a vertex by more than a hundredth of the shortest edge. STL and Draco files have 32:
        ValueError if these are too coarse; subtract a corner of `bounds` from `vertices` first.
        """
        lattice = self.certificate.lattice if self.certificate else None
        _client.save_mesh(os.path.expanduser(path), self.vertices, self.faces, self.normals, self.scalars, self.unit, self.space, lattice)

    def to_pyvista(self):
        """A pyvista.PolyData; requires pyvista."""
        import pyvista

        cells = np.column_stack([np.full(len(self.faces), 3), self.faces]).ravel()
        mesh = pyvista.PolyData(self.vertices, cells)
        if self.scalars is not None:
            mesh["scalars"] = self.scalars
        return mesh
