"""Debian 12's ParaView 5.11 was written for a Python that has inspect.getargspec; with 3.11 no plugin in Python loads."""

import inspect

if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec
