"""The programs as users run them: generate, prepare, info, extract, serve, list and fetch, with their error messages.

Usage: programs_test.py DIRECTORY_OF_PROGRAMS [GROUP...]
"""

import gzip
import hashlib
import math
import pathlib
import re
import shlex
import shutil
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from programs import (PROGRAMS, PROJECT, Started, check, expect_exit, expect_files, expect_info, files, get, printed, read_json, report_of,
                      run, run_groups, same_bytes, write_nrrd)


def make(*kinds, noise=0.01):
    """Writes volumes and datasets of 33 samples per side; each kind is also the file's name."""
    for kind in kinds:
        run(f"server generate {kind} --size 33 --noise {noise} -o {kind}.nrrd --quiet")
        run(f"server prepare {kind}.nrrd -o {kind}.mtd --quiet")


def serve(*kinds, options=""):
    """Returns a server of datasets, the option for clients with its address, and its HTTP address."""
    make(*kinds)
    server = Started(f"server serve . --tcp 127.0.0.1:0 --http 127.0.0.1:0 {options}")
    return server, f"--server {server.url('tcp')}", server.url("http")


def size(file):
    return pathlib.Path(file).stat().st_size


def contains(file, words):
    return words.encode() in pathlib.Path(file).read_bytes()


def write_ascii(file, sizes, values, keys=""):
    pathlib.Path(file).write_text(f"NRRD0004\ntype: float\ndimension: 3\nsizes: {sizes}\nencoding: ascii\n{keys}\n{values}\n")


