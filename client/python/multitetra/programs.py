"""`multitetra`, as a command of the wheel: the server that was packed with it, for `multitetra view FILE`."""

import os
import pathlib
import sys


def main():
    server = pathlib.Path(__file__).with_name("programs_of_build") / "bin" / "multitetra-server"
    if not server.exists():
        sys.exit("This wheel was made from a build without the server; build multitetra_server_program and build the wheel again.")
    os.execv(server, ["multitetra", *sys.argv[1:]])
