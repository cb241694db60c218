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
    return LatticeTile(corners[first], places[faces].astype(np.uint32), normals)


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

    def __iter__(self):
        """For `vertices, faces = mesh`."""
        return iter((self.vertices, self.faces))

    @property
    def euler_characteristic(self):
        edges = count_edges(self.faces, len(self.vertices)).distinct
        return len(self.vertices) - edges + len(self.faces)

    def to_pyvista(self):
        """A pyvista.PolyData, where pyvista is installed."""
        import pyvista

        cells = np.column_stack([np.full(len(self.faces), 3), self.faces]).ravel()
        return pyvista.PolyData(self.vertices, cells)


def positioned(tile, info, resolution):
    """In world coordinates: the data's own map, behind a shift by the margin."""
    columns = np.array(info.index_to_world, float).reshape(4, 3)
    index = tile.vertices / float(1 << resolution) - info.margin
    faces = tile.faces
    if np.linalg.det(columns[:3]) < 0:  # A map that mirrors turns triangles over.
        faces = faces[:, [0, 2, 1]]
    return Mesh(index @ columns[:3] + columns[3], faces, tile.normals)
