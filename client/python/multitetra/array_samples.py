"""Arrays of Python's libraries as samples in the world, read slab by slab."""

from __future__ import annotations

import bisect
import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _engine
from .samples import SampleArray


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
    notice: str = ""  # What of the geometry is not used.

    def __post_init__(self):
        if self.array.ndim != 3:
            raise ValueError(
                f"A volume has three axes; this array has {self.array.ndim}, of shape {tuple(self.array.shape)}. Select one time and one channel, such as array[0]."
            )
        self._axes = (2, 1, 0) if _is_fortran(self.array) else (0, 1, 2)  # Of slabs: the first is cut.
        reach = np.abs(self.origin).max() + np.abs(self.steps).sum() * max(self.array.shape, default=1)
        if not reach * 2.0**-52 < 2.0**-10 * np.linalg.norm(self.steps, axis=1).min():
            raise ValueError("The origin is so far away that 64-bit coordinates cannot tell neighbouring samples apart; give one that is nearer.")
        # What reading gives: libraries unpack or mask what is stored with another type.
        one = getattr(self.array, "_meta", self.array)
        if not isinstance(one, np.ndarray):
            one = np.asanyarray(self.array[(slice(0, 1),) * 3])
        self.type = _sample_type(one.dtype, isinstance(one, np.ma.MaskedArray))
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
        is_float = into.dtype.kind == "f"
        if isinstance(slab, np.ma.MaskedArray) and (is_float or np.ma.is_masked(slab)):
            if not is_float:
                raise TypeError(f"Some samples are masked, but the array says that they are {self.type}; give it as floating-point numbers.")
            slab = np.ma.filled(slab.astype(into.dtype), np.nan)
        slab = np.asarray(slab)
        if not (np.can_cast(slab.dtype, into.dtype) or (is_float and slab.dtype.kind == "f")):
            raise TypeError(f"The array says that its samples are {self.type}, but reading gives {slab.dtype}.")
        np.copyto(into, slab.transpose(self._axes), casting="unsafe")


def samples_of(data, spacing=None, origin=None, affine=None, unit="") -> ArraySamples:
    """The samples of an array, or an image of xarray, nibabel, SimpleITK, ITK or VTK with its geometry."""
    if _is_of(data, "xarray"):
        return _of_xarray(data, spacing, origin, affine, unit)
    libraries = (
        (hasattr(data, "get_fdata"), _of_nibabel),
        (hasattr(data, "GetPointData") and hasattr(data, "GetSpacing"), _of_vtk),
        (hasattr(data, "GetSpacing"), _of_itk),
    )
    for is_one, read in libraries:
        if is_one:
            if spacing is not None or origin is not None or affine is not None:
                raise ValueError("This image states where its samples lie; give its array instead to place them otherwise.")
            return read(data, unit)
    if isinstance(data, SampleArray):
        info = data.info
        steps, origin = _placed(spacing, origin, info.affine if spacing is None and origin is None and affine is None else affine)
        return ArraySamples(data, steps, origin, info.space or "", unit or info.unit or "", info.value_unit or "", info.name)
    if not (hasattr(data, "shape") and hasattr(data, "dtype")):
        has_masks = isinstance(data, (list, tuple)) and any(isinstance(one, np.ma.MaskedArray) for one in data)
        array = np.ma.stack(data) if has_masks else np.asanyarray(data)
        if array.dtype.kind == "O":
            raise TypeError(f"Give an array of numbers or an image, not a {type(data).__name__}.")
        data = array
    return ArraySamples(data, *_placed(spacing, origin, affine), unit=unit)


def _placed(spacing, origin, affine):
    """The steps and the origin."""
    if affine is None:
        return np.diag(three_steps(1.0 if spacing is None else spacing)), three_coordinates(0.0 if origin is None else origin)
    if spacing is not None or origin is not None:
        raise ValueError("An affine has the spacing and the origin; give either.")
    affine = np.asarray(affine, float)
    if affine.shape not in ((3, 4), (4, 4)) or not np.isfinite(affine).all():
        raise ValueError(f"An affine is an array (4, 4) of finite numbers, from indices to the world; this one has shape {affine.shape}.")
    if affine.shape == (4, 4) and not np.allclose(affine[3], (0, 0, 0, 1), rtol=0, atol=1e-9):
        raise ValueError(f"The last row of an affine is 0, 0, 0, 1; this one has {affine[3].tolist()}. Is it transposed?")
    steps = affine[:3, :3].T
    lengths = three_steps(np.linalg.norm(steps, axis=1), "affine has steps of")
    if abs(np.linalg.det(steps / lengths[:, None])) < 1e-6:
        raise ValueError("Two axes of the affine have the same direction, or one lies in the plane of the others.")
    return steps, affine[:3, 3]


