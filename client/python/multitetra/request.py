"""Requests: an isovalue, and how large an error is allowed where."""

import numpy as np

from .v1 import request_pb2 as pb


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
    combination="in_order",
    coordinates="world",
    max_triangles=0,
    max_bytes=0,
    normal_bits=0,
    simplify=True,
):
    """The words are those of the command line; what is out of its range is refused by the server."""
    threshold = pb.ThresholdMap(
        everywhere=error,
        unit=pb.LengthUnit.Value("LENGTH_UNIT_" + unit.upper()),
        coordinates=pb.CoordinateSystem.Value("COORDINATE_SYSTEM_" + coordinates.upper()),
        regions=list(regions),
        view=view,
        grid=grid,
        combination=pb.Combination.Value("COMBINATION_" + combination.upper()),
    )
    return pb.IsosurfaceRequest(
        isovalue=isovalue,
        threshold=threshold,
        measure=pb.ErrorMeasure.Value("ERROR_MEASURE_" + bound.upper()),
        topology_rule=pb.TopologyRule.Value("TOPOLOGY_RULE_" + topology_rule.upper()),
        topology_tolerance=topology_tolerance,
        max_triangles=max_triangles,
        max_bytes=max_bytes,
        normal_bits=normal_bits,
        simplify=simplify,
    )
