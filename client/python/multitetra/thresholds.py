"""Errors that differ from place to place, in the form that --region and --view have on command lines."""


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


def numbers(*values):
    return ",".join(repr(float(value)) for value in values)