def three_steps(spacing, what="spacing is"):
    """The distances between samples along three axes."""
    steps = np.broadcast_to(np.asarray(spacing, float), 3)
    if not ((1e-30 < steps) & (steps < 1e30)).all():
        raise ValueError(f"{what} {spacing}; the distances between samples are greater than 0, and neither tiny nor huge.")
    return steps


def three_coordinates(origin):
    """The place of the first sample."""
    origin = np.broadcast_to(np.asarray(origin, float), 3)
    if not np.isfinite(origin).all():
        raise ValueError(f"origin is {origin.tolist()}; coordinates are finite.")
    return origin


def _is_of(data, library):
    return type(data).__module__.split(".")[0] == library


# ---- libraries


def _of_xarray(data, spacing, origin, affine, unit):
    if not hasattr(data, "dims") or not hasattr(data, "coords") or hasattr(data, "data_vars"):
        raise TypeError("Give one array of a data set, such as data['temperature'].")
    if affine is None and data.ndim == 3:  # Where coordinates are not given otherwise.
        if spacing is None:
            axes = [_even_coordinate(data, dim) for dim in data.dims]
            steps, first = [step for _, step in axes], [place for place, _ in axes]
        else:
            ends = [_ends_of_coordinate(data, dim) for dim in data.dims]
            steps = [-step if end < begin else step for step, (begin, end) in zip(three_steps(spacing), ends)]
            first = [begin for begin, _ in ends]
        notice = ""
        if not unit:
            unit, factors, notice = _common_unit([str(data[dim].attrs.get("units", "")) if dim in data.coords else "" for dim in data.dims])
            first = np.multiply(first, factors)
            steps = np.multiply(steps, factors) if spacing is None else steps
        steps, origin = np.diag(steps), three_coordinates(first if origin is None else origin)
    else:
        (steps, origin), notice = _placed(spacing, origin, affine), ""
    value_unit = str(data.attrs.get("units", ""))
    value_unit = value_unit if len(value_unit.encode()) <= 64 else ""
    return ArraySamples(data.data, steps, origin, "", unit, value_unit, str(data.name or ""), notice)


def _common_unit(units):
    """The first unit of three axes, factors that convert lengths along each to it, and what is wrong."""
    common = next((unit for unit in units if unit), "")
    factors = []
    for unit in units:
        factor = 1.0 if unit in ("", common) else _engine.length_factor(unit, common)
        if factor is None:
            return "", [1.0] * 3, f"The axes have no common unit ('{common}' and '{unit}'), so none is used; give it with unit."
        factors.append(factor)
    return common, factors, ""


def _even_coordinate(data, dim):
    """The first coordinate along a dimension, and the step; (0, 1) without coordinates."""
    begin, end = _ends_of_coordinate(data, dim)
    if dim not in data.coords or data.sizes[dim] < 2:
        return begin, 1.0
    places = np.asarray(data[dim].values)
    if not np.issubdtype(places.dtype, np.number):
        raise ValueError(f"The coordinate '{dim}' is not a length; give spacing.")
    step = (end - begin) / (len(places) - 1)
    even = places[0] + step * np.arange(len(places))
    if step == 0 or not np.allclose(places, even, rtol=0, atol=1e-3 * abs(step)):
        raise ValueError(f"The coordinate '{dim}' is uneven; interpolate the data to even steps, or give spacing.")
    return begin, step


def _ends_of_coordinate(data, dim):
    """The coordinates of the first and the last sample along a dimension; (0, 0) if they are no numbers."""
    if dim not in data.coords or not np.issubdtype(data[dim].dtype, np.number) or data.sizes[dim] == 0:
        return 0.0, 0.0
    return float(data[dim][0]), float(data[dim][-1])


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
    """Samples in a file."""

    def __init__(self, proxy):
        self._proxy, self.shape, self.ndim = proxy, proxy.shape, len(proxy.shape)
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


def _of_vtk(image, unit):
    """Images of VTK and PyVista: the active scalars of their points; arrays have z first."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    scalars = image.GetPointData().GetScalars()
    if scalars is None:
        raise ValueError("This image has no active scalars at its points; choose them, such as image.set_active_scalars(name).")
    if scalars.GetNumberOfComponents() != 1:
        raise ValueError(f"Samples of this image have {scalars.GetNumberOfComponents()} components; select one.")
    array = vtk_to_numpy(scalars).reshape(image.GetDimensions()[::-1])
    direction = np.array([[image.GetDirectionMatrix().GetElement(row, column) for column in range(3)] for row in range(3)])
    steps = (direction * image.GetSpacing()).T
    origin = np.array(image.GetOrigin()) + np.array(image.GetExtent()[::2]) @ steps
    return ArraySamples(array, steps[::-1], origin, "", unit)


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
