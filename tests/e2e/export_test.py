"""Compares the output of export with that of a server and of extract. Usage: export_test.py DIRECTORY_OF_PROGRAMS"""

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
    """Returns the counts and positions of fragments, and the sum of their sizes."""
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


def from_shards(folder, segment):
    """Finds a segment's manifest and fragments as readers of neuroglancer_uint64_sharded_v1 do."""
    info = json.loads((folder / "info").read_text())["sharding"]
    assert info["@type"] == "neuroglancer_uint64_sharded_v1"
    assert (info["hash"], info["minishard_index_encoding"], info["data_encoding"]) == ("identity", "raw", "raw")
    hashed = segment >> info["preshift_bits"]
    minishard = hashed & (1 << info["minishard_bits"]) - 1
    number = hashed >> info["minishard_bits"] & (1 << info["shard_bits"]) - 1
    digits = (info["shard_bits"] + 3) // 4
    shard = (folder / f"{number:0{digits}x}.shard").read_bytes()
    base = 16 << info["minishard_bits"]
    start, end = struct.unpack_from("<2Q", shard, 16 * minishard)
    count = (end - start) // 24
    numbers = struct.unpack_from(f"<{3 * count}Q", shard, base + start)
    key, offset = 0, 0
    for step, gap, size in zip(numbers[:count], numbers[count : 2 * count], numbers[2 * count :]):
        key, offset = key + step, offset + gap
        if key == segment:
            manifest = shard[base + offset : base + offset + size]
            data = cells_of(manifest)[2]
            return manifest, shard[base + offset - data : base + offset]
        offset += size
    raise AssertionError(f"no segment {segment} in the shard")


def check_several(folder, program):
    """Exporting several isovalues together equals exporting each separately."""
    values = ["0.1", "-0.25"]
    words = ["--isovalue", ",".join(values), "--error", "1", "--quiet"]
    run(program, "export", "gyroid.mtd", *words, "-o", "several", cwd=folder)
    for shape in ([], ["--sharded"]):
        output = ["--format", "neuroglancer", *shape, "-o", "".join(["several_mesh", *shape])]
        run(program, "export", "gyroid.mtd", *words, *output, cwd=folder)
    stored = json.loads((folder / "several_mesh/segment_properties/info").read_text())["inline"]
    assert stored["properties"][0]["values"] == values, stored
    for value, segment in zip(values, stored["ids"]):
        alone = ["--isovalue", value, "--error", "1", "--quiet"]
        run(program, "export", "gyroid.mtd", *alone, "-o", f"tree{value}", cwd=folder)
        run(program, "export", "gyroid.mtd", *alone, "--format", "neuroglancer", "-o", f"mesh{value}", cwd=folder)
        names = {path.relative_to(folder / f"tree{value}") for path in (folder / f"tree{value}").rglob("*.*")}
        assert len(names) > 10
        for name in names:
            assert (folder / "several/iso" / value / name).read_bytes() == (folder / f"tree{value}" / name).read_bytes(), name
        manifest, data = from_shards(folder / "several_mesh--sharded", int(segment))
        for end, content in ((".index", manifest), ("", data)):
            assert (folder / f"mesh{value}" / f"{segment}{end}").read_bytes() == content, (value, end)
            assert (folder / "several_mesh" / f"{segment}{end}").read_bytes() == content, (value, end)


def compare_shards(folder):
    segment = struct.unpack("<Q", struct.pack("<d", ISOVALUE))[0]
    manifest, data = from_shards(folder / "shards", segment)
    assert manifest == (folder / "mesh" / f"{segment}.index").read_bytes()
    assert data == (folder / "mesh" / str(segment)).read_bytes()
    alone, sharded = (json.loads((folder / name / "info").read_text()) for name in ("mesh", "shards"))
    del sharded["sharding"]
    assert alone == sharded


def gltf_of(glb):
    """Returns the JSON and, by accessor, the binary chunk as one tuple per vertex or triangle."""
    length = struct.unpack_from("<I", glb, 12)[0]
    gltf = json.loads(glb[20 : 20 + length])
    binary = glb[28 + length :]

    def values(accessor):
        stored = gltf["accessors"][accessor]
        letter = {5126: "f", 5125: "I"}[stored["componentType"]]
        count = stored["count"] * {"VEC3": 3, "SCALAR": 1}[stored["type"]]
        at = gltf["bufferViews"][stored["bufferView"]]["byteOffset"]
        return list(struct.iter_unpack(f"<3{letter}", binary[at : at + 4 * count]))

    return gltf, values


def check_levels(folder, program):
    """Every level equals the surface that extract writes for its error."""
    gltf, values = gltf_of((folder / "levels/surface.glb").read_bytes())
    errors = [0.25, 1, 4]
    nodes = gltf["nodes"]
    assert [node["name"] for node in nodes] == ["level_0", "level_1", "level_2"]
    assert gltf["scenes"][0]["nodes"] == [0] and nodes[0]["extensions"]["MSFT_lod"]["ids"] == [1, 2]
    coverage = nodes[0]["extras"]["MSFT_screencoverage"]
    assert 1 >= coverage[0] > coverage[1] > coverage[2] == 0, coverage
    counts = []
    for node, error in zip(nodes, errors):
        lattice = 3**0.5 / 32
        assert abs(node["extras"]["error"] - (error + lattice) * 1e-3) < 1e-12, node
        assert abs(node["matrix"][0] - 1e-3) < 1e-12, "a volume in millimetres, a file in metres"
        words = ["--isovalue", str(ISOVALUE), "--error", str(error), "--normals", "8", "--quiet"]
        run(program, "extract", "gyroid.mtd", *words, "-o", "level.glb", cwd=folder)
        alone, alone_values = gltf_of((folder / "level.glb").read_bytes())
        stored = gltf["meshes"][node["mesh"]]["primitives"][0]
        expected = alone["meshes"][0]["primitives"][0]
        for name in ("POSITION", "NORMAL"):
            assert values(stored["attributes"][name]) == alone_values(expected["attributes"][name]), name
        triangles = values(stored["indices"])
        assert triangles == alone_values(expected["indices"])
        counts.append(len(triangles))
    assert counts[0] > counts[1] > counts[2] > 0, counts


