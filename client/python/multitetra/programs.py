"""`multitetra`, as a command of the wheel: the server that was packed with it, for `multitetra view FILE`."""

import os
import pathlib
import sys


def server_program():
    """The path of multitetra-server: in the wheel, or in the build that the package is in. None if it was not built."""
    package = pathlib.Path(__file__).parent
    places = (package / "programs_of_build" / "bin", package.parent.parent / "bin")
    return next((place / "multitetra-server" for place in places if (place / "multitetra-server").exists()), None)


def main():
    server = server_program()
    if server is None:
        sys.exit("This wheel was made from a build without the server; build multitetra_server_program and build the wheel again.")
    os.execv(server, ["multitetra", *sys.argv[1:]])
