"""Surfaces of arrays and files in this process, without a server."""

from __future__ import annotations

import operator
import os
import re
import warnings
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Optional, Sequence, Union, overload

import numpy as np

from . import _engine
from .array_samples import samples_of, three_coordinates, three_steps
from .mesh import Mesh
from .programs import server_program
from .requests import EmptySurfaceWarning, surface_request, takes_a_request
from .thresholds import in_memory_order

VolumeError = _engine.VolumeError
Progress = Union[None, bool, Callable[[str, float], None]]
_NOT_HERE = ("color_by", "color_range", "color_anyway")  # Of datasets of a server.


class VolumeWarning(UserWarning):
    """What a volume does not state, or loses by the conversion of its samples."""


@dataclass
class Step:
    """One complete mesh of a surface that is refined step by step.

    Attributes
    ----------
    mesh : Mesh
    spacing : int
        1, or the distance in samples between those that a preview uses. A preview has no error bound.
    is_final : bool
        Whether this is the surface as it was requested.
    """

    mesh: Mesh
    spacing: int
    is_final: bool


class Volume:
    """The samples of an array or a file, in memory, for surfaces of any isovalue.

    Parameters
    ----------
    data : array_like or path
        An array of numbers with three axes: NumPy (any order of bytes and axes, masked, memory-mapped), dask, Zarr, HDF5, or an image
        of xarray, nibabel, SimpleITK, ITK, VTK or PyVista, whose geometry is used. Or the path or address of a volume of any format that
        ``multitetra-server formats`` lists, or of a prepared dataset (.mtd). Masked, NaN and infinite samples are void: surfaces end there.
    spacing : float or (3,) array_like, optional
        World units between samples along each axis of the array; 1 by default. Of a file along x, y, z: replaces what it states.
    origin : (3,) array_like, optional
        World coordinates of the first sample.
    affine : (4, 4) array_like, optional
        Maps indices of the array to the world, instead of spacing and origin. Its axes are at right angles.
    unit : str, optional
        The unit of spacing and coordinates, such as "mm".
    pad_value : float, optional
        The value beyond the data, which closes surfaces there. By default they end at the last samples.
    pad : int, optional
        Layers of that value around the data; 1 by default.
    name : str, optional
    threads : int, optional
        The most threads of a call; 0: as many as there are processors.
    progress : callable or bool, optional
        Called with (stage, fraction of the stage) while a call runs; True: a bar of tqdm.
    subtract : float, optional
        Subtracted from all samples in double precision: keeps small differences between large values of 64-bit types.
    allow_loss : bool, optional
        Accept samples that lose more than a hundredth of their range as 32-bit floats.
    **reading
        Of a file, as options of ``multitetra-server prepare``: array, level, time, channel, series, component, resample, orient, space.

    Notes
    -----
    Holds a copy of the samples with at most 32 bits each. For arrays that are larger than the memory see `prepare`.

    Examples
    --------
    >>> import numpy as np, multitetra
    >>> x, y, z = np.mgrid[-1:1:33j, -1:1:33j, -1:1:33j]
    >>> ball = multitetra.Volume(1 - np.sqrt(x**2 + y**2 + z**2), spacing=0.5, unit="mm")
    >>> ball
    <Volume array: shape (33, 33, 33), spacing (0.5, 0.5, 0.5) mm, values -0.73205 to 1>
    >>> inner, outer = ball.isosurface([0.5, 0.25], error=0.1)
    >>> inner.certificate.components, inner.certificate.is_watertight
    (1, True)
    """

    def __init__(
        self, data: Any, *, spacing: Any = None, origin: Any = None, affine: Any = None, unit: str = "", pad_value: Optional[float] = None,
        pad: Optional[int] = None, name: Optional[str] = None, threads: int = 0, progress: Progress = None, subtract: float = 0,
        allow_loss: bool = False, **reading: Any,
    ):  # fmt: skip
        self._threads, self._progress = threads, progress
        place = _path_of(data)
        if place is not None and _is_dataset(place):
            given = {"spacing": spacing, "origin": origin, "affine": affine, "unit": unit, "pad_value": pad_value, "pad": pad, "name": name,
                     "subtract": subtract or None, "allow_loss": allow_loss or None, **reading}  # fmt: skip
            _require_none(given, "A prepared dataset states this itself")
            self._volume, self._axes = _engine.open(place), (0, 1, 2)
            self._place = place  # Where servers find it, too.
            return
        with _shown(progress) as report:
            source, self._axes = _source(data, spacing, origin, affine, unit, name, subtract, allow_loss, reading)
            self._volume = _engine.load(source, _call(pad_value, pad, threads, report))
        _warn(source.notices)

    def __repr__(self) -> str:
        info, spacing = self.info, tuple(float(f"{step:.6g}") for step in self.spacing)
        unit = f" {info.unit}" if info.unit else ""
        values = repr(info)[:-1].rpartition(", ")[2]  # As many digits as they differ in.
        return f"<Volume {info.name}: shape {self.shape}, spacing {spacing}{unit}, {values}>"

    @property
    def shape(self) -> tuple[int, int, int]:
        """Samples along the axes of the array; of a file along x, y, z."""
        return tuple(self.info.shape[axis] for axis in self._axes)

    @property
    def spacing(self) -> tuple[float, float, float]:
        """World units between samples along these axes."""
        return tuple(self.info.spacing[axis] for axis in self._axes)

    @property
    def info(self):
        """Its DatasetInfo: name, min, max, histogram, suggested_isovalues and so on; what it has along x, y, z is in the order of memory."""
        return self._volume.info

    @overload
    def isosurface(self, isovalue: float, **request: Any) -> Mesh: ...
    @overload
    def isosurface(self, isovalue: Sequence[float], **request: Any) -> list[Mesh]: ...
    def isosurface(self, isovalue, **request):
        """The surface of an isovalue, or a list with those of several, which share a budget.

        Parameters
        ----------
        isovalue : float or sequence of float

        Returns
        -------
        Mesh or list of Mesh
            Vertices are in the order of the array's axes, times spacing; in a file's world coordinates they are x, y, z. The
            `certificate` of a mesh says how far it is at most from the full-resolution surface.

        Warns
        -----
        EmptySurfaceWarning
        """
        if np.ndim(isovalue) == 0:
            return self._made(self._request(isovalue, request))
        requests = [self._request(one, request) for one in isovalue]
        return [self._made(one) for one in self._volume.share_budget(requests)]

    def steps(self, isovalue: float, **request: Any) -> Iterator[Step]:
        """Yields Steps, coarse first; the last one is the surface as it was requested.

        Parameters
        ----------
        isovalue : float

        Yields
        ------
        Step
        """
        steps = self._volume.steps(self._request(isovalue, request), self._threads)
        while True:
            with _shown(self._progress) as report:
                made = steps.next(report)
            if made is None:
                return
            mesh, empty_text, spacing, is_final = made
            if is_final:
                _warn_of_empty(empty_text)
            yield Step(mesh, spacing, is_final)

    def estimate(self, isovalue: float, **request: Any) -> int:
        """The estimated number of triangles of a surface.

        Parameters
        ----------
        isovalue : float

        Returns
        -------
        int
        """
        return self._volume.estimate(self._request(isovalue, request))[0]

    def _request(self, isovalue, request):
        unknown = set(request).intersection(_NOT_HERE)
        if unknown:
            raise TypeError(f"{', '.join(sorted(unknown))}: a surface in this process has no colors; a server's has.")
        if request.get("region_coordinates") == "index":
            for name in ("regions", "view"):
                if request.get(name):
                    request = {**request, name: in_memory_order(request[name], self._axes)}
        return surface_request(float(isovalue), **request)[0]

    def _made(self, request):
        with _shown(self._progress) as report:
            mesh, empty_text, _, _ = self._volume.isosurface(request, self._threads, report)
        _warn(self._volume.notices(request) if not empty_text else [])
        _warn_of_empty(empty_text)
        return mesh