def check_meshopt(folder, program):
    """Files compressed by meshoptimizer contain the same triangles."""
    for plain, words in (("site", ["--error", "1"]), ("levels", ["--format", "glb-lods"])):
        compressed = f"{plain}_meshopt"
        words = ["--isovalue", str(ISOVALUE), *words, "--codec", "meshopt", "--quiet"]
        run(program, "export", "gyroid.mtd", *words, "-o", compressed, cwd=folder)
        files, others = (sorted(path.relative_to(folder / name) for path in (folder / name).rglob("*.glb")) for name in (plain, compressed))
        assert files == others and files, others
        for file in files:
            before, after = (gltf_of((folder / name / file).read_bytes())[0] for name in (plain, compressed))
            assert "EXT_meshopt_compression" in after["extensionsRequired"], file
            assert all("EXT_meshopt_compression" in view["extensions"] for view in after["bufferViews"]), file
            counts = [[gltf["accessors"][mesh["primitives"][0]["indices"]]["count"] for mesh in gltf["meshes"]] for gltf in (before, after)]
            assert counts[0] == counts[1] and all(counts[0]), (file, counts)


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
    stored = json.loads((folder / "mesh/segment_properties/info").read_text())
    assert stored["inline"]["ids"] == [str(segment)]


def check_page(folder, program):
    """A page has the viewer, the datasets of a folder under their names, and an index that the viewer finds."""
    (folder / "many/some more").mkdir(parents=True)
    (folder / "many/some more/a#b.mtd").write_bytes((folder / "gyroid.mtd").read_bytes())
    made = subprocess.run([program, "export", "many", "--page", "page", "--json"], cwd=folder, capture_output=True)
    if b"viewer is not installed" in made.stderr:
        return print("!! The viewer is not built: pages are NOT TESTED.")
    report = json.loads(made.stdout)
    files = [path for path in (folder / "page").rglob("*") if path.is_file()]
    assert (report["datasets"], report["files"]) == (1, len(files)), report
    assert report["bytes"] == sum(path.stat().st_size for path in files), report
    assert '<meta name="multitetra-static" content="datasets.json"' in (folder / "page/index.html").read_text()
    [dataset] = json.loads((folder / "page/datasets.json").read_text())["datasets"]
    assert dataset["file"] == "some%20more/a%23b.mtd", dataset
    assert (dataset["metadata"]["name"], dataset["metadata"]["dims"]) == ("gyroid", [97, 97, 97]), dataset
    assert (folder / "page/some more/a#b.mtd").read_bytes() == (folder / "gyroid.mtd").read_bytes()
    (folder / "many/again.mtd").write_bytes((folder / "gyroid.mtd").read_bytes())
    (folder / "home").mkdir()
    (folder / "home/index.html").write_text("of somebody else")
    for words, problem in (
        (["many", "--page", "page"], b'Two datasets are named "gyroid"'),
        (["mesh", "--page", "page"], b"There is no dataset in mesh."),
        (["gyroid.mtd", "--page", "home"], b"index.html' exists, and its folder has no exported page"),
        (["https://site.example/a.mtd", "--page", "page"], b"download https://site.example/a.mtd first"),
        (["gyroid.mtd"], b"--output: is required, or --page."),
    ):
        refused = subprocess.run([program, "export", *words], cwd=folder, capture_output=True)
        assert refused.returncode in (1, 2) and problem in refused.stderr, refused
    assert (folder / "home/index.html").read_text() == "of somebody else"


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        program = PROGRAMS / "multitetra-server"
        run(program, "generate", "gyroid", "--size", "97", "-o", "gyroid.nrrd", "--quiet", cwd=folder)
        run(program, "prepare", "gyroid.nrrd", "-o", "gyroid.mtd", "--quiet", cwd=folder)
        options = ["--isovalue", str(ISOVALUE), "--error", "1", "--quiet"]
        run(program, "export", "gyroid.mtd", *options, "-o", "site", cwd=folder)
        run(program, "export", "gyroid.mtd", *options, "--format", "neuroglancer", "-o", "mesh", cwd=folder)
        sharded = ["--format", "neuroglancer", "--sharded"]
        run(program, "export", "gyroid.mtd", *options, *sharded, "-o", "shards", cwd=folder)
        compare_shards(folder)
        check_several(folder, program)
        levels = ["--isovalue", str(ISOVALUE), "--quiet", "--format", "glb-lods"]
        run(program, "export", "gyroid.mtd", *levels, "-o", "levels", cwd=folder)
        run(program, "export", "gyroid.mtd", *levels, "--quality", "fine", "-o", "fine", cwd=folder)
        for file in ("levels", "fine"):
            assert (folder / file / "surface.glb").stat().st_size > 10_000
        assert (folder / "fine/surface.glb").read_bytes() == (folder / "levels/surface.glb").read_bytes(), "fine is 0.25 voxels"
        nothing = subprocess.run([program, "export", "gyroid.mtd", "--isovalue", "99", "--quiet", "-o", "nothing"], cwd=folder, capture_output=True)
        assert nothing.returncode == 6 and b"is empty" in nothing.stderr, nothing
        check_page(folder, program)
        check_levels(folder, program)
        check_meshopt(folder, program)
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
    print("Files and server have the same tilesets.")


if __name__ == "__main__":
    main()
