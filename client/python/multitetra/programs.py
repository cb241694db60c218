"""`multitetra`, as a command of the wheel: the server that was packed with it, for `multitetra view FILE`."""

import os
import pathlib
import sys


def _found(name):
    """A file of the build: in the wheel, or in the build that the package is in. None if it was not built."""
    package = pathlib.Path(__file__).parent
    places = (package / "programs_of_build" / name, package.parent.parent / name)
    return next((place for place in places if place.exists()), None)


def server_program():
    """The path of multitetra-server, or None."""
    return _found("bin/multitetra-server")


def shared_file(name):
    """The path of a file beside the viewer, such as "widget/widget.js"."""
    file = _found(f"share/multitetra/{name}")
    if file is None:
        raise FileNotFoundError(f"This package was made from a build without {name}; build multitetra_viewer.")
    return file


def main():
    server = server_program()
    if server is None:
        sys.exit("This wheel was made from a build without the server; build multitetra_server_program and build the wheel again.")
    os.execv(server, ["multitetra", *sys.argv[1:]])
