"""What a surface request may be: the fields that command lines and HTTP have, as keywords."""

import ast
import inspect

from . import _client


class EmptySurfaceWarning(UserWarning):
    """The requested surface has no triangles."""


def default_of(text):
    """The default of a keyword, which the table of fields has as text, as a value of Python."""
    known = {"": None, "on": True, "off": False}
    if text in known:
        return known[text]
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):  # A name.
        return text


def takes_a_request(function, without=()):
    """Lets help() show what `**request` of a function may be: the fields of a request, from the table that options and HTTP have."""
    own = inspect.signature(function)
    named = [one for one in own.parameters.values() if one.kind is not one.VAR_KEYWORD]
    names = {one.name for one in named}
    grid = ("threshold_grid", "", "", "Errors at the samples of an array, as multitetra.grid() makes them")
    fields = [field for field in (grid, *_client.request_keywords()) if field[0] not in names.union(without)]
    function.__signature__ = own.replace(
        parameters=named
        + [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default_of(usual)) for name, _, usual, _ in fields]
    )
    lines = "".join(f"\n    {name} : {form or 'on|off'}\n        {help}" for name, form, _, help in fields)
    function.__doc__ = inspect.cleandoc(function.__doc__) + "\n\nOther Parameters\n----------------" + inspect.cleandoc(lines).join(("\n", ""))
    return function


def surface_request(isovalue, threshold_grid=None, **fields):
    """A request and what colors its surface."""
    return _client.surface_request(isovalue, threshold_grid, fields)
