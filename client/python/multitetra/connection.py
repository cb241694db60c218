"""A connection with a server: lists, samples, and surfaces step by step."""

import warnings

import numpy as np

from . import _client
from .addresses import stream_address
from .requests import EmptySurfaceWarning, surface_request, takes_a_request
from .samples import SampleArray


def connect(url, token="", ca=None, insecure=False, timeout=60.0):
    """Connects to http://HOST:PORT, the address of the viewer, or ws://, wss://, tcp://, tls://.

    `ca` is a PEM file to trust instead of the system's.
    """
    return Connection(_client.Connection(stream_address(url), token or "", ca or "", insecure, timeout))


class Connection:
    """One request at a time: another one ends a stream that runs. Tiles are kept for later requests, and not sent again.

    Lost connections are replaced, and streams continue where they were.
    """

    def __init__(self, client):
        self._client = client

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._client.close()

    def datasets(self):
        """A DatasetInfo for each dataset: name, shape (along x, y, z), spacing, affine, unit, min, max, suggested_isovalues and so on."""
        return self._client.datasets()

    def series(self, name):
        """The DatasetInfo of a series' members (times, fields, labels), by field, time and label.

        What each is among them is in its `member`: field, time (or None) and time_unit, label (or None).
        """
        members = [info for info in self.datasets() if info.member and info.member.series == name]
        return sorted(members, key=lambda info: (info.member.field, info.member.time or 0, _label_value(info.member)))

    @takes_a_request
    def isosurface(self, dataset, isovalue, **request):
        """The surface without previews: a Mesh. With color_by, its `scalars` are the values of that dataset."""
        *_, step = self._steps(dataset, *self._request(dataset, isovalue, **request), True, 0)
        return step.mesh

    @takes_a_request
    def isosurfaces(self, dataset, isovalues, **request):
        """Several surfaces of a dataset: a Mesh for each isovalue. A budget is shared by all of them."""
        requests = [self._request(dataset, one, **request) for one in isovalues]
        shares = self._client.share_budget(dataset, [one for one, _ in requests])
        meshes = []
        for share, (_, scalars) in zip(shares, requests):
            *_, step = self._steps(dataset, share, scalars, True, 0)
            meshes.append(step.mesh)
        return meshes

    @takes_a_request
    def steps(self, dataset, isovalue, final_only=False, display=False, drawable_triangles=12_000_000, **request):
        """Yields Steps, coarse first; the last one is the surface as it was requested.

        display: the meshes are drawn and not kept, so the last one may be the full-resolution surface within the error,
            with more triangles, where that comes sooner
        drawable_triangles: at most so many then
        """
        use = drawable_triangles if display else 0
        yield from self._steps(dataset, *self._request(dataset, isovalue, **request), final_only, use)

    @takes_a_request
    def estimate(self, dataset, isovalue, **request):
        """The estimated size of the surface: an Estimate."""
        self._client.info(dataset)
        return self._client.estimate(dataset, surface_request(isovalue, **request)[0])

    def slice(self, dataset, axis=None, at=None, interpolation="linear", detail="auto", **plane):
        """The samples on a plane: a SampledSlice, whose `values` are an array (height, width), NaN without a field.

        axis, at: the layer of samples across x, y or z with that index (default: the middle one across z), a pixel each
        or origin, right, down, width, height: the middle of the first pixel, the steps to the next one of its row and
            column, and how many there are; coordinates: world or index
        interpolation: nearest or linear; detail: auto, full (all samples) or coarse (every eighth)
        """
        info = self._client.info(dataset)
        if plane and (axis is not None or at is not None):
            raise ValueError("Specify a slice by axis and at, or by origin, right, down, width and height, not by both.")
        plane = {"coordinates": "world", **plane} if plane else _layer(info, axis, at)
        names = ("coordinates", "origin", "right", "down", "width", "height")
        if unknown := [name for name in plane if name not in names]:
            raise TypeError(f"A slice has no keyword {', '.join(unknown)}.")
        if absent := [name for name in names if name not in plane]:
            raise TypeError(f"A slice by origin needs {', '.join(absent)} as well.")
        words = [plane[name] for name in names]
        return self._client.slice(dataset, *words, interpolation, detail)

    def samples(self, dataset, box=None):
        """The samples with indices in `box`, ((x, end), (y, end), (z, end)), all of them by default: an array by x, y, z.

        float32, NaN where there is no field. `array` fetches only what is indexed.
        """
        array = self.array(dataset)
        return array[:] if box is None else array[tuple(slice(*ends) for ends in box)]

    def array(self, dataset):
        """The samples as a SampleArray, for dask, napari, or indexing: samples are fetched when it is indexed."""
        return SampleArray(self, self._client.info(dataset))

    def probe(self, dataset, places, coordinates="world"):
        """The field at places (n, 3): a ProbedPlace for each, with world, index, value and gradient."""
        self._client.info(dataset)
        if np.size(places) == 0:
            return []
        places = np.atleast_2d(np.asarray(places, float))
        if places.ndim != 2 or places.shape[1] != 3:
            raise ValueError(f"Places are an array (n, 3), a row each; these have shape {places.shape}.")
        return self._client.probe(dataset, places, coordinates)

    def _request(self, dataset, isovalue, **request):
        """Returns surface_request(). Raises ValueError for colors of another world, unless color_anyway permits them."""
        wanted, scalars = surface_request(isovalue, **request)
        if scalars is not None:
            _client.check_same_world(scalars, self._client.info(dataset), self._client.info(request["color_by"]))
        return wanted, scalars

    def _steps(self, dataset, request, scalars, final_only, drawable_triangles):
        stream = self._client.open(dataset, request, final_only, drawable_triangles, scalars)
        try:
            while (step := self._client.next(stream)) is not None:
                if step.is_final and step.empty_text:
                    warnings.warn(step.empty_text, EmptySurfaceWarning, stacklevel=3)  # Warns at the caller of the public method.
                yield step
        finally:
            self._client.leave(stream)


def _label_value(member):
    return member.label.value if member.label else 0


def _layer(info, axis, at):
    """The samples across an axis, a pixel each: x or y to the right, y or z downwards."""
    axis = "z" if axis is None else axis
    if axis not in ("x", "y", "z"):
        raise ValueError(f"axis is {axis!r}; it must be 'x', 'y' or 'z'.")
    axis = "xyz".index(axis)
    right, down = (other for other in range(3) if other != axis)
    unit = np.eye(3)
    at = (info.dims[axis] - 1) // 2 if at is None else at
    if not 0 <= at <= info.dims[axis] - 1:
        raise IndexError(f"at is {at}; axis {'xyz'[axis]} has the layers 0 to {info.dims[axis] - 1}.")
    return {"coordinates": "index", "origin": at * unit[axis], "right": unit[right], "down": unit[down],
            "width": info.dims[right], "height": info.dims[down]}  # fmt: skip
