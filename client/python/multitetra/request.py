"""Requests: an isovalue, and how large an error is allowed where."""

import inspect

import numpy as np

from .v1 import conversation_pb2 as conversation_pb
from .v1 import request_pb2 as pb


COMBINATIONS = {"order": pb.COMBINATION_IN_ORDER, "minimum": pb.COMBINATION_MINIMUM}


def box(low, high, error):
    """An axis-parallel box with an error of its own."""
    return pb.ThresholdRegion(threshold=error, box=pb.BoxShape(low=list(low), high=list(high)))


def ball(centre, radius, error):
    """A ball with an error of its own."""
    return pb.ThresholdRegion(threshold=error, ball=pb.BallShape(centre=list(centre), radius=radius))


def half_space(normal, offset, error):
    """The places x with normal . x >= offset, with an error of their own."""
    return pb.ThresholdRegion(threshold=error, half_space=pb.HalfSpaceShape(normal=list(normal), offset=offset))


def view(eye, field_of_view, height_pixels, tolerance_pixels=1.0):
    """Errors that look the same on a screen: `field_of_view` is vertical, in degrees."""
    return pb.ThresholdView(
        eye=list(eye), field_of_view=field_of_view, height_pixels=height_pixels, tolerance_pixels=tolerance_pixels
    )


def grid(thresholds, spacing=(1, 1, 1), origin=(0, 0, 0)):
    """Errors at the samples of an array (x, y, z), each for the voxel around it; NaN says nothing there."""
    thresholds = np.asarray(thresholds, np.float32)
    columns = np.vstack([np.diag(np.asarray(spacing, float)), np.asarray(origin, float)])
    return pb.ThresholdGrid(
        dims=thresholds.shape, index_to_world=columns.ravel(), thresholds=thresholds.ravel(order="F")
    )


def isosurface_request(
    isovalue,
    error=0.25,
    unit="voxel",
    bound="certified",
    topology_rule="exact",
    topology_tolerance=0.0,
    regions=(),
    view=None,
    grid=None,
    combine="order",
    region_unit="world",
    max_triangles=0,
    max_bytes=0,
    normals=0,
    simplify=True,
):
    """A request for the surface at `isovalue`. What is out of its range is refused by the server.

    error: the largest distance from the full surface, in `unit` (voxel or world); 0 is the full resolution
    bound: certified, or paper (which the real distance may exceed)
    topology_rule: exact or paper; topology_tolerance: features up to this many voxels may vanish
    regions, view, grid: other errors elsewhere (box, ball, half_space, view, grid of this module); combine: order
        or minimum; region_unit: of the coordinates of regions and view, world or index
    max_triangles, max_bytes: a budget, 0 for none; normals: bits of each coordinate, 8 to 10, 0 for none
    simplify: a few of the triangles, within the same errors
    """
    threshold = pb.ThresholdMap(
        everywhere=error,
        unit=pb.LengthUnit.Value("LENGTH_UNIT_" + unit.upper()),
        coordinates=pb.CoordinateSystem.Value("COORDINATE_SYSTEM_" + region_unit.upper()),
        regions=list(regions),
        view=view,
        grid=grid,
        combination=COMBINATIONS[combine],
    )
    return pb.IsosurfaceRequest(
        isovalue=isovalue,
        threshold=threshold,
        measure=pb.ErrorMeasure.Value("ERROR_MEASURE_" + bound.upper()),
        topology_rule=pb.TopologyRule.Value("TOPOLOGY_RULE_" + topology_rule.upper()),
        topology_tolerance=topology_tolerance,
        max_triangles=max_triangles,
        max_bytes=max_bytes,
        normal_bits=normals,
        simplify=simplify,
    )


def scalar_request(dataset, limits):
    """What colours a surface: the values of a dataset; None: nothing."""
    if dataset is None:
        if limits is not None:
            raise ValueError("color_range needs color_by, whose values it is of.")
        return None
    low, high = limits if limits is not None else (None, None)
    return conversation_pb.ScalarRequest(dataset=dataset, low=low, high=high)


def takes_a_request(method):
    """Lets help() show what `**request` of a method may be: the arguments of isosurface_request."""
    own = inspect.signature(method)
    named = [one for one in own.parameters.values() if one.kind is not one.VAR_KEYWORD]
    asked = [
        one.replace(kind=one.KEYWORD_ONLY)
        for one in inspect.signature(isosurface_request).parameters.values()
        if one.name != "isovalue"
    ]
    method.__signature__ = own.replace(parameters=named + asked)
    method.__doc__ += "\n\n        " + isosurface_request.__doc__.split("\n\n", 1)[1].strip().replace("\n", "\n    ")
    return method
