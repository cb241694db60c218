"""A volume larger than memory would like: a noisy head, written slab by slab, its first pass, and surfaces of it.

    /usr/bin/python3 tests/bench/large.py --programs build/release/bin              1024^3: some minutes, 5 GB of disk
    /usr/bin/python3 tests/bench/large.py --programs build/release/bin --size 2048  half an hour, 30 GB

Each row is a process: its seconds, CPU seconds of all threads, and the most memory it had, apart from the pages of the dataset,
which the system can take back. The dataset has no errors yet, as when `serve head.nrrd` has read the file. The last row of these is
an error of a pixel in a picture of 1080 lines that shows the whole head.

Then the steps of a stream at error 0.5 to a client that keeps no mesh and draws 60 million triangles: seconds from the request
to checked arrays in Python (in the folder python beside that of the programs), of a stream after another; the server's memory.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time

ISOVALUE = 500.5


class Peak(threading.Thread):
    """The most memory of a process without a file behind it, in MiB, looked at twenty times a second."""

    def __init__(self, process):
        super().__init__(daemon=True)
        self.status, self.mebibytes = pathlib.Path(f"/proc/{process}/status"), 0
        self.start()

    def run(self):
        try:
            while found := re.search(r"RssAnon:\s+(\d+)", self.status.read_text()):
                self.mebibytes = max(self.mebibytes, int(found[1]) / 1024)
                time.sleep(0.05)
        except OSError:
            pass  # It has ended.


def row(name, *command):
    began = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    peak = Peak(process.pid)
    output = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{name} failed with exit code {process.returncode}: {' '.join(map(str, command))}")
    report = json.loads(output)
    triangles = f"{report['triangles']:,}" if "triangles" in report else ""
    print(f"| {name} | {time.monotonic() - began:.1f} | {used.ru_utime + used.ru_stime:.1f} | {peak.mebibytes:.0f} | {triangles} |", flush=True)


def drawn(server, dataset, log):
    sys.path.insert(0, str(server.parent.parent / "python"))
    import multitetra

    with open(log, "w") as errors:
        serving = subprocess.Popen([server, "serve", dataset, "--tcp", "127.0.0.1:0", "--http", "off"], stderr=errors)
    peak = Peak(serving.pid)
    while not (address := re.search(r"listening on (tcp://[0-9.:]+)", log.read_text())):
        time.sleep(0.05)
    with multitetra.connect(address[1]) as connection:
        name = connection.datasets()[0].name
        for is_measured, isovalue in enumerate((ISOVALUE + 1, ISOVALUE)):
            began = time.monotonic()
            for step in connection.steps(name, isovalue, error=0.5, display=True, drawable_triangles=60_000_000):
                kind, triangles = "certified" if step.is_final else "preview", len(step.mesh.faces)
                if is_measured:
                    print(f"| {kind}, {step.payload_bytes / 1e6:.2f} MB | {time.monotonic() - began:.2f} | | {peak.mebibytes:.0f} | {triangles:,} |", flush=True)
    serving.terminate()
    serving.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, required=True, help="folder of multitetra-server")
    parser.add_argument("--size", type=int, default=1024, help="samples a side")
    arguments = parser.parse_args()
    server, size = arguments.programs / "multitetra-server", arguments.size
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        volume, dataset = folder / "head.nrrd", folder / "head.mtd"
        print(f"| noisy head, {size}^3 | seconds | CPU seconds | peak MiB | triangles |\n| --- | ---: | ---: | ---: | ---: |")
        row("generate", server, "generate", "head", "--size", str(size), "--noise", "20", "-o", volume, "--json")
        row("first pass", server, "prepare", volume, "--samples-only", "-o", dataset, "--json")
        volume.unlink()
        middle = (size - 1) / 2
        view = f"eye={middle},{middle - 1.6 * size},{middle},fov=40,height=1080,pixels=1"
        for what, *options in (("error 0.5", "--error", "0.5"), ("error 1", "--error", "1"), ("error 4", "--error", "4"),
                               ("one pixel of the whole", "--view", view)):
            row(what, server, "extract", dataset, "--isovalue", str(ISOVALUE), *options, "-o", folder / "head.ply", "--json")
        drawn(server, dataset, folder / "log")


if __name__ == "__main__":
    main()
