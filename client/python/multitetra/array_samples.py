"""Arrays of Python's libraries as samples in the world, read slab by slab."""

from __future__ import annotations

import bisect
import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass
class ArraySamples:
    """An array and where its samples lie: array[i, j, k] is at origin + [i, j, k] @ steps."""

    array: Any
    steps: np.ndarray  # (3, 3): the world step along each axis of the array.
    origin: np.ndarray
    space: str = ""  # "LPS", "RAS" or "", as in datasets.
    unit: str = ""
    value_unit: str = ""
    name: str = ""

    def __post_init__(self):
        if self.array.ndim != 3:
            raise ValueError(
                f"A volume has three axes; this array has {self.array.ndim}, of shape {tuple(self.array.shape)}. Select one time and one channel, such as array[0]."
            )
        self._axes = (2, 1, 0) if _is_fortran(self.array) else (0, 1, 2)  # Of slabs: the first is cut.
        self._is_masked = isinstance(getattr(self.array, "_meta", self.array), np.ma.MaskedArray)
        self.type = _sample_type(self.array.dtype, self._is_masked)
        self._slabs = _slabs_of(self.array, self._axes[0])

    @property
    def axes_in_memory(self):
        """Which of x, y, z, where x varies fastest, each axis of the array is."""
        return tuple(2 - self._axes.index(axis) for axis in range(3))

    def arguments(self):
        """What _engine.array_source() takes of it."""
        return {
            "fill": self._fill,
            "shape": [int(self.array.shape[axis]) for axis in self._axes],
            "type": {"f": "f", "i": "i", "u": "u"}[self.type.kind] + str(8 * self.type.itemsize),
            "steps": [list(map(float, self.steps[axis])) for axis in self._axes],
            "origin": list(map(float, self.origin)),
            "space": self.space,
            "unit": self.unit,
            "value_unit": self.value_unit,
        }

    def _fill(self, first, end, into):
        slab = self._slabs(first, end)
        if self._is_masked:
            slab = np.ma.filled(slab.astype(into.dtype), np.nan)
        np.copyto(into, np.asarray(slab).transpose(self._axes), casting="unsafe")


def samples_of(data, spacing=None, origin=None, affine=None, unit="") -> ArraySamples:
    """The samples of an array, or an image of xarray, nibabel, SimpleITK or ITK with its geometry."""
    if _is_of(data, "xarray"):
        return _of_xarray(data, spacing, origin, affine, unit)
    for is_one, read in ((_is_of(data, "nibabel"), _of_nibabel), (hasattr(data, "GetSpacing"), _of_itk)):
        if is_one:
            if spacing is not None or origin is not None or affine is not None:
                raise ValueError("This image states where its samples lie; give its array instead to place them otherwise.")
            return read(data, unit)
    if not (hasattr(data, "shape") and hasattr(data, "dtype")):
        data = np.asanyarray(data)
    return ArraySamples(data, *_placed(spacing, origin, affine), unit=unit)


def _placed(spacing, origin, affine):
    """The steps and the origin."""
    if affine is None:
        steps = np.broadcast_to(1.0 if spacing is None else np.asarray(spacing, float), 3)
        if not (np.isfinite(steps).all() and (steps > 0).all()):
            raise ValueError(f"spacing is {spacing}; the distances between samples are greater than 0.")
        return np.diag(steps), np.zeros(3) if origin is None else np.broadcast_to(np.asarray(origin, float), 3)
    if spacing is not None or origin is not None:
        raise ValueError("An affine has the spacing and the origin; give either.")
    affine = np.asarray(affine, float)
    if affine.shape not in ((3, 4), (4, 4)) or not np.isfinite(affine).all():
        raise ValueError(f"An affine is an array (4, 4) of finite numbers, from indices to the world; this one has shape {affine.shape}.")
    return affine[:3, :3].T, affine[:3, 3]


def _is_of(data, library):
    return type(data).__module__.split(".")[0] == library


# ---- libraries


def _of_xarray(data, spacing, origin, affine, unit):
    if not hasattr(data, "dims") or not hasattr(data, "coords") or hasattr(data, "data_vars"):
        raise TypeError("Give one array of a data set, such as data['temperature'].")
    if affine is None and spacing is None and origin is None and data.ndim == 3:
        axes = [_even_coordinate(data, dim) for dim in data.dims]
        steps, origin = np.diag([step for _, step in axes]), np.array([first for first, _ in axes])
        units = {str(data[dim].attrs.get("units", "")) for dim in data.dims}
        unit = unit or (units.pop() if len(units) == 1 else "")
    else:
        steps, origin = _placed(spacing, origin, affine)
    value_unit = str(data.attrs.get("units", ""))
    return ArraySamples(data.data, steps, origin, "", unit, value_unit, str(data.name or ""))


