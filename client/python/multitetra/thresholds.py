"""Errors that differ from place to place, in the form that --region and --view have on command lines."""

import re


def box(low, high, error):
    """An axis-parallel box with an error of its own."""
    return f"box:{numbers(*low, *high)}={numbers(error)}"


def ball(center, radius, error):
    """A ball with an error of its own."""
    return f"ball:{numbers(*center, radius)}={numbers(error)}"


def half_space(normal, offset, error):
    """The places x with normal . x >= offset, with an error of their own."""
    return f"halfspace:{numbers(*normal, offset)}={numbers(error)}"


def camera(eye, field_of_view, height_pixels, tolerance_pixels=1.0):
    """A screen-space error: `field_of_view` is vertical, in degrees."""
    return f"eye={numbers(*eye)},fov={numbers(field_of_view)},height={numbers(height_pixels)},pixels={numbers(tolerance_pixels)}"


def in_memory_order(text, axes):
    """Regions or a view in indices along the axes of an array, each of which is one of x, y, z in memory, as those along x, y, z."""
    if not isinstance(text, str):
        return [in_memory_order(one, axes) for one in text]

    def turned(match):
        values = match[2].split(",")
        return match[1] + ",".join(values[axes.index(axis)] for axis in range(3))

    three = "[^,=]+,[^,=]+,[^,=]+"
    text = re.sub(f"(box:|ball:|halfspace:|eye=|look=|up=)({three})", turned, text)
    return re.sub(f"(box:{three},)({three})", turned, text)


def numbers(*values):
    return ",".join(repr(float(value)) for value in values)