for _method in (Volume.isosurface, Volume.steps, Volume.estimate):
    takes_a_request(_method, without=_NOT_HERE)


def isosurface(
    data: Any, isovalue: float, *, spacing: Any = None, origin: Any = None, affine: Any = None, length_unit: str = "",
    pad_value: Optional[float] = None, pad: Optional[int] = None, threads: int = 0, progress: Progress = None, **request: Any,
) -> Mesh:  # fmt: skip
    """The certified isosurface of an array or a file.

    Parameters
    ----------
    data : array_like or path
    isovalue : float or sequence of float
    spacing, origin, affine, pad_value, pad, threads, progress
        As of `Volume`, which is quicker for several calls. Its `unit` is `length_unit` here.

    Returns
    -------
    Mesh or list of Mesh
        As of `Volume.isosurface`.

    Examples
    --------
    >>> import numpy as np, multitetra
    >>> x, y, z = np.mgrid[-1:1:33j, -1:1:33j, -1:1:33j]
    >>> mesh = multitetra.isosurface(x**2 + y**2 + z**2, 0.5, error=0.5, spacing=(0.7, 0.7, 1.0))
    >>> mesh.vertices.shape[1], mesh.faces.dtype, round(mesh.certificate.error_bound, 2)
    (3, dtype('uint32'), 0.39)
    """
    volume = Volume(
        data, spacing=spacing, origin=origin, affine=affine, unit=length_unit, pad_value=pad_value, pad=pad, threads=threads, progress=progress
    )
    return volume.isosurface(isovalue, **request)


takes_a_request(isosurface, without=_NOT_HERE)