def _even_coordinate(data, dim):
    """The first coordinate along a dimension, and the step; (0, 1) without coordinates."""
    if dim not in data.coords or data.sizes[dim] < 2:
        return (0.0 if dim not in data.coords else float(data[dim][0])), 1.0
    places = np.asarray(data[dim].values)
    if not np.issubdtype(places.dtype, np.number):
        raise ValueError(f"The coordinate '{dim}' is not a length; give spacing.")
    step = (float(places[-1]) - float(places[0])) / (len(places) - 1)
    even = places[0] + step * np.arange(len(places))
    if step == 0 or not np.allclose(places, even, rtol=0, atol=1e-3 * abs(step)):
        raise ValueError(f"The coordinate '{dim}' is uneven; interpolate the data to even steps, or give spacing.")
    return float(places[0]), step


def _of_nibabel(image, unit):
    stored = image.dataobj
    if getattr(stored, "is_proxy", False):
        file = str(getattr(stored, "file_like", ""))
        # Seeking in a packed file unpacks it from the beginning.
        stored = np.asanyarray(stored) if file.endswith((".gz", ".bz2", ".zst", ".mgz")) else _NibabelProxy(stored)
    steps, origin = _placed(None, None, image.affine)
    if not unit and hasattr(image.header, "get_xyzt_units"):
        known = {"mm": "mm", "meter": "m", "micron": "µm"}
        unit = known.get(image.header.get_xyzt_units()[0], "")
    return ArraySamples(stored, steps, origin, "RAS", unit)


class _NibabelProxy:
    """Samples in a file, with the type that reading gives them."""

    def __init__(self, proxy):
        self._proxy, self.shape, self.ndim = proxy, proxy.shape, len(proxy.shape)
        self.dtype = np.asanyarray(proxy[(slice(0, 1),) * self.ndim]).dtype
        self.is_fortran = True

    def __getitem__(self, index):
        return np.asanyarray(self._proxy[index])


def _of_itk(image, unit):
    """Images of SimpleITK and ITK: indices are x, y, z; arrays have z first."""
    if image.GetNumberOfComponentsPerPixel() != 1:
        raise ValueError(f"Samples of this image have {image.GetNumberOfComponentsPerPixel()} components; select one.")
    if _is_of(image, "SimpleITK"):
        import SimpleITK

        array = SimpleITK.GetArrayViewFromImage(image)
        direction = np.array(image.GetDirection())
    else:
        import itk

        array = itk.array_view_from_image(image)
        direction = itk.array_from_matrix(image.GetDirection())
    spacing = np.array([image.GetSpacing()[axis] for axis in range(array.ndim)])
    origin = np.array([image.GetOrigin()[axis] for axis in range(array.ndim)])
    if array.ndim != 3:
        raise ValueError(f"A volume has three axes; this image has {array.ndim}.")
    along_x_y_z = (np.reshape(direction, (3, 3)) * spacing).T
    return ArraySamples(array, along_x_y_z[::-1], origin, "LPS", unit or "mm")


# ---- samples


def _is_fortran(array):
    """Whether the first axis varies fastest in memory or in the file."""
    strides = getattr(array, "strides", None)
    return getattr(array, "is_fortran", False) or (strides is not None and abs(strides[0]) < abs(strides[-1]))


def _sample_type(dtype, is_masked):
    """The type in which samples are passed on, in which masked ones are NaN."""
    dtype = np.dtype(dtype)
    if dtype.kind == "b":
        dtype = np.dtype(np.uint8)
    if dtype.kind not in "iuf":
        raise TypeError(f"Samples of type {dtype} are no real numbers.")
    if dtype.kind == "f":
        return np.dtype(np.float32 if dtype.itemsize <= 4 else np.float64)
    if is_masked:
        return np.dtype(np.float32 if dtype.itemsize <= 2 else np.float64)
    return dtype.newbyteorder("=")


def _slabs_of(array, axis):
    """A function (first, end) that returns these indices along an axis."""

    def whole(first, end):
        return _part(array, axis, first, end)

    chunks = getattr(array, "chunks", None)
    if isinstance(array, np.ndarray) or not chunks:
        return whole
    along = chunks[axis]  # A size, as of Zarr and HDF5, or the sizes of all, as of dask.
    side = array.shape[axis]
    ends = [0, *itertools.accumulate(along)] if isinstance(along, tuple) else [*range(0, side, along), side]
    return _ChunkedSlabs(whole, axis, ends)


def _part(array, axis, first, end):
    index = [slice(None)] * 3
    index[axis] = slice(first, end)
    return array[tuple(index)]


class _ChunkedSlabs:
    """Reads each layer of chunks once, and keeps the last one."""

    def __init__(self, read, axis, ends):
        self._read, self._axis, self._ends = read, axis, ends
        self._layer, self._kept = None, None

    def __call__(self, first, end):
        parts = []
        while first < end:
            layer = bisect.bisect_right(self._ends, first) - 1
            begin, stop = self._ends[layer], min(end, self._ends[layer + 1])
            if self._layer != layer:
                self._layer, self._kept = None, None
                kept = self._read(begin, self._ends[layer + 1])
                self._layer, self._kept = layer, kept.compute() if hasattr(kept, "compute") else kept
            parts.append(_part(self._kept, self._axis, first - begin, stop - begin))
            first = stop
        return parts[0] if len(parts) == 1 else np.ma.concatenate(parts, self._axis) if self._is_masked else np.concatenate(parts, self._axis)

    @property
    def _is_masked(self):
        return isinstance(self._kept, np.ma.MaskedArray)
