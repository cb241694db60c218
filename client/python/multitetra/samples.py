"""The samples of a dataset as an array that is fetched where it is indexed."""

import numpy as np

_MOST_PIXELS = 1 << 21  # The protocol's limit for one slice.


class SampleArray:
    """Indexed like an array of NumPy, by x, y, z: `array[i, j, k]` lies at `info.affine @ [i, j, k, 1]`.

    Nothing is kept. For dask and napari: `dask.array.from_array(array, chunks=(128, 128, 128), lock=True)`.
    """

    dtype = np.dtype(np.float32)
    ndim = 3

    def __init__(self, connection, info):
        self._connection = connection
        self.info = info
        self.shape = info.shape

    def __repr__(self):
        return f"<SampleArray of {self.info!r}>"

    def __array__(self, dtype=None, copy=None):
        whole = self[:]
        return whole if dtype is None else whole.astype(dtype)

    def __getitem__(self, index):
        index = index if isinstance(index, tuple) else (index,)
        if Ellipsis in index:
            at = index.index(Ellipsis)
            index = index[:at] + (slice(None),) * (self.ndim - len(index) + 1) + index[at + 1 :]
        if len(index) > self.ndim:
            raise IndexError(f"{len(index)} indices were given; the axes are x, y and z.")
        index += (slice(None),) * (self.ndim - len(index))
        ranges = [self._range(one, axis) for axis, one in enumerate(index)]
        values = self._samples(*ranges)
        return values[tuple(0 if isinstance(one, (int, np.integer)) else slice(None) for one in index)]

    def _range(self, one, axis):
        side = self.shape[axis]
        if isinstance(one, slice):
            return range(*one.indices(side))
        if not isinstance(one, (int, np.integer)):
            raise TypeError("Samples are indexed by integers and slices.")
        if not -side <= one < side:
            raise IndexError(f"{one} is not an index of axis {'xyz'[axis]}, which has {side} samples.")
        return range(one % side, one % side + 1)

    def _samples(self, xs, ys, zs):
        """The samples at the product of three ranges."""
        if not (xs and ys and zs):
            return np.empty((len(xs), len(ys), len(zs)), self.dtype)
        x, y = min(xs), min(ys)
        width, height = max(xs) + 1 - x, max(ys) + 1 - y
        rows = max(1, _MOST_PIXELS // width)  # Per request.
        values = np.empty((width, height, len(zs)), self.dtype)
        for layer, z in enumerate(zs):
            for first in range(0, height, rows):
                count = min(rows, height - first)
                part = self._connection.slice(
                    self.info.name, coordinates="index", origin=(x, y + first, z), right=(1, 0, 0), down=(0, 1, 0),
                    width=width, height=count, interpolation="nearest", detail="full",
                )  # fmt: skip
                values[:, first : first + count, layer] = part.values.T
        return values[np.ix_([i - x for i in xs], [j - y for j in ys])]
