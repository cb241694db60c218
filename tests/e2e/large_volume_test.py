"""Prepares a volume of 16385 x 1025 x 1025 samples, the longest possible side, in bounded memory, and extracts a surface.

    large_volume_test.py FOLDER-OF-PROGRAMS [FOLDER-TO-WORK-IN]

Takes half an hour and 40 GB of disk, so it runs only if MULTITETRA_ALL_TESTS is set, and exits with 77 otherwise.
The field is a wave along x with a period of 8192 samples and a phase that varies with y and z: four sheets at half height.
"""

import json
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

DIMS = (16385, 1025, 1025)
PERIOD = 8192
SHEETS = 4
NEEDED_BYTES = 40 * 10**9
MOST_MEMORY = 1.5 * 2**30


def skip(reason):
    print(f"!! {reason}: the longest volume is NOT TESTED.", file=sys.stderr)
    sys.exit(77)


def write_volume(path):
    half = PERIOD // 2
    wave = bytes(254 * (i if i <= half else PERIOD - i) // half for i in range(PERIOD))
    rows = wave * (DIMS[0] // PERIOD + 3)
    across = [round(60 * math.sin(2 * math.pi * i / 700)) for i in range(DIMS[1])]
    with open(path, "wb") as file:
        file.write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: %d %d %d\nencoding: raw\n\n" % DIMS)
        for z in range(DIMS[2]):
            begins = [PERIOD // 2 + across[y] + across[z] // 2 for y in range(DIMS[1])]
            file.write(b"".join(rows[begin : begin + DIMS[0]] for begin in begins))


def run(*command):
    began = time.time()
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout), time.time() - began


def main():
    if not os.environ.get("MULTITETRA_ALL_TESTS"):
        skip("MULTITETRA_ALL_TESTS is not set (tests/run.sh --all)")
    programs = pathlib.Path(sys.argv[1])
    parent = sys.argv[2] if len(sys.argv) > 2 else None
    if shutil.disk_usage(parent or tempfile.gettempdir()).free < NEEDED_BYTES:
        skip(f"there is less than {NEEDED_BYTES / 1e9:.0f} GB of disk")
    with tempfile.TemporaryDirectory(dir=parent) as work:
        work = pathlib.Path(work)
        volume = work / "long.nrrd"
        write_volume(volume)
        print("written", flush=True)
        dataset = work / "long.mtd"
        report, seconds = run(programs / "multitetra-server", "prepare", volume, "-o", dataset, "--json", "--quiet")
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024
        print(f"prepared in {seconds:.0f} s with {peak / 2**20:.0f} MiB: {report['file_bytes']} bytes", flush=True)
        assert report["dataset"]["dims"] == list(DIMS), report["dataset"]["dims"]
        assert report["dataset"]["grid_exponent"] == 14
        assert peak < MOST_MEMORY, peak
        volume.unlink()

        log = work / "server.log"
        server = subprocess.Popen(
            [programs / "multitetra-server", "serve", dataset, "--tcp", "127.0.0.1:0", "--http", "127.0.0.1:0"],
            stdout=log.open("w"), stderr=subprocess.STDOUT)
        try:
            url = None
            while not url:
                assert server.poll() is None, log.read_text()
                time.sleep(0.2)
                url = re.search(r"listening on (tcp://\S+)", log.read_text())
            report, seconds = run(
                programs / "multitetra-client", "fetch", "--server", url.group(1), "--isovalue", "127.5", "--error", "2",
                "--coordinates", "index", "--timeout", "600", "--previews", "-o", work / "long.ply", "--json", "--quiet")
            first, final = report["steps"][0], report["steps"][-1]
            status = pathlib.Path(f"/proc/{server.pid}/status").read_text()
            print(f"first step after {first['seconds']:.2f} s, all after {seconds:.1f} s: {final['triangles']} triangles; "
                  f"server {re.search(r'VmHWM: *(.*)', status).group(1)}", flush=True)
        finally:
            server.terminate()
            server.wait()
        assert "topology_preserved" in final["checks"], final["checks"]
        assert final["components"] == SHEETS, final["components"]
        assert final["euler_characteristic"] == SHEETS, final["euler_characteristic"]
        assert final["open_edges"] == 0 and final["nonmanifold_edges"] == 0


if __name__ == "__main__":
    main()
