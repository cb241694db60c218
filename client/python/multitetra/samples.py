"""The samples themselves: on a plane, and at places."""

import numpy as np

from .v1 import conversation_pb2 as pb
from .v1 import request_pb2

AXES = "xyz"


def _coordinates(word):
    return request_pb2.CoordinateSystem.Value("COORDINATE_SYSTEM_" + word.upper())


def _layer(info, axis, at):
    """The samples across an axis, a pixel each: x or y to the right, y or z downwards."""
    axis = AXES.index(axis or "z")
    right, down = (other for other in range(3) if other != axis)
    unit = np.eye(3)
    at = (info.dims[axis] - 1) // 2 if at is None else at
    return {
        "origin": at * unit[axis],
        "right": unit[right],
        "down": unit[down],
        "width": info.dims[right],
        "height": info.dims[down],
        "coordinates": "index",
    }


def slice_message(info, axis, at, interpolation="linear", detail="auto", **plane):
    if plane and (axis is not None or at is not None):
        raise ValueError("A slice is named by axis and at, or by origin, right, down, width and height; not by both.")
    plane = {"coordinates": "world", **plane} if plane else _layer(info, axis, at)
    return pb.Slice(
        dataset=info.name,
        coordinates=_coordinates(plane["coordinates"]),
        origin=plane["origin"],
        right=plane["right"],
        down=plane["down"],
        width=plane["width"],
        height=plane["height"],
        interpolation=pb.Interpolation.Value("INTERPOLATION_" + interpolation.upper()),
        detail=pb.SliceDetail.Value("SLICE_DETAIL_" + detail.upper()),
    )


class SampledSlice:
    """`values`: (height, width) float32, NaN without a field; `sample_spacing`: 1, or 8 where every eighth sample was used."""

    def __init__(self, reply):
        if len(reply.values) != 4 * reply.width * reply.height:
            raise ValueError("The slice that came has other bytes than its pixels need.")
        self.values = np.frombuffer(reply.values, "<f4").reshape(reply.height, reply.width)
        self.sample_spacing = reply.sample_spacing


def probe_message(dataset, places, coordinates):
    places = np.asarray(places, float).reshape(-1, 3)
    return pb.Probe(dataset=dataset, coordinates=_coordinates(coordinates), places=places.ravel())


class ProbedPlace:
    """`world` and `index` (3,), `value` and `gradient` (3,) by world unit; the latter two None without a field."""

    def __init__(self, place):
        self.world = np.array(place.world)
        self.index = np.array(place.index)
        self.value = place.value if place.HasField("value") else None
        self.gradient = np.array(place.gradient) if place.HasField("value") else None
