"""Tests the ParaView source with a server, if ParaView is installed. Usage: paraview_test.py DIRECTORY_OF_PROGRAMS PACKAGE"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

PROJECT = pathlib.Path(__file__).resolve().parents[3]
PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
PACKAGE = str(pathlib.Path(sys.argv[2]).resolve())

SCRIPT = """
import sys
from paraview.simple import *
LoadPlugin(sys.argv[1], remote=False, ns=globals())
surface = MultiTetraIsosurface(Server=sys.argv[2], Dataset="gyroid", Isovalue=0.1, Error=0.25, Steps=1)
surface.UpdatePipeline()
first = surface.GetDataInformation()
surface.Steps = 20
surface.UpdatePipeline()
last = surface.GetDataInformation()
is_final = last.GetFieldDataInformation().GetArrayInformation("is final").GetComponentRange(0)[1]
print("RESULT", first.GetNumberOfCells(), last.GetNumberOfCells(), is_final, flush=True)
surface.Isovalue = 1e9
surface.UpdatePipeline()
print("EMPTY", surface.GetDataInformation().GetNumberOfCells(), flush=True)
"""


def main():
    if shutil.which("pvpython") is None:
        print("!! SKIPPED: ParaView's source is not tested: there is no pvpython.")
        return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run = lambda *words: subprocess.run(words, check=True, capture_output=True, cwd=folder)  # noqa: E731
        server_program = PROGRAMS / "multitetra-server"
        run(server_program, "generate", "gyroid", "--size", "129", "-o", "gyroid.nrrd", "--quiet")
        run(server_program, "prepare", "gyroid.nrrd", "-o", "gyroid.mtd", "--quiet")
        (folder / "script.py").write_text(SCRIPT)
        with open(folder / "log", "w") as log:
            server = subprocess.Popen(
                [server_program, "serve", "gyroid.mtd", "--tcp", "off", "--http", "127.0.0.1:0"], cwd=folder, stderr=log
            )
        try:
            for _ in range(200):
                lines = [line for line in (folder / "log").read_text().splitlines() if "listening on http://" in line]
                if lines:
                    break
                time.sleep(0.05)
            address = lines[0].split("http://")[1].strip()
            path = os.pathsep.join([PACKAGE, str(PROJECT / "client/paraview/debian12")])
            plugin = PROJECT / "client/paraview/multitetra_reader.py"
            output = subprocess.run(
                ["pvpython", folder / "script.py", plugin, f"ws://{address}"],
                env={**os.environ, "PYTHONPATH": path},
                capture_output=True,
                text=True,
                timeout=200,
            )
        finally:
            server.terminate()
            server.wait()
    lines = dict(line.split(" ", 1) for line in output.stdout.splitlines() if line.startswith(("RESULT", "EMPTY")))
    if "RESULT" not in lines or lines.get("EMPTY") != "0":
        print(output.stdout, output.stderr, sep="\n")
        return 1
    first, last, is_final = (float(word) for word in lines["RESULT"].split())
    print(f"{first:.0f} triangles, then {last:.0f}")
    return 0 if 0 < first <= last and is_final == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
