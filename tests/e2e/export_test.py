"""Trees that are written as files against those of a server. Usage: export_test.py DIRECTORY_OF_PROGRAMS"""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
ISOVALUE = 0.1


def run(*words, cwd):
    subprocess.run(words, check=True, capture_output=True, cwd=cwd)


def get(address):
    while True:
        try:
            return urllib.request.urlopen(address).read()
        except urllib.error.HTTPError as error:
            if error.code != 503:
                raise
            time.sleep(0.2)


def triangles(glb):
    length = struct.unpack_from("<I", glb, 12)[0]
    return json.loads(glb[20 : 20 + length])["accessors"][0]["count"] // 3


def cells_of(index):
    """Counts and positions of fragments, and the sum of their sizes."""
    levels = struct.unpack_from("<I", index, 24)[0]
    at = 28 + 4 * levels + 12 * levels
    counts = struct.unpack_from(f"<{levels}I", index, at)
    at += 4 * levels
    positions, size = [], 0
    for count in counts:
        positions.append(struct.unpack_from(f"<{3 * count}I", index, at))
        size += sum(struct.unpack_from(f"<{count}I", index, at + 12 * count))
        at += 16 * count
    assert at == len(index), "the manifest ends where it says"
    return index[: 28 + 16 * levels], positions, size


def compare(folder, server):
    address = f"{server}/v1/3dtiles/gyroid/iso/{ISOVALUE},error=1/"
    files = [path for path in (folder / "site").rglob("*") if path.is_file()]
    surfaces = 0
    for path in files:
        name = path.relative_to(folder / "site").as_posix()
        live = get(address + name)
        if path.suffix == ".json":
            assert live == path.read_bytes(), name
        else:
            assert triangles(live) == triangles(path.read_bytes()) > 0, name
            surfaces += 1
    assert surfaces == 9, f"a root and its eight leaves, not {surfaces}"
    segment = struct.unpack("<Q", struct.pack("<d", ISOVALUE))[0]
    index = (folder / "mesh" / f"{segment}.index").read_bytes()
    head, positions, size = cells_of(index)
    live_head, live_positions, _ = cells_of(
        get(f"{server}/v1/neuroglancer/gyroid/surfaces,error=1/{segment}.index")
    )
    assert (head, positions) == (live_head, live_positions)
    assert size == (folder / "mesh" / str(segment)).stat().st_size
    told = json.loads((folder / "mesh/segment_properties/info").read_text())
    assert told["inline"]["ids"] == [str(segment)]


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        program = PROGRAMS / "multitetra-server"
        run(program, "generate", "gyroid", "--size", "97", "-o", "gyroid.nrrd", "--quiet", cwd=folder)
        run(program, "prepare", "gyroid.nrrd", "-o", "gyroid.mtd", "--quiet", cwd=folder)
        asked = ["--isovalue", str(ISOVALUE), "--error", "1", "--quiet"]
        run(program, "export", "gyroid.mtd", *asked, "-o", "site", cwd=folder)
        run(program, "export", "gyroid.mtd", *asked, "--format", "neuroglancer", "-o", "mesh", cwd=folder)
        with open(folder / "log", "w") as log:
            server = subprocess.Popen(
                [program, "serve", "gyroid.mtd", "--tcp", "off", "--http", "127.0.0.1:0"], cwd=folder, stderr=log
            )
        try:
            lines = []
            for _ in range(400):
                lines = [line for line in (folder / "log").read_text().splitlines() if "listening on http://" in line]
                if lines:
                    break
                time.sleep(0.05)
            compare(folder, "http://" + lines[0].split("http://")[1].strip())
        finally:
            server.terminate()
            server.wait()
    print("Files and server tell of the same trees.")


if __name__ == "__main__":
    main()
