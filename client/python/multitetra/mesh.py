"""Tiles on the lattice, and the mesh that they weld to."""

import ctypes
import pathlib
from dataclasses import dataclass
from typing import Optional

import numpy as np


class DamagedTile(Exception):
    pass


class _Promised(ctypes.Structure):
    _fields_ = [
        ("cube_exponent", ctypes.c_uint32),
        ("cube_x", ctypes.c_uint32),
        ("cube_y", ctypes.c_uint32),
        ("cube_z", ctypes.c_uint32),
        ("digest_high", ctypes.c_uint64),
        ("digest_low", ctypes.c_uint64),
        ("triangles", ctypes.c_uint32),
        ("vertices", ctypes.c_uint32),
    ]


def _library():
    path = pathlib.Path(__file__).with_name("libmultitetra_tile.so")
    library = ctypes.CDLL(str(path))
    library.multitetra_decode_tile.argtypes = [
        ctypes.c_char_p,
        ctypes.c_size_t,
        ctypes.POINTER(_Promised),
        ctypes.c_int,
        ctypes.c_int,
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.c_char_p,
        ctypes.c_size_t,
    ]
    return library


_LIBRARY = _library()
MAX_TILE_TRIANGLES = 1 << 20


@dataclass
class LatticeTile:
    vertices: np.ndarray  # (n, 3) int32, lattice coordinates.
    faces: np.ndarray  # (m, 3) uint32
    normals: Optional[np.ndarray]  # (n, 3) float32, of length 1; None: not asked for.
    scalars: Optional[np.ndarray] = None  # (n,) float32, of the field that colours it; NaN for no value.


def decode_tile(payload, summary, resolution, normal_bits):
    """Decodes a tile and checks it against what the manifest promised; DamagedTile says what is wrong."""
    if not (1 <= summary.triangles <= MAX_TILE_TRIANGLES and 3 <= summary.vertices <= 3 * summary.triangles):
        raise DamagedTile("it promises counts that no tile has")
    promised = _Promised(*(getattr(summary, name) for name, _ in _Promised._fields_))
    vertices = np.empty((summary.vertices, 3), np.int32)
    faces = np.empty((summary.triangles, 3), np.uint32)
    normals = np.empty((summary.vertices, 3), np.float32) if normal_bits else None
    message = ctypes.create_string_buffer(512)
    failed = _LIBRARY.multitetra_decode_tile(
        payload,
        len(payload),
        ctypes.byref(promised),
        resolution,
        normal_bits,
        vertices.ctypes.data,
        faces.ctypes.data,
        normals.ctypes.data if normals is not None else None,
        message,
        len(message),
    )
    if failed:
        raise DamagedTile(message.value.decode("utf-8", "replace"))
    return LatticeTile(vertices, faces, normals)


def weld(tiles):
    """One tile of several: equal lattice points become one vertex."""
    if not tiles:
        return LatticeTile(np.empty((0, 3), np.int32), np.empty((0, 3), np.uint32), None)
    offsets = np.cumsum([0] + [len(tile.vertices) for tile in tiles[:-1]])
    corners = np.concatenate([tile.vertices for tile in tiles])
    # A lattice coordinate has at most 21 bits, so three of them are one integer, which sorts fast.
    keys = corners.astype(np.int64) @ np.array([1 << 42, 1 << 21, 1], np.int64)
    _, first, places = np.unique(keys, return_index=True, return_inverse=True)
    faces = np.concatenate([tile.faces + np.uint32(offset) for tile, offset in zip(tiles, offsets)])
    normals = None
    if all(tile.normals is not None for tile in tiles):
        normals = np.concatenate([tile.normals for tile in tiles])[first]
    scalars = None
    if all(tile.scalars is not None for tile in tiles):
        scalars = np.concatenate([tile.scalars for tile in tiles])[first]
    return LatticeTile(corners[first], places[faces].astype(np.uint32), normals, scalars)