def prepare(
    data: Any, output: Any, *, spacing: Any = None, origin: Any = None, affine: Any = None, unit: str = "", pad_value: Optional[float] = None,
    pad: Optional[int] = None, name: Optional[str] = None, samples_only: bool = False, threads: int = 0, progress: Progress = None,
    subtract: float = 0, allow_loss: bool = False, **reading: Any,
) -> str:  # fmt: skip
    """Writes a prepared dataset (.mtd), for `Volume`, servers and programs, in memory that does not grow with the data.

    Parameters
    ----------
    data : array_like or path
    output : path
        A file, which appears complete or not at all.
    samples_only : bool, optional
        Leave out the errors for all isovalues, which take most of the time and make estimates and previews better.
    spacing, origin, affine, unit, pad_value, pad, name, threads, progress, subtract, allow_loss, **reading
        As of `Volume`.

    Returns
    -------
    str
        The path of the file.
    """
    output = _path_of(os.fspath(output))
    with _shown(progress) as report:
        source, _ = _source(data, spacing, origin, affine, unit, name, subtract, allow_loss, reading)
        _engine.prepare(source, output, samples_only, _call(pad_value, pad, threads, report))
    _warn(source.notices)
    return output


# ---- sources


def _path_of(data):
    """Its path or address; None for arrays."""
    if isinstance(data, (str, os.PathLike)):
        place = os.fspath(data)
        return os.path.expanduser(place) if "://" not in place else place
    return None


def _is_dataset(place):
    if place.endswith(".mtd"):
        return True
    try:
        with open(place, "rb") as file:
            return file.read(8) == b"\x89MTD1\r\n\x1a"
    except OSError:  # Its reader says why.
        return False


def _source(data, spacing, origin, affine, unit, name, subtract, allow_loss, reading):
    """The engine's source, and which of its axes x, y, z those of the data are."""
    place = _path_of(data)
    if place is None:
        _require_none(reading, "An array has no such choice")
        samples = samples_of(data, spacing, origin, affine, unit)
        name = name or samples.name or "array"
        _warn([samples.notice] if samples.notice else [])
        return _engine.array_source(name=name, subtract=float(subtract), allow_loss=bool(allow_loss), **samples.arguments()), samples.axes_in_memory
    known = ("array", "level", "time", "channel", "series", "component", "resample", "orient", "space")
    unknown = sorted(set(reading).difference(known))
    if unknown:
        raise TypeError(f"A volume has no keyword {', '.join(unknown)}.")
    if affine is not None:
        raise ValueError("A file has spacing, origin and orient instead of an affine.")
    options = {**reading, "unit": unit or None, "subtract": float(subtract), "allow_loss": bool(allow_loss)}
    if spacing is not None:
        options["spacing"] = three_steps(spacing).tolist()
    if origin is not None:
        options["origin"] = three_coordinates(origin).tolist()
    use_reader()
    options = {key: value for key, value in options.items() if value is not None}
    return _engine.file_source(place, name or "", options), (0, 1, 2)


def use_reader():
    """Lets the engine read files in processes of the server's program, in a sandbox."""
    program = server_program()
    if program is None:
        raise VolumeError("Files are read by multitetra-server, which this package lacks: build multitetra_server_program. Arrays need no server.")
    _engine.use_sandbox_program(str(program))


def _require_none(given, why):
    names = [name for name, value in given.items() if value is not None and value != ""]
    if names:
        raise TypeError(f"{why}: {', '.join(names)}.")


def _call(pad_value, pad, threads, report):
    if pad is None:
        pad = 0 if pad_value is None else 1
    return _engine.Call(None if pad_value is None else float(pad_value), operator.index(pad), operator.index(threads), report)


# ---- progress and warnings


class _shown:
    """What a call reports to: a function, a bar of tqdm, or None."""

    def __init__(self, progress):
        self._wanted, self._bar = progress, None

    def __enter__(self):
        if self._wanted is None or self._wanted is False:
            return None
        if self._wanted is not True:
            return self._wanted
        from tqdm.auto import tqdm

        self._bar = tqdm(total=100, unit="%", leave=False)
        return self._report

    def __exit__(self, *_):
        if self._bar is not None:
            self._bar.close()

    def _report(self, stage, fraction):
        self._bar.set_description(stage, refresh=False)
        self._bar.n = round(100 * fraction)
        self._bar.refresh()


def _warn(texts):
    for text in texts:
        loss = re.search(r"become f32, (?:exactly|.*\((\S+) % of )", text)
        if loss and float(loss[1] or 0) < 1e-4:
            continue  # What any array of 32-bit floats has lost.
        warnings.warn(text, VolumeWarning, stacklevel=_outside())


def _warn_of_empty(text):
    if text:
        warnings.warn(text, EmptySurfaceWarning, stacklevel=_outside())


def _outside():
    """The number of frames from a caller from the caller of `_warn` that are of this package, for warnings at the user's line."""
    import sys

    frame, level = sys._getframe(2), 2
    while frame is not None and frame.f_globals.get("__name__", "").startswith("multitetra."):
        frame, level = frame.f_back, level + 1
    return level
