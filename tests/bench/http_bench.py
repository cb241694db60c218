"""Measures HTTP answers a second, and the time of one large mesh.

    python3 tests/bench/http_bench.py PROGRAM [--volume FILE.mtd] [--seconds 5] [--json FILE]

PROGRAM is a multitetra-server; older ones will do, as only HTTP is spoken. Without a volume a noisy head of 256 samples a side is generated
and prepared. Run it with nothing else on the machine, and compare two programs in turn. Requests a second and their median are
measured over kept-alive connections from one thread of this process (wrk in its place where it is installed).
"""
import argparse
import http.client
import json
import pathlib
import re
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time


def free_port():
    with socket.socket() as it:
        it.bind(("127.0.0.1", 0))
        return it.getsockname()[1]


class Server:
    def __init__(self, program, dataset):
        self.port = free_port()
        self.process = subprocess.Popen(
            [program, "serve", str(dataset), "--tcp", "off", "--http", f"http://127.0.0.1:{self.port}", "--log-level", "error",
             "--max-requests-per-second", "0"], stderr=subprocess.DEVNULL)
        deadline = time.time() + 60
        while True:
            try:
                self.get("/livez")
                return
            except OSError:
                if time.time() > deadline or self.process.poll() is not None:
                    raise SystemExit("The server does not answer.")
                time.sleep(0.05)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()

    def get(self, path):
        connection = http.client.HTTPConnection("127.0.0.1", self.port)
        connection.request("GET", path)
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        if answer.status != 200:
            raise SystemExit(f"{path}: {answer.status} {body[:300]}")
        return answer, body

    def peak_mebibytes(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024


def rate(server, path, seconds):
    """Requests a second and the median of their milliseconds, one connection."""
    if shutil.which("wrk"):
        text = subprocess.run(["wrk", "-t1", "-c1", f"-d{seconds}", "--latency", f"http://127.0.0.1:{server.port}{path}"],
                              capture_output=True, text=True, check=True).stdout
        value, unit = re.search(r"50%\s+([\d.]+)(us|ms|s)", text).groups()
        return float(re.search(r"Requests/sec:\s+([\d.]+)", text)[1]), float(value) * {"us": 1e-3, "ms": 1, "s": 1e3}[unit]
    connection = http.client.HTTPConnection("127.0.0.1", server.port)
    times = []
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        before = time.perf_counter()
        connection.request("GET", path)
        connection.getresponse().read()
        times.append(time.perf_counter() - before)
    return len(times) / sum(times), 1e3 * statistics.median(times)


def first_tile(server, dataset, isovalue):
    root = f"/v1/3dtiles/{dataset}/iso/{isovalue}/"
    tileset = json.loads(server.get(root + "tileset.json")[1])
    return root + tileset["root"]["content"]["uri"]


def large_mesh(program, volume, dataset, isovalue):
    """The seconds of the first answer of about a million triangles, from a server that has made nothing yet."""
    path = f"/v1/datasets/{dataset}/isosurface?isovalue={isovalue}&error=0&simplify=off&max_triangles=1000000&format=glb"
    with Server(program, volume) as server:
        before_peak = server.peak_mebibytes()
        before = time.perf_counter()
        answer, body = server.get(path)
        return {"seconds": time.perf_counter() - before, "triangles": int(answer.getheader("Multitetra-Triangles")),
                "digest": answer.getheader("Multitetra-Content-Digest"), "mebibytes": len(body) / 2**20,
                "peak_mebibytes": server.peak_mebibytes(), "idle_mebibytes": before_peak}


def measure(program, volume, seconds):
    with Server(program, volume) as server:
        dataset = json.loads(server.get("/v1/datasets")[1])["datasets"][0]
        name, isovalue = dataset["name"], dataset["suggested_isovalues"][0]
        tile = first_tile(server, name, isovalue)
        small = f"/v1/datasets/{name}/isosurface?isovalue={isovalue}&max_triangles=5000&format=glb"
        figures = {}
        for what, path in (("cached tile", tile), ("small GLB, kept", small)):
            size = len(server.get(path)[1])
            per_second, median = rate(server, path, seconds)
            figures[what] = {"requests_per_second": per_second, "median_ms": median, "bytes": size}
        times, peak = [], None
        for i in range(20):  # A different file each time, so that nothing is cached.
            before = time.perf_counter()
            server.get(f"/v1/datasets/{name}/isosurface?isovalue={isovalue + i * 1e-3}&error=8&topology_tolerance=8&format=glb")
            times.append(time.perf_counter() - before)
        figures["small GLB, made"] = {"requests_per_second": len(times) / sum(times), "median_ms": 1e3 * statistics.median(times)}
    figures["large GLB, made"] = large_mesh(program, volume, name, isovalue)
    return figures


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("--volume", type=pathlib.Path)
    arguments.add_argument("--seconds", type=int, default=5)
    arguments.add_argument("--json", type=pathlib.Path)
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        volume = given.volume
        if volume is None:
            raw = pathlib.Path(folder) / "head.nrrd"
            volume = pathlib.Path(folder) / "head.mtd"
            subprocess.run([given.program, "generate", "head", "--size", "256", "--noise", "20", "-o", raw, "--quiet"], check=True)
            subprocess.run([given.program, "prepare", raw, "-o", volume, "--quiet"], check=True)
        figures = measure(given.program, volume, given.seconds)
    for what, of_it in figures.items():
        print(f"{what:16}", "  ".join(f"{name} {value:.2f}" if isinstance(value, float) else f"{name} {value}"
                                     for name, value in of_it.items()))
    if given.json:
        given.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    sys.exit(main())