def with_scalars(tile, codes, scale):
    """The tile with its values: a code for each vertex, in the order of their lattice coordinates (z, y, x)."""
    width = scale.bits // 8
    if len(codes) != width * len(tile.vertices):
        raise DamagedTile(f"it has {len(codes)} bytes of scalars for {len(tile.vertices)} vertices")
    numbers = np.frombuffer(codes, "<u1" if width == 1 else "<u2")
    x, y, z = tile.vertices.T
    values = np.empty(len(numbers), np.float32)
    none = 2**scale.bits - 1
    step = (scale.high - scale.low) / (none - 1)
    values[np.lexsort((x, y, z))] = np.where(numbers == none, np.nan, scale.low + numbers * step)
    return LatticeTile(tile.vertices, tile.faces, tile.normals, values)


@dataclass
class EdgeCounts:
    distinct: int
    nonmanifold: int  # Of more than two triangles, or of two that disagree on their outside.
    open: np.ndarray  # (n, 2), of one triangle: the border of the data, or cracks.


def count_edges(faces, vertices):
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    keys = directed[:, 0] * vertices + directed[:, 1]
    back = directed[:, 1] * vertices + directed[:, 0]
    is_open = ~np.isin(keys, back)
    unique, counts = np.unique(keys, return_counts=True)
    distinct = (len(unique) + np.count_nonzero(is_open)) // 2
    return EdgeCounts(int(distinct), int(np.count_nonzero(counts > 1)), directed[is_open])


@dataclass
class Mesh:
    """An isosurface in world coordinates. Triangles face the side of low values."""

    vertices: np.ndarray  # (n, 3) float64
    faces: np.ndarray  # (m, 3) uint32
    normals: Optional[np.ndarray] = None
    scalars: Optional[np.ndarray] = None  # (n,) float32, of the dataset of color_by; NaN where it has no value.

    def __iter__(self):
        """For `vertices, faces = mesh`."""
        return iter((self.vertices, self.faces))

    @property
    def euler_characteristic(self):
        edges = count_edges(self.faces, len(self.vertices)).distinct
        return len(self.vertices) - edges + len(self.faces)

    @property
    def area(self):
        """In square units of the world."""
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    @property
    def volume(self):
        """Of what the surface encloses, in cubic units of the world: where values are high, it is positive.

        ValueError where the surface has a border, as where it ends with the data: it encloses nothing then.
        """
        if len(count_edges(self.faces, len(self.vertices)).open):
            raise ValueError("The surface ends somewhere (where the data does), so it encloses no volume.")
        if len(self.faces) == 0:
            return 0.0
        # Near the origin the products lose least.
        a, b, c = (self.vertices[self.faces[:, i]] - self.vertices.mean(axis=0) for i in range(3))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    def components(self):
        """A Mesh for each connected component, the one with the most triangles first."""
        parents = np.arange(len(self.vertices))
        edges = np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]]]).astype(np.int64)
        while True:  # Each vertex takes the least number around it, then that one's.
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
        return Mesh(self.vertices[kept], faces.reshape(-1, 3).astype(np.uint32), *values)

    def to_pyvista(self):
        """A pyvista.PolyData, where pyvista is installed."""
        import pyvista

        cells = np.column_stack([np.full(len(self.faces), 3), self.faces]).ravel()
        mesh = pyvista.PolyData(self.vertices, cells)
        if self.scalars is not None:
            mesh["scalars"] = self.scalars
        return mesh


def positioned(tile, info, resolution):
    """In world coordinates: the data's own map, behind a shift by the margin."""
    columns = np.array(info.index_to_world, float).reshape(4, 3)
    index = tile.vertices / float(1 << resolution) - info.margin
    faces = tile.faces
    if np.linalg.det(columns[:3]) < 0:  # A map that mirrors turns triangles over.
        faces = faces[:, [0, 2, 1]]
    return Mesh(index @ columns[:3] + columns[3], faces, tile.normals, tile.scalars)
