"""Where a surface may end: at the border of the data, and nowhere else. As data_border in common/request/dataset_info.cpp."""

from dataclasses import dataclass

import numpy as np


@dataclass
class DataBorder:
    low: np.ndarray  # Corners of a box, in lattice coordinates.
    high: np.ndarray
    inset: int  # Lattice steps inside of its faces that are still the border.
    anywhere: bool  # The data has void samples: a surface may end at any of them.


def data_border(info, begin, resolution):
    """For a step of a dataset."""
    step = 1 << resolution
    anywhere = info.void_samples > 0
    if info.HasField("outside"):
        side = (1 << info.grid_exponent) * step
        return DataBorder(np.zeros(3, int), np.full(3, side), 0, anywhere)
    low = np.full(3, info.margin * step)
    high = low + (np.array(info.dims) - 1) * step
    longest = begin.finest_spacing or 1
    spacing = 1
    while spacing <= begin.request.topology_tolerance and spacing <= 1 << info.grid_exponent:
        longest = max(longest, 2 * spacing)
        spacing *= 2
    return DataBorder(low, high, (longest - 1) * step, anywhere)


def edges_inside(vertices, edges, border):
    """How many of the edges, pairs of vertex numbers, do not lie on the border with both ends."""
    if border.anywhere or len(edges) == 0:
        return 0
    ends = vertices[edges]  # Edge, end, axis.
    is_low = (ends <= border.low + border.inset).all(axis=1)
    is_high = (ends >= border.high - border.inset).all(axis=1)
    return int(np.count_nonzero(~(is_low | is_high).any(axis=1)))