def damage(file, target):
    """Copies a file and overwrites the byte in its middle."""
    data = bytearray(pathlib.Path(file).read_bytes())
    data[len(data) // 2] = ord("x")
    pathlib.Path(target).write_bytes(data)


def every_kind_is_extracted_without_a_crack():
    for kind in ("sphere", "torus", "gyroid", "marschner-lobb", "box", "head"):
        make(kind)
        check(report_of(f"server info {kind}.mtd")["name"] == kind, f"the dataset of {kind}.nrrd is not named {kind}")
        run(f"server verify {kind}.mtd --quiet")
        report = report_of(f"server extract {kind}.mtd -o {kind}.ply --quiet")
        check(report["triangles"] > 0 and report["open_edges"] == report["nonmanifold_edges"] == 0, f"{kind}: {report}")
        check(kind != "sphere" or report["euler_characteristic"] == 2, f"the sphere is none: {report}")
    make("torus", noise=0)
    text = run("server extract torus.mtd --isovalue 0 -o torus.ply --report report.json --json --quiet")
    check(pathlib.Path("report.json").read_text() == text, f"--report is not what --json prints: {text}")
    check(read_json("report.json")["euler_characteristic"] == 0, f"the torus is none: {text}")


def meshes_and_models_are_written():
    make("gyroid")
    for suffix in ("ply", "stl", "obj", "drc", "glb"):
        run(f"server extract gyroid.mtd -o mesh.{suffix} --coordinates index --quiet")
        check(size(f"mesh.{suffix}") > 0, f"mesh.{suffix} is empty")
    level = "server reference gyroid.mtd -o level.ply --level 6 --model model.vtu --quiet"
    count = report_of(level)["tetrahedra"]
    check(count == 768, f"level 6 has {count} tetrahedra, not 12 * 2^6")
    check(contains("model.vtu", 'NumberOfCells="768"'), "the model file does not hold 768 cells")
    crossed = report_of(f"{level} --model-scope surface")["active_tetrahedra"]
    check(crossed < 768, "the surface crosses all of level 6")
    check(contains("model.vtu", f'NumberOfCells="{crossed}"'), "the model file does not hold what the surface crosses")
    expect_exit(2, "--model", "server reference gyroid.mtd -o level.ply --model-scope surface")
    extracted = report_of("server extract gyroid.mtd -o extracted.ply --error 0 --quiet")
    for errors in ("exact", "spectrum"):  # The dataset's errors are those of the reference, rounded up.
        reference = report_of(f"server reference gyroid.mtd -o reference.ply --error 0 --errors {errors} --quiet")
        check(reference["content_digest"] == extracted["content_digest"], f"the {errors} errors give another surface")
        check(set(reference) - {"errors"} == set(extracted), f"other reports: {set(reference) ^ set(extracted)}")


def meshes_are_certified():
    """In every format; shifted, cut, and compared with another volume."""
    make("sphere")
    run("server extract sphere.mtd -o sphere.ply --quiet")
    run("server generate gyroid --size 33 -o smooth.nrrd --quiet")
    run("server prepare smooth.nrrd -o smooth.mtd --quiet")
    isovalue = report_of("server info smooth.mtd")["suggested_isovalues"][0]
    extract = f"server extract smooth.mtd --isovalue {isovalue}"
    certify = lambda mesh, options="": f"server certify {mesh} --volume smooth.nrrd --isovalue {isovalue} --quiet {options}"
    for suffix in ("ply", "stl", "obj", "glb", "vtp"):
        run(f"{extract} --error 0.5 -o smooth.{suffix} --quiet")
        run(certify(f"smooth.{suffix}", "--error 0.5 --lattice 5"))
    found = report_of(certify("smooth.ply", "--error 0.5 --self-intersections"))
    check(found["error"]["lattice_allowance_world"] > 0, f"the lattice is not read from smooth.ply: {found}")
    check(found["kept"] is True and found["mesh"]["open_edges"] == 0, f"no certificate as JSON: {found}")
    check("flat_triangles" in found["self_intersections"], f"self-intersections are not counted: {found}")
    for key, file in (("mesh", "smooth.ply"), ("volume", "smooth.nrrd")):
        digest = hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()
        check(found[f"{key}_sha256"] == digest, f"no digest of {file}: {found}")
    for error in (0, 0.5):  # Only simplification makes triangles that intersect others.
        count = report_of(f"{extract} --error {error} -o counted.ply")["self_intersecting_triangles"]
        check((count is None) == (error == 0), f"{count} self-intersections at error {error}")
    run(f"{extract} --error 0.5 -o index.ply --coordinates index --quiet")
    run(certify("index.ply", "--error 0.5 --lattice 5 --coordinates index"))
    run(certify("sphere.ply", "--any-topology"))
    run(certify("smooth.ply", "--error 0.5 --box 0,0,0,8,8,8 --json"))
    for code, words, mesh, options in (
            (3, "NOT certified: smooth.ply", "smooth.ply", "--error 0.01"),
            (3, "NOT KEPT", "smooth.ply", "--scale 1.1 --error 0.5"),
            (3, "NOT KEPT", "sphere.ply", "--error 1"),
            (1, "mesh.xyz", "mesh.xyz", ""),
            (2, "--box", "smooth.ply", "--box 0,0,0,8,8,0"),
            (2, "neither surface has a part inside", "smooth.ply", "--box -90,-90,-90,-80,-80,-80"),
            (3, "NOT KEPT", "smooth.ply", "--space ras --error 0.5"),
            (2, "--space", "smooth.ply", "--coordinates index --space ras")):
        expect_exit(code, words, certify(mesh, options))
    expect_exit(1, "nowhere.nrrd", "server certify smooth.ply --volume nowhere.nrrd --isovalue 1")
    expect_exit(2, "--isovalue", "server certify smooth.ply --volume smooth.nrrd")
    run("server prepare smooth.nrrd -o closed.mtd --outside -1000 --margin 1 --quiet")  # The old names.
    run(f"server extract closed.mtd --isovalue {isovalue} --error 0.5 -o closed.ply --quiet")
    expect_exit(3, "--volume DATASET.mtd", certify("closed.ply", "--error 0.5"))
    run(f"server certify closed.ply --volume closed.mtd --isovalue {isovalue} --error 0.5 --quiet")
    expect_exit(2, "--pad", f"server certify closed.ply --volume closed.mtd --isovalue {isovalue} --margin 1")


def raw_files_are_described_by_options():
    pathlib.Path("header.raw").write_bytes(b"abcdef" + bytes(4096))
    infos = []
    for words in ("--dims 16,16,8 --type u16", "--dims 16x16x8 --type uint16", "--dims 16X16X8 --type UInt16", "--dims=16,16,8 --type=ushort"):
        run(f"server prepare header.raw {words} --endian big --header-bytes 6 --spacing 1,1,2.5 -o raw.mtd --outside 1 --margin 1 --force --quiet")
        infos.append({key: value for key, value in report_of("server info raw.mtd").items() if "content" not in key})
        check(infos[-1] == infos[0], f"{words}: {infos[-1]} instead of {infos[0]}")
    for words, options in (("--dims", "--dims 16x16 --type u16"), ("uint8", "--dims 16x16x8 --type complex"), ("4102", "--dims 16,16,9 --type u16")):
        expect_exit(2, words, f"server prepare header.raw {options} -o never.mtd")
    for told in ("", "--orient x,-y,-z", "--space LPS", "--length-unit um"):
        lines = expect_exit(0, "", f"server prepare header.raw --dims 16,16,8 --type u16 --header-bytes 6 -o told.mtd --force {told}")
        check(lines.count("does not say which axis is up") == (0 if told else 1), f'the axes with "{told}": {lines}')
    pathlib.Path("long.raw").write_bytes(b"x" * 20000)  # Grids beyond 4096 steps have the finest lattice that coordinates allow.
    run("server prepare long.raw --dims 5000,2,2 -o long.mtd --quiet")
    expect_exit(2, "at most 7", "server extract long.mtd --isovalue 1 --error 1 --lattice 8 -o x.ply")
    expect_files("never.mtd")


def axes_and_units_are_set_by_options():
    make("sphere")
    run("server prepare sphere.nrrd -o microns.mtd --length-unit microns --quiet")
    check(report_of("server info microns.mtd")["length_unit"] == "µm", "microns are another unit")
    run("server prepare sphere.nrrd -o turned.mtd --origin 1,2,3 --orient x,-z,y --quiet")
    found = report_of("server info turned.mtd")["index_to_world"]
    check(found == {"columns": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "translation": [1, 2, 3]}, f"--orient x,-z,y: {found}")
    for words, options in (("--orient", "--orient x,y,y"), ("give -x,y,-z or x,-y,-z", "--orient x,y,-z"),
                           ("without mirroring", "--orient x,-y,-z --mirror"), ("--mirror", "--mirror")):
        expect_exit(2, words, f"server prepare sphere.nrrd -o never.mtd {options}")
    expect_files("never.mtd")
    run("server prepare sphere.nrrd -o mirrored.mtd --orient x,y,-z --mirror --quiet")
    expect_info("mirrored.mtd", "--orient x,y,-z --mirror")
    head, _, samples = pathlib.Path("sphere.nrrd").read_bytes().partition(b"\n\n")
    lines = [line for line in head.splitlines() if not line.startswith(b"space origin")]
    pathlib.Path("far.nrrd").write_bytes(b"\n".join([*lines, b"space origin: (500000.25,5400000.75,12.5)"]) + b"\n\n" + samples)
    expect_exit(0, "500000.25 5400000.75 12.5", "server info far.nrrd")


def folders_of_volumes_are_prepared():
    """Failures are reported, and datasets that are up to date stay."""
    make("gyroid", "sphere", "torus")
    pathlib.Path("many/inside").mkdir(parents=True)
    pathlib.Path("empty").mkdir()
    shutil.copy("gyroid.nrrd", "many/a.nrrd")
    shutil.copy("sphere.nrrd", "many/inside/b.nrrd")
    pathlib.Path("many/broken.nrrd").write_text("NRRD0004\nbroken")
    pathlib.Path("many/notes.txt").write_text("no volume\n")
    expect_exit(1, "3 volumes, 1 failed", "server prepare many -o datasets")
    expect_exit(0, "b.nrrd: up to date", "server prepare many/a.nrrd many/inside/b.nrrd -o datasets")
    shutil.copy("torus.nrrd", "many/a.nrrd")
    for code, words, options in (
            (0, 'a.nrrd: "a"', "many/a.nrrd many/inside/b.nrrd -o datasets"),
            (0, 'b.nrrd: "b"', "many/inside/b.nrrd many/a.nrrd -o datasets --margin 1"),
            (0, 'b.nrrd: "b"', "many/inside/b.nrrd -o datasets --origin 0,5400000.125,0 --spacing 1,1,0.12345678"),
            (0, 'b.nrrd: "b"', "many/inside/b.nrrd -o datasets --origin 0,5400000.25,0 --spacing 1,1,0.12345678"),
            (0, 'b.nrrd: "b"', "many/inside/b.nrrd -o datasets --origin 0,5400000.25,0 --spacing 1,1,0.12345679"),
            (0, 'b.nrrd: up to date', "many/inside/b.nrrd -o datasets --origin 0,5400000.25,0 --spacing 1,1,0.12345679"),
            (0, 'a.nrrd: "other"', "many/a.nrrd -o datasets --name other"),
            (0, 'inside.mtd: "b"', "many/inside -o inside.mtd"),
            (2, "give a folder", "many -o one.mtd"),
            (2, "There is no volume in empty", "empty -o empty.mtd"),
            (2, "There is no volume in empty", "empty -o new_folder"),
            (2, "--component", "many/a.nrrd -o a.mtd --component last")):
        expect_exit(code, words, f"server prepare {options}")
    expect_files("datasets/other.mtd", "datasets/other.mtd")
    expect_files("new_folder")  # Nothing is left of it.
    expect_exit(0, "OME-Zarr", "server formats")


def volumes_without_a_surface_are_refused():
    """And a file that crashes its reader, as a volume and as a threshold grid."""
    make("gyroid")
    head = "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nPOINT_DATA 24\nSCALARS s "
    pathlib.Path("crash.vtk").write_bytes(f"{head}{'x' * 5000} 1\nLOOKUP_TABLE default\n".encode() + bytes(48))
    expect_exit(2, "crash.vtk", "server prepare crash.vtk -o crash.mtd")
    expect_exit(2, "crash.vtk", "server extract gyroid.mtd --error 1 --threshold-grid crash.vtk -o x.ply")
    write_ascii("slice.nrrd", "2 2 1", "1 2 3 4")
    expect_exit(2, "a single slice has no surface", "server prepare slice.nrrd -o never.mtd")
    run("server prepare slice.nrrd --outside 0 --margin 1 -o slice.mtd --quiet")
    write_ascii("void.nrrd", "2 2 2", 8 * "nan ")
    expect_exit(2, "all its samples are void", "server prepare void.nrrd -o never.mtd")
    write_ascii("constant.nrrd", "2 2 2", 8 * "1152921504606846976 ")
    run("server prepare constant.nrrd -o constant.mtd --quiet")
    expect_files("never.mtd")


def area_of_obj(file):
    lines = [line.split() for line in pathlib.Path(file).read_text().splitlines()]
    places = [[float(number) for number in line[1:4]] for line in lines if line[:1] == ["v"]]
    area = 0
    for a, b, c in ([places[int(corner.partition("/")[0]) - 1] for corner in line[1:]] for line in lines if line[:1] == ["f"]):
        u, v = ([one - two for one, two in zip(end, a)] for end in (b, c))
        area += math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2
    return area


def files_are_what_their_reports_say():
    """Far from the origin, too."""
    make("sphere")
    run("server prepare sphere.nrrd --origin 500000,5400000,120 --spacing 0.5,0.5,0.5 -o far.mtd --quiet")
    extract, certify = "server extract far.mtd --isovalue 0 --error 0", "--volume far.mtd --isovalue 0 --error 0 --lattice 5 --quiet"
    for suffix in ("ply", "obj", "vtp", "glb"):
        report = report_of(f"{extract} -o far.{suffix} --quiet")
        found = report_of(f"server certify far.{suffix} {certify}")
        check(found["kept"] and report["written"]["degenerate_triangles"] == 0, f"far.{suffix}: {report} {found}")
        for key in ("triangles", "vertices", "euler_characteristic", "components", "nonmanifold_edges"):
            check(report[key] == report["written"][key] == found["mesh"][key], f"{key} of far.{suffix}: {report} {found}")
    for error in (0, 0.25, 1):  # The area is that of the file, not of the full surface.
        report = report_of(f"server extract far.mtd --isovalue 0 --error {error} -o far.obj --quiet")
        check(abs(area_of_obj("far.obj") / report["area"] - 1) < 1e-9, f"{area_of_obj('far.obj')} is the area of the file: {report}")
    shift = "--shift -500000,-5400000,0"
    for suffix in ("stl", "drc"):
        expect_exit(2, "--coordinates index, or --shift -500000,-5400000,", f"{extract} -o far.{suffix}")
        run(f"{extract} {shift} -o far.{suffix} --report far.json --quiet")
        check("shift" in read_json("far.json"), "the shift is not in the report")
        run(f"server certify far.{suffix} {certify} {shift}")


def rounded_samples_are_told_and_compared_as_they_were():
    """Heights of 0.2 on a radius of 1737400, of which 32-bit floats have steps of 0.125."""
    heights = [(6 - math.dist((x, y, z), (6, 6, 6))) / 8 for z in range(13) for y in range(13) for x in range(13)]
    samples = struct.pack(f"<{len(heights)}d", *(1737400 + height for height in heights))
    write_nrrd("moon.nrrd", (13, 13, 13), samples, "double", "spacings: 1 1 1\n")
    expect_exit(2, "--subtract 1737400, or accept the loss with --allow-loss", "server prepare moon.nrrd -o moon.mtd")
    run("server prepare moon.nrrd --subtract 1737400 -o exact.mtd --quiet")
    run("server prepare moon.nrrd --allow-loss -o rounded.mtd --quiet")
    reports = {name: report_of(f"server extract {name}.mtd --isovalue {isovalue} --error 0 -o {name}.ply --quiet")
               for name, isovalue in (("exact", 0.2), ("rounded", 1737400.2))}
    words = "rounded to 32-bit floats (up to 0.06"
    check(any(words in notice for notice in reports["rounded"]["notices"]), f"the rounding is not told: {reports['rounded']}")
    check(not any("rounded" in notice for notice in reports["exact"]["notices"]), reports["exact"])
    check(report_of("server info rounded.mtd")["rounding"].startswith("up to 0.06"), "info does not tell the rounding")
    check("rounding" not in run("server info exact.mtd"), "info tells a rounding of exact differences")
    certify = "--volume moon.nrrd --isovalue 1737400.2 --error 0.05 --lattice 5 --json"
    found = report_of(f"server certify exact.ply {certify}")
    check(found["kept"] and found["isovalue"] == 1737400.2, found)
    check("compared are their differences" in found["volume_notices"][0], found["volume_notices"])
    expect_exit(3, "", f"server certify rounded.ply {certify}")
    found = report_of("server certify rounded.ply --volume rounded.mtd --isovalue 1737400.2 --error 0 --lattice 5 --json")
    check(found["kept"] and words in found["volume_notices"][0], found)


def fetched_surfaces_are_the_extracted_ones():
    """Whatever the number of threads; and all ways to a file give the same bytes."""
    server, at, http = serve("gyroid", "head", "torus")
    expect_exit(0, "gyroid", f"client list {at}")
    for dataset, error in ((dataset, error) for dataset in ("gyroid", "head", "torus") for error in (0, 0.7)):
        fetch, extract = f"client fetch {at} --dataset {dataset} --error {error}", f"server extract {dataset}.mtd --error {error}"
        fetched = report_of(f"{fetch} -o fetched.ply --save-steps steps --quiet")
        for threads in (1, 2, 4):
            extracted = report_of(f"{extract} -o extracted.ply --threads {threads} --quiet")
            check(fetched["steps"][-1]["content_digest"] == extracted["content_digest"],
                  f"{dataset} at error {error}: the fetched mesh is not the one extracted with {threads} threads")
        for suffix, normals in (("ply", 0), ("glb", 0), ("obj", 0), ("vtp", 0), ("3mf", 0), ("stl", 0), ("drc", 0), ("ply", 8), ("glb", 9)):
            run(f"{fetch} -o fetched.{suffix} --normals {normals} --quiet")
            run(f"{extract} -o extracted.{suffix} --normals {normals} --quiet")
            check(same_bytes(f"fetched.{suffix}", f"extracted.{suffix}"), f"{dataset} at error {error}: fetch writes another {suffix}")
            served = get(f"{http}/v1/datasets/{dataset}/isosurface?format={suffix}&error={error}&normals={normals}")
            check(served == pathlib.Path(f"extracted.{suffix}").read_bytes(), f"{dataset} at error {error}: HTTP sends another {suffix}")
    expect_files("steps/step_0.ply", "steps/step_0.ply")
    server.ends_well()


def threshold_maps_and_budgets_give_the_same_mesh():
    """On both command lines, with parts of all kinds."""
    server, at, _ = serve("gyroid")
    fetch = f"client fetch {at} --dataset gyroid"
    write_ascii("grid.nrrd", "2 1 1", "1.5 nan", "space dimension: 3\nspace directions: (12,0,0) (0,90,0) (0,0,90)\nspace origin: (6,45,45)\n")
    regions = ("--error 3 --region ball:9,9,9,7=0.1 --region box:9,9,25,30,30,30=0.6 --region-coordinates index --threshold-grid grid.nrrd "
               "--view eye=-20,10,10,fov=50,height=400,pixels=8,look=20,10,10,outside=4 --combine")
    for options in (f"{regions} order", f"{regions} minimum", "--error 0 --max-triangles 3000", "--error 0 --max-bytes 9000"):
        fetched = report_of(f"{fetch} {options} -o fetched.ply --quiet")
        extracted = report_of(f"server extract gyroid.mtd {options} -o extracted.ply --quiet")
        check(fetched["steps"][-1]["content_digest"] == extracted["content_digest"], f"with {options} another mesh is fetched")
        check('"radius"' in str(fetched).replace("'", '"') or regions not in options, f"the report has no threshold map: {fetched}")
    estimate = report_of(f"client estimate {at} --dataset gyroid --error 0.7")
    check({"triangles", "triangles_least", "triangles_most"} <= set(estimate), f"no range of triangles: {estimate}")
    run(f"{fetch} --error 3 -o coarse.ply --quiet")
    check(size("coarse.ply") < size("fetched.ply"), "a finer surface has no larger mesh")
    for words, options in (("does not begin with a shape", "--region cone:1=2"), ("regions[0].ball.radius", "--region ball:1,2,3,-4=2"),
                           ("the file does not exist", "--threshold-grid none.nrrd"),
                           ("low corner above its high corner along y", "--region box:1,9,1,9,1,9=0")):
        expect_exit(2, words, f"{fetch} {options} -o x.ply")
    # Regions without data are noticed, and budgets that are not met.
    expect_exit(0, "Region 2 is outside", f"{fetch} --region-coordinates index --region ball:9,9,9,3=0 --region ball:90,90,90,3=0 -o x.ply")
    expect_exit(0, "from (0, 0, 0) to (32, 32, 32) in sample indices",
                "server extract gyroid.mtd --region-coordinates index --region halfspace:0,0,1,40=0 -o x.ply")
    for command in (fetch, "server extract gyroid.mtd"):
        expect_exit(0, "The budget raised the error from 0.5 to", f"{command} --error 0.5 --max-bytes 4KB -o x.ply")
        expect_exit(0, "more than --max-bytes", f"{command} --error 0 --max-bytes 20KB -o x.stl")
    # Errors are printed in the unit of the request.
    expect_exit(0, "at most 0.5 voxels (0.5 mm)", f"client estimate {at} --dataset gyroid --error 0.5")
    expect_exit(0, "errors up to 2 voxels", f"{fetch} --error 1 --region ball:9,9,9,3=2 -o x.ply")
    server.ends_well()


def snapshots_are_reproducible_and_change_with_the_view():
    server, at, _ = serve("box", "gyroid", "head", "marschner-lobb", "sphere", "torus")
    snapshot = f"client snapshot {at} --dataset gyroid --size 320x200"
    run(f"{snapshot} -o once.png --quiet")
    report = report_of(f"{snapshot} --threads 3 -o twice.png")
    check(same_bytes("once.png", "twice.png"), "the same picture has other bytes the second time")
    check(report["width"] == 320 and report["triangles"] > 0, f"the report of snapshot: {report}")
    for options in ("--wireframe --shading facets", "--bare", "--azimuth 80", "--up -y"):
        run(f"{snapshot} {options} -o other.png --quiet")
        check(not same_bytes("once.png", "other.png"), f"{options} changes nothing")
    for words, command in (("--up", f"{snapshot} --up w -o x.png"), ("1280x960", f"client snapshot {at} --dataset gyroid --size 12by9 -o x.png"),
                           ("PNG", f"client snapshot {at} --dataset gyroid -o x.jpg"),
                           ('--dataset: "box", "gyroid", "head" and ', f"client snapshot {at} -o x.png")):
        expect_exit(2, words, command)
    server.ends_well()


def volumes_are_drawn_with_surfaces_or_alone():
    server, at, _ = serve("head")
    snapshot = f"client snapshot {at} --size 160x120"
    alone = report_of(f"{snapshot} --volume on -o alone.png")
    check(alone["surfaces"] == [] and alone["volume"]["step"] == 1, f"the report of a volume: {alone}")
    run(f"{snapshot} --volume on -o again.png --quiet")
    check(same_bytes("alone.png", "again.png"), "the same volume has other bytes the second time")
    both = report_of(f"{snapshot} --volume on --isovalue 500.5 --opacity 0.5 -o both.png")
    check(both["triangles"] > 0 and both["volume"] == alone["volume"], f"the report of volume and surface: {both}")
    coarse = report_of(f"{snapshot} --volume on --volume-samples 9000 -o coarse.png")["volume"]
    check(coarse["step"] in (2, 4, 8) and coarse["samples"] <= 9000, f"coarser samples: {coarse}")
    options = ("--volume maximum", "--volume on --opacities 0:0,900:0.5", "--volume on --no-volume-shading", "--volume on --volume-colors viridis")
    pictures = ["alone.png", "both.png", "coarse.png"]
    for number, option in enumerate(options):
        pictures.append(f"volume_{number}.png")
        expect_exit(0, "volume of ", f"{snapshot} {option} -o {pictures[-1]}")
    check(len({pathlib.Path(picture).read_bytes() for picture in pictures}) == len(pictures), "two different volumes have the same picture")
    for words, options in (('"5:2"', "--volume on --opacities 5:2"), ("ascending", "--volume on --opacities 5:0,4:1"),
                           ("lower one first", "--volume on --volume-window 9,3"), ("{off,on,maximum}", "--volume none")):
        expect_exit(2, words, f"{snapshot} {options} -o never.png")
    server.ends_well()
    server, at, _ = serve("head", options="--surfaces-only")
    expect_exit(1, "surfaces", f"client snapshot {at} --volume on -o never.png")
    check(not pathlib.Path("never.png").exists(), "a picture of a refused volume")
    server.ends_well()


def several_surfaces_are_parts_or_files():
    """Parts of one GLB, or a file each; one picture; one budget."""
    server, at, _ = serve("gyroid")
    two = f"client fetch {at} --dataset gyroid --isovalue -0.5,0.5"
    surfaces = report_of(f"{two} --error 1 -o both.glb --quiet")["surfaces"]
    check([surface["mesh_file"] for surface in surfaces] == 2 * ["both.glb"], f"the report of two surfaces: {surfaces}")
    for isovalue in ("-0.5", "0.5"):
        check(contains("both.glb", f'"name":"isovalue {isovalue}"'), f"a GLB without isovalue {isovalue}")
    lines = expect_exit(0, "both.glb written", f"{two} --error 1 -o both.glb")
    check(lines.count("both.glb written") == 1, f"one file is named twice: {lines}")
    run(f"{two} --error 1 -o both.ply --save-steps both_steps --quiet")
    expect_files("both*.ply", "both_-0.5.ply", "both_0.5.ply")
    check(size("both_steps/isovalue_0.5/step_0.ply") > 0 and size("both_0.5.ply") > 0, "empty files")
    check(not same_bytes("both_-0.5.ply", "both_0.5.ply"), "two isovalues, one surface")
    extract = "server extract gyroid.mtd --isovalue"
    for suffix in ("glb", "ply"):
        run(f"{two} --error 1 -o fetched.{suffix} --quiet")
        expect_exit(0, "isovalue 0.5, ", f"{extract} -0.5,0.5 --error 1 -o extracted.{suffix} --report both.json")
    for file in (".glb", "_-0.5.ply", "_0.5.ply"):
        check(size(f"fetched{file}") == size(f"extracted{file}"), f"fetch and extract write another {file}")
    written = [surface["mesh_file"] for surface in read_json("both.json")["surfaces"]]
    check(written == ["extracted_-0.5.ply", "extracted_0.5.ply"], f"the report of two extracted surfaces: {written}")
    surfaces = report_of(f"{two} --error 0 --max-triangles 3000 -o budget.ply --quiet")["surfaces"]
    check(all(part["triangles"] <= 3000 for surface in surfaces for part in (surface, *surface["steps"])), f"a budget is for all surfaces: {surfaces}")
    snapshot = two.replace("fetch", "snapshot")
    surfaces = report_of(f"{snapshot} --size 320x200 --opacity 0.4,1 --surface-color '#ff0000,#0000ff' -o both.png")["surfaces"]
    check([surface["is_empty"] for surface in surfaces] == [False, False], f"two surfaces in a picture: {surfaces}")
    for code, words, command in (
            (2, "are for one isovalue", f"{extract} -0.5,0.5 --max-triangles 3000 -o never.ply"),
            (6, "never_1e+09.ply is not written", f"{extract} 0.5,1e9 -o never.ply"),
            (2, "cannot be shared", f"{two} --max-triangles 1 -o never.ply"),
            (6, "never_1e+09.ply is not written", f"client fetch {at} --dataset gyroid --isovalue 0.5,1e9 -o never.ply"),
            (2, "one surface", two.replace("fetch", "estimate")),
            (2, "opacity", f"{snapshot} --opacity 0.1,0.2,0.3 -o never.png"),
            (2, "opacity", f"{snapshot} --opacity 0 -o never.png"),
            (2, "#dd8265", f"{snapshot} --surface-color red -o never.png")):
        expect_exit(code, words, command)
    expect_files("never*")
    server.ends_well()


def empty_and_unprintable_surfaces_are_noticed():
    """Empty ones are written only with --allow-empty. Only files to print have notices of edges and self-intersections."""
    server, at, _ = serve("gyroid", "marschner-lobb")
    for command in (f"client fetch {at} --dataset marschner-lobb", "server extract marschner-lobb.mtd"):
        expect_exit(0, "cannot be printed: it ends at the border of the data", f"{command} --error 1 -o printed.stl")
        expect_exit(0, " that intersect others; --intersection-free avoids them.", f"{command} --error 2 -o printed.stl")
        lines = expect_exit(0, "", f"{command} --error 2 -o printed.ply --quiet")
        check("printed" not in lines and "intersection-free" not in lines, f"a notice of a .ply: {lines}")
    fetch = f"client fetch {at} --dataset gyroid"
    for command in (f"client snapshot {at} --dataset gyroid -o nothing.png", f"{fetch} -o nothing.ply", "server extract gyroid.mtd -o nothing.obj"):
        command += " --isovalue 1e9"
        expect_exit(6, 'there is no surface at isovalue 1e+09; values of "gyroid" range from', command)
        lines = expect_exit(6, "the surface is empty", f"{command} --quiet")
        check("Notice:" not in lines, f"--quiet prints notices: {lines}")
        expect_exit(6, '"is_empty": true', f"{command} --json")
        expect_files("nothing.*")
        expect_exit(0, "The surface is empty", f"{command} --allow-empty")
        check(len(files("nothing.*")) == 1, f"--allow-empty writes {files('nothing.*')}")
        pathlib.Path(files("nothing.*")[0]).unlink()
    expect_exit(6, '"mesh_file": null', f"{fetch} --isovalue 1e9 -o x.ply --json")
    lines = expect_exit(6, "empty", f"{fetch} --isovalue 1e9 -o x.ply")
    check(re.search("topology preserved *empty", lines), f"an empty mesh preserves a topology: {lines}")
    expect_exit(0, '"notices": [', f"client estimate {at} --dataset gyroid --isovalue 1e9 --json")
    server.ends_well()


def open_surfaces_say_where():
    half = [float(x - 2.2) if y < 3 else math.nan for _ in range(5) for y in range(5) for x in range(5)]
    write_nrrd("half.nrrd", (5, 5, 5), struct.pack("<125f", *half), kind="float")
    for options, words, others in (("", "open at the border of the data or at void samples of the data (NaN, or missing: 50)", "which --pad-value"),
                                   ("--pad-value -9 --pad 1", "open at void samples of the data (NaN, or missing: 50), which --pad-value does not fill", "border of")):
        run(f"server prepare half.nrrd -o half.mtd {options} --quiet")
        lines = expect_exit(0, words, "server extract half.mtd --isovalue 0 -o half.ply")
        check(others not in lines, f"the reason of an open surface: {lines}")
    run("server generate sphere --size 9 -o ball.nrrd --quiet")
    run("server prepare ball.nrrd -o ball.mtd --quiet")
    check("  open " not in run("server extract ball.mtd -o ball.ply"), "a closed surface is called open")


def small_components_are_left_out_on_request():
    """Reports count them; the whole surface is checked, and measures are those of the components in the file."""
    run("server generate head --size 33 --noise 120 --seed 3 -o dusty.nrrd --quiet")
    run("server prepare dusty.nrrd -o dusty.mtd --quiet")
    extract = "server extract dusty.mtd --isovalue 100 --error 0"
    whole, large = report_of(f"{extract} -o whole.ply --quiet"), report_of(f"{extract} --min-component 12 -o large.ply")
    everything, few = whole["components_written"], large["components_written"]
    check(everything == whole["components"] and 1 <= few < everything, f"components: {few} of {everything}")
    lines = printed(f"{extract} --min-component 12 -o large.ply")
    check(re.search(f"The file has {few} of .* components, those with a diagonal of 12 samples or more", lines), f"another notice: {lines}")
    check(whole["content_digest"] == large["content_digest"], "another surface without small components")
    check(size("large.ply") < size("whole.ply"), "no triangle is left out")
    expect_exit(6, "is empty", "server extract dusty.mtd --isovalue 100 --min-component 1000 -o none.ply")
    # Certificates ignore removed components if the file or an option names their size.
    certify = lambda mesh, options="": f"server certify {mesh} --volume dusty.nrrd --isovalue 100 --error 0 --lattice 5 --quiet {options}"
    run(certify("large.ply"))
    largest = report_of(f"{extract} --min-component largest -o largest.ply")
    check(largest["triangles_written"] < largest["triangles"], f"triangles_written counts the whole surface: {largest}")
    check(largest["components_written"] == 1, f"the largest component is not alone: {largest}")
    triangles = re.search(".*, (.* triangles),", run(f"{extract} -o x.ply"))[1]
    expect_exit(0, f"whole surface: {triangles}", f"{extract} --min-component largest -o x.ply")
    run(certify("largest.ply"))
    run(f"{extract} --min-component 12 -o large.glb --quiet")
    expect_exit(3, "compare without them: --min-component", certify("large.glb"))
    run(certify("large.glb", "--min-component 12"))
    expect_exit(3, "NOT KEPT", certify("whole.ply", "--min-component 12"))
    server = Started("server serve dusty.mtd --tcp 127.0.0.1:0 --http off")
    fetch = f"client fetch --server {server.url('tcp')} --isovalue 100 --error 0 --quiet -o x.ply"
    whole, large = report_of(fetch), report_of(f"{fetch} --min-component 12")
    check(large["components_written"] < whole["components_written"] and 0 < large["area"] < whole["area"],
          f"measures count components that are not written: {large} {whole}")
    own = report_of(f"{extract} --min-component 12 -o x.ply --quiet")
    transfer = {"server", "final_only", "tiles_held", "tiles_received", "bytes_received", "reconnections", "steps"}
    check(set(large) - transfer == set(own) - {"seconds"}, f"extract and fetch report other things: {set(large) ^ set(own)}")
    for key in ("area", "is_full_resolution", "volume", "volume_reason", "volume_bound"):  # The order of summation differs.
        same = math.isclose(own[key], large[key], rel_tol=1e-12) if isinstance(own[key], float) else own[key] == large[key]
        check(same, f"extract and fetch have another {key}: {own[key]} {large[key]}")
    server.ends_well()


def clients_name_what_is_wrong():
    """Unwritable outputs are reported before anything is fetched; clients stop at their deadline."""
    server, at, _ = serve("box", "gyroid", "head", "marschner-lobb", "sphere", "torus")
    fetch, nobody = f"client fetch {at}", "--server tcp://127.0.0.1:1"
    for code, words, command in (
            (1, "Timed out before", f"{fetch} --dataset gyroid --error 0 --deadline 0.002 -o x.ply"),
            (1, "127.0.0.1:1", f"client fetch {nobody} --deadline 0.1 -o x.ply"),
            (0, "", f"{fetch} --dataset gyroid --error 1 --deadline 60 -o x.ply --quiet"),
            (1, "nowhere/x.ply", f"client fetch {nobody} --dataset gyroid -o nowhere/x.ply"),
            (1, "nowhere/x.json", f"client fetch {nobody} --dataset gyroid -o x.ply --report nowhere/x.json"),
            (1, "nowhere/x.png", f"client snapshot {nobody} --dataset gyroid -o nowhere/x.png"),
            (2, "--report: ./x.ply is also written by --output", f"client fetch {nobody} --dataset gyroid -o x.ply --report ./x.ply"),
            (1, "standard output", f"""sh -c '"{PROGRAMS}/multitetra-client" list {at} >/dev/full'"""),
            (1, "standard output", f"""sh -c '"{PROGRAMS}/multitetra-server" info gyroid.mtd --json >/dev/full'"""),
            (1, '"nowhere"; it has "', f"{fetch} --dataset nowhere -o x.ply"),
            (2, "error threshold", f"{fetch} --dataset gyroid --error -1 -o x.ply"),
            (2, "suffix", f"{fetch} --dataset gyroid -o x.xyz"),
            (2, "isovalue", f"{fetch} --dataset gyroid --isovalue nan -o x.ply"),
            (1, "127.0.0.1:1", f"client list {nobody}"),
            (2, "Did you mean --isovalue", "client fetch --isovale 3"),
            (2, "Did you mean snapshot", "client snapshoot")):
        expect_exit(code, words, command)
    lines = expect_exit(1, 'it has "torus", ', f"{fetch} --dataset toru -o x.ply")
    check(re.search(r'"torus"(, "[^"]*"){2} and [0-9]* more\. Did you mean "torus"\?', lines), f"all names are printed: {lines}")
    server.ends_well()


def inputs_are_never_overwritten():
    """Under any name, nor files that are not datasets."""
    make("torus")
    shutil.copy("torus.nrrd", "volume.nrrd")
    shutil.copy("torus.nrrd", "taken.mtd")
    pathlib.Path("link.mtd").symlink_to("volume.nrrd")
    for code, words, options in (
            (2, "input", "-o volume.nrrd"), (2, "input", "-o ./volume.nrrd --force"), (2, "input", "-o link.mtd"), (2, ".mtd", "-o other.nrrd"),
            (2, "is not a dataset", "-o taken.mtd"), (1, "nowhere/x.mtd", "-o nowhere/x.mtd")):
        expect_exit(code, words, f"server prepare volume.nrrd {options}")
    expect_exit(2, "file", "server reference torus.mtd -o mesh.ply --model torus.mtd")
    expect_exit(2, "--model: mesh.ply is also written by --output", "server reference torus.mtd -o mesh.ply --model mesh.ply")
    check(same_bytes("volume.nrrd", "torus.nrrd"), "prepare wrote over its input")
    expect_files("other.nrrd")
    run("server prepare volume.nrrd -o taken.mtd --force --quiet")
    run("server prepare volume.nrrd -o taken.mtd --quiet")  # A dataset is replaced without --force.


def servers_programs_name_what_is_wrong():
    make("torus")
    damage("torus.mtd", "damaged.mtd")
    pathlib.Path("cut.mtd").write_bytes(pathlib.Path("torus.mtd").read_bytes()[:2000])
    for code, words, command in (
            (2, "missing.nrrd", "prepare missing.nrrd -o x.mtd"),
            (0, "--pad 1 closes them", "prepare torus.nrrd -o x.mtd --pad-value 0"),
            (2, "--pad-value", "prepare torus.nrrd -o x.mtd --outside nothing"),
            (2, "it is already a prepared dataset", "prepare torus.mtd -o again.mtd"),
            (1, "torus.nrrd", "extract torus.nrrd -o x.ply"),
            (2, "suffix", "extract torus.mtd -o x.xyz"),
            (2, "error threshold", "extract torus.mtd -o x.ply --error nan"),
            (5, "no dataset", "serve missing.mtd --tcp 127.0.0.1:0 --http off"),
            (2, "*.svg", "plot torus.mtd -o torus.jpg"),
            (2, "cube", "generate cube -o x.nrrd"),
            (2, "2 to 4097", "generate sphere --size 1 -o x.nrrd"),
            (1, "cut.mtd", "info cut.mtd"),
            (1, '"samples": brick', "verify damaged.mtd"),
            (1, '"samples"', "extract damaged.mtd --error 0 -o x.ply")):
        expect_exit(code, words, f"server {command}")
    report = report_of("server plot torus.mtd -o torus.svg --isovalues 8 --errors 0.5,2")
    run("server plot torus.mtd -o torus.pdf --isovalues 8 --errors 0.5,2 --quiet")
    check(contains("torus.svg", "</svg>") and pathlib.Path("torus.pdf").read_bytes()[:4] == b"%PDF", "plot does not write SVG and PDF")
    check(report["plot_file"] == "torus.svg", f"the report of plot: {report}")


def servers_without_datasets_end():
    """Also when that is known only after a volume was read, beside datasets that cannot be read."""
    make("torus")
    pathlib.Path("cut.mtd").write_bytes(pathlib.Path("torus.mtd").read_bytes()[:2000])
    for name, side in (("early", 20), ("late", 400)):  # Reading the second takes longer than a server waits before it listens.
        header = f"NRRD0004\ntype: uint8\ndimension: 3\nsizes: {side} {side} {side}\nencoding: gzip\n\n".encode()
        pathlib.Path(f"{name}.nrrd").write_bytes(header + gzip.compress(bytes(side**3), 1)[:-20])
    listener = "--tcp 127.0.0.1:0 --http off"
    for inputs in ("early.nrrd", "late.nrrd", "cut.mtd early.nrrd", "cut.mtd late.nrrd"):
        expect_exit(5, "There is no dataset to serve", f"server serve {inputs} {listener}")
    server = Started(f"server serve torus.mtd late.nrrd {listener}")
    server.match("(late.nrrd.*)")
    check(run(f"client list --server {server.url('tcp')}").count("torus"), "a dataset is not served because a volume cannot be read")
    server.ends_well()


def what_kernels_lack_is_told_or_refused():
    make("torus")
    server = f"{sys.executable} {PROJECT}/tests/support/without_landlock.py {PROGRAMS}/multitetra-server"
    missing = "no landlock, seccomp"
    run("server extract torus.mtd --isovalue 0 -o torus.ply --quiet")
    for command in ("prepare torus.nrrd -o other.mtd", "info torus.nrrd", "certify torus.ply --volume torus.nrrd --isovalue 0 --error 9"):
        expect_exit(0, f"isolation: {missing}. ", f"{server} {command}")
        refused = printed(f"{server} {command} --require-isolation")
        check(f"this system cannot isolate its reader ({missing}), and --require-isolation is given" in refused, refused)
        check("isolation:" not in run(f"server {command} --require-isolation"), f"something is missing for {command}")
    served = "serve torus.nrrd --tcp 127.0.0.1:0 --http off --require-isolation"
    expect_exit(2, f"cannot isolate its reader ({missing})", f"{server} {served}")
    for file in ("torus.mtd", "torus.nrrd", "."):
        check(report_of(f"server info {file}")["isolation"]["seccomp"] is True, f"info {file} --json")
    check('"landlock": 0' in run(f"{server} info torus.nrrd --json"), "info --json tells another kernel")


def folders_of_datasets_are_verified():
    make("torus")
    check(report_of("server verify torus.mtd")["is_whole"] is True, "the report of verify")
    pathlib.Path("folder").mkdir()
    pathlib.Path("empty").mkdir()
    for name in "abc":
        shutil.copy("torus.mtd", f"folder/{name}.mtd")
    expect_exit(0, "3 datasets, 0 damaged.", "server verify folder")
    expect_exit(0, '"torus" in folder/c.mtd', "server info folder")
    check(run("server info folder --json").count('"spectrum_bins"') == 3, "info does not list a whole folder as JSON")
    damage("torus.mtd", "folder/a.mtd")
    lines = expect_exit(1, "3 datasets, 1 damaged.", "server verify folder")
    check("folder/b.mtd: all checksums match" in lines, f"the others are not verified: {lines}")
    expect_exit(2, "There is no dataset in empty", "server verify empty")


def command_lines_are_completed_and_explained():
    pathlib.Path("torus.mtd").touch()
    script = f"""source '{PROJECT}/docker/debian/completion.bash'; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _multitetra; echo "${{COMPREPLY[*]}}" """
    for expected, program, *words in (
            ("fetch", "client", "fe"), ("snapshot", "client", "sn"), ("voxel world", "client", "fetch", "--unit", ""),
            ("--previews", "client", "fetch", "--pre"), ("", "client", "fetch", "--retries", ""), ("torus.mtd", "server", "info", "torus.m")):
        offered = run(shlex.join(["bash", "-c", script, "_", f"{PROGRAMS}/multitetra-{program}", *words])).strip()
        check(offered == expected, f'after "{program} {words}" bash offers "{offered}" and not "{expected}"')
    expect_exit(0, "--previews", "client --help-all")
    for program, commands in (("server", "generate prepare info plot verify extract reference serve token"), ("client", "list estimate fetch snapshot view")):
        for command in commands.split():
            expect_exit(0, "Examples", f"{program} {command} --help")


def view_prints_the_address_of_the_page():
    local = "http://127.0.0.1:7480/#"
    for options, address in (
            ("--dataset 'a head' --isovalue -300 --error 0.5 --region ball:1,2,3,4=0",
             f"{local}dataset=a%20head&isovalue=-300&error=0.5&region=ball:1,2,3,4=0"),
            ("--dataset a --min-component 12.5", f"{local}dataset=a&min_component=12.5"),
            ("--dataset a --up -y", f"{local}dataset=a&up=-y"),
            ("--min-component largest", f"{local}min_component=largest"),
            ("--isovalue 1e30", f"{local}isovalue=1e30"),
            ("--server ws://h:7481", "http://h:7481/"),
            ("--server tcp://h:7410", "http://h:7480/")):
        found = run(f"client view {options}").strip()
        check(found == address, f"view {options} prints {found}")
    found = run(f"env MULTITETRA_SERVER=wss://site.org/volumes/ '{PROGRAMS}/multitetra-client' view --dataset a").strip()
    check(found == "https://site.org/volumes/#dataset=a", f"view ignores MULTITETRA_SERVER: {found}")
    expect_exit(0, "at port 7480; --http", "client view --server tcp://h:7410")
    lines = printed("client view --server ws://h:7481").splitlines()
    check(lines == ["http://h:7481/"], f"a known port is reported as a guess: {lines}")
    expect_exit(2, "--min-component", "client view --min-component -1")
    expect_exit(2, "the viewer shows one box or ball", "client view --region halfspace:1,0,0,2=0")


if __name__ == "__main__":
    run_groups(fetched_surfaces_are_the_extracted_ones, meshes_are_certified, files_are_what_their_reports_say, rounded_samples_are_told_and_compared_as_they_were,
               threshold_maps_and_budgets_give_the_same_mesh, snapshots_are_reproducible_and_change_with_the_view, volumes_are_drawn_with_surfaces_or_alone,
               several_surfaces_are_parts_or_files, empty_and_unprintable_surfaces_are_noticed, open_surfaces_say_where,
               small_components_are_left_out_on_request,
               clients_name_what_is_wrong, every_kind_is_extracted_without_a_crack, meshes_and_models_are_written,
               raw_files_are_described_by_options, axes_and_units_are_set_by_options, folders_of_volumes_are_prepared,
               volumes_without_a_surface_are_refused, inputs_are_never_overwritten, servers_programs_name_what_is_wrong,
               servers_without_datasets_end, what_kernels_lack_is_told_or_refused, folders_of_datasets_are_verified, command_lines_are_completed_and_explained,
               view_prints_the_address_of_the_page)
