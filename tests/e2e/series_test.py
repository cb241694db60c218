"""Preparing and serving series: the labels of a segmentation, the times of a series, the fields of a simulation.

Usage: series_test.py DIRECTORY_OF_PROGRAMS [GROUP...]
"""

import json
import math
import pathlib
import re
import shutil
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from programs import (Started, check, expect_exit, expect_files, expect_info, files, get, read_json, report_of, run, run_groups, same_bytes,
                      write_nrrd, write_vti, write_zarr)

SEGMENTS = ("Segment0_ID:=a\nSegment0_Name:=liver\nSegment0_Color:=0.866667 0.509804 0.396078\nSegment0_LabelValue:=3\n"
            "Segment1_Name:=rest of it\nSegment1_LabelValue:=7\n"
            "Segment2_Name:=elsewhere\nSegment2_LabelValue:=9\nSegment2_Layer:=1\n")
SPACE = "space: left-posterior-superior\nspace directions: {}(1,0,0) (0,1,0) (0,0,{})\nspace origin: (0,0,0)\n"
ORGANS = "server prepare in/organs.seg.nrrd --label all --name organs -o organs"


def write_organs(file="in/organs.seg.nrrd", segments=SEGMENTS):
    """A ball of label 3 inside one of label 7, as 3D Slicer writes segments."""
    def label(radius):
        return 3 if radius < 6 else 7 if radius < 9 else 0
    samples = bytes(label(math.dist((x, y, z), (11, 12, 11.5))) for z in range(24) for y in range(24) for x in range(24))
    write_nrrd(file, (24, 24, 24), samples, keys=SPACE.format("", 2) + segments)


def parts_of(glb):
    """Returns the name of each node, the number of its label and its color."""
    data = glb if isinstance(glb, bytes) else pathlib.Path(glb).read_bytes()
    scene = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])
    srgb = lambda light: round(255 * (12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055))
    def color(node):
        material = scene["materials"][scene["meshes"][node["mesh"]]["primitives"][0]["material"]]
        return "".join(f"{srgb(light):02x}" for light in material["pbrMetallicRoughness"]["baseColorFactor"][:3])
    return ", ".join(f"{node.get('name')} {node.get('extras', {}).get('label')} {color(node)}" for node in scene["nodes"])


def each_label_is_a_dataset():
    write_organs()
    expect_exit(0, "--label all", "server prepare in/organs.seg.nrrd -o whole.mtd")
    for name in (".", ".."):
        expect_exit(2, "refers to another folder in paths and URLs", f"server prepare in/organs.seg.nrrd -o dots.mtd --name {name}")
    expect_exit(1, "A dataset's name must be UTF-8 without '/'", "server prepare in/organs.seg.nrrd --label all --name ../out -o below/organs")
    check(not files("dots.mtd", "out.*", "below/out*", "below/organs"), "something was written under a name that leads elsewhere")
    pathlib.Path("there").mkdir()
    shutil.copy("whole.mtd", "there")
    expect_exit(2, "no volume in there, only datasets. Serve them with: multitetra-server serve there", "server prepare there -o elsewhere")
    lines = expect_exit(0, "2 members, 0 failed", ORGANS)
    check(len(re.findall("^prepare organs.label", lines, re.M)) == 2, f"not a line of progress for each label: {lines}")
    expect_exit(0, "organs.label7: up to date", ORGANS)
    expect_exit(0, "of which the surface encloses", ORGANS.replace("-o organs", "-o printed"))
    expect_info("organs/organs.label3.mtd", '"organs", label 3 (liver, #dd8265)')
    expect_info("organs/organs.label7.mtd", '"organs", label 7 (rest of it)', "suggested isovalues 0.5")
    facts = run("server info organs/organs.label3.mtd")
    check(re.search(r", of which the surface encloses (98|99|100|101)[. ]", facts), f"a ball's volume: {facts}")
    check("surface_samples" in run("server info organs/organs.label7.mtd --json"), "no volume in the report")
    pathlib.Path("broken.nrrd").write_text("NRRD0004\ntype: int\n")
    expect_exit(2, "broken.nrrd", "server prepare broken.nrrd --label all -o new_folder")
    expect_files("new_folder")


def labels_are_extracted_together():
    """In one file with their names, or in one each. Those that touch share triangles."""
    write_organs()
    run(f"{ORGANS} --quiet")
    expect_exit(0, '"rest of it"', "server extract organs --error 0.5 -o organs.glb")
    check(parts_of("organs.glb") == "liver 3 dd8265, rest of it 7 adaefc", f"other parts: {parts_of('organs.glb')}")
    surfaces = report_of("server extract organs --error 0.5 -o organs.stl")["surfaces"]
    alone = report_of("server extract organs/organs.label3.mtd --error 0.5 -o alone.stl --report alone.json")
    check(read_json("alone.json") == alone, "--report writes something else than --json prints")
    for surface in surfaces:
        lacking = set(surface) ^ (set(alone) | {"common_triangles"})
        check(not lacking, f"the report of a folder lacks what that of one surface has: {lacking}")
        check(abs(surface["volume"]) > surface["volume_bound"] > 0, surface)
        check(surface["triangles_written"] == surface["triangles"], surface)
        for key in ("open_edges", "nonmanifold_edges"):
            check(surface[key] == surface["written"][key] == 0, f"{key}: {surface}")
    liver = surfaces[0]
    check(abs(liver["volume"] - alone["volume"]) <= liver["volume_bound"] + alone["volume_bound"], (liver, alone))
    check(abs(liver["volume_bound"] / liver["area"] * alone["area"] / alone["volume_bound"] - 1) < 0.1, (liver, alone))
    common = {surface["common_triangles"] for surface in surfaces}
    check(len(surfaces) == 2 and len(common) == 1 and min(common) > 0, f"no common border: {surfaces}")
    expect_files("organs_*.stl", "organs_label3.stl", "organs_label7.stl")
    check(all(pathlib.Path(name).stat().st_size for name in files("organs_*.stl")), "empty files")
    for option in ("--max-triangles 100", "--topology-tolerance 2"):
        expect_exit(2, "are for one dataset, not a folder", f"server extract organs {option} -o organs.glb")
    expect_exit(6, "is not written", "server extract organs --isovalue 7 -o empty.glb")
    expect_files("empty.glb")
    run("server prepare in/organs.seg.nrrd -o whole.mtd --quiet")
    run("server extract organs --color-by whole.mtd -o colored.glb --quiet")
    check(b"COLOR_0" in pathlib.Path("colored.glb").read_bytes(), "the surfaces of a folder are not colored")
    pathlib.Path("grids").mkdir()
    for dataset in ("whole.mtd", "organs/organs.label3.mtd"):
        shutil.copy(dataset, "grids")
    run("server generate gyroid --size 17 -o other.nrrd --quiet")
    run("server prepare other.nrrd -o grids/other.mtd --quiet")
    expect_exit(2, "have different grids", "server extract grids --isovalue 0.5 -o grids.glb")
    # The inner label's surface equals the inner boundary of the outer label.
    for label, euler in ((3, 2), (7, 4)):
        found = report_of(f"server extract organs/organs.label{label}.mtd --isovalue 0.5 --error 0 -o x.ply")["euler_characteristic"]
        check(found == euler, f"label {label} has Euler characteristic {found} instead of {euler}")


def names_from_headers_do_not_steer_the_terminal():
    """They are stripped of terminal controls and of marks that change the writing direction, and paths are escaped."""
    write_organs("odd.seg.nrrd", SEGMENTS.replace("liver", "li\u009b2J\u202ever"))
    expect_exit(0, "1 member, 0 failed", "server prepare odd.seg.nrrd --label 3 --name odd -o odd")
    expect_info("odd/odd.label3.mtd", '"odd", label 3 (')
    facts = run("server info odd/odd.label3.mtd")
    check(not re.search("[\u009b\u202e\udc80-\udcff]", facts), f"a label's name steers the terminal: {ascii(facts)}")
    pathlib.Path("odd").rename("turned\u202e")
    for command in ("info", "verify"):
        facts = run(f"server {command} turned\u202e/odd.label3.mtd")
        check(r"turned\xe2\x80\xae/" in facts, f"{command} prints a path raw: {ascii(facts)}")


def overlapping_segments_are_datasets_too():
    """They are in separate layers, each with its own numbering."""
    places = [(x, y, z) for z in range(24) for y in range(24) for x in range(24)]
    near = lambda place, middle, radius: math.dist(place, middle) < radius
    liver = [1 if near(p, (9, 12, 12), 6) else 2 if near(p, (19, 12, 12), 3) else 0 for p in places]
    tumour = [1 if near(p, (13, 12, 12), 5) else 0 for p in places]
    segments = "".join(f"Segment{i}_Name:={name}\nSegment{i}_LabelValue:={value}\nSegment{i}_Layer:={layer}\n"
        for i, (name, value, layer) in enumerate([("liver", 1, 0), ("tumour", 1, 1), ("spleen", 2, 0), ("none", 2, 1)]))
    write_nrrd("layers.seg.nrrd", (2, 24, 24, 24), bytes(b for both in zip(liver, tumour) for b in both),
               keys="kinds: list domain domain domain\n" + SPACE.format("none ", 1) + segments)
    write_nrrd("tumour.nrrd", (24, 24, 24), bytes(tumour), keys=SPACE.format("", 1))
    prepare = "server prepare layers.seg.nrrd"
    expect_exit(0, "the numbers of the segments are used as labels, 1 to 4", f"{prepare} --label all --name layers -o layers")
    expect_files("layers/*", *(f"layers/layers.label{label}.mtd" for label in (1, 2, 3)))
    for label, name in enumerate(("liver", "tumour", "spleen"), 1):
        expect_info(f"layers/layers.label{label}.mtd", f'"layers", label {label} ({name})')
    expect_exit(0, "layers.label2: up to date", f"{prepare} --label 2,1 --name layers -o layers")
    expect_exit(0, "1 member, 0 failed", "server prepare tumour.nrrd --label 1 --name alone -o layers")
    digests = {report_of(f"server extract layers/{name}.mtd --error 0 -o x.ply")["content_digest"]
               for name in ("layers.label2", "alone.label1")}
    check(len(digests) == 1, "a segment of the second layer has another surface than alone")
    expect_exit(2, "has no segment 5; it has 1 to 4", f"{prepare} --label 5 -o some")
    lines = expect_exit(1, "segment 4 (none) is empty", f"{prepare} --label 4 -o some")
    check("Next:" not in lines, f"there is nothing to serve: {lines}")
    expect_exit(2, "it is a segmentation: 4 segments in 2 layers, because some overlap. Prepare each segment with --label all",
                f"{prepare} -o some.mtd")
    expect_exit(0, "1 member, 0 failed", f"{prepare} --label 1 --component 1 --name chosen -o layers")
    expect_info("layers/chosen.label1.mtd", '"chosen", label 1 (tumour)')


def labels_are_chosen_and_named():
    write_organs()
    write_nrrd("in/many.nrrd", (40, 40, 1), struct.pack("<1600H", *range(1600)), kind="uint16")
    run(f"{ORGANS} --quiet")
    pathlib.Path("names.ctbl").write_text("3 hepar 1 2 3 255\n")
    expect_exit(0, "organs.label7: up to date", f"{ORGANS} --label-names names.ctbl")
    expect_info("organs/organs.label3.mtd", '"organs", label 3 (hepar, #010203)')
    expect_exit(1, "label 4 does not occur in it. Its labels are 3, 7.", "server prepare in/organs.seg.nrrd --label 4,3 -o some")
    expect_files("some/*", "some/organs.seg.label3.mtd")  # The others are prepared.
    expect_exit(2, "Select some of them, such as --label 3,7", "server prepare in/many.nrrd --label all -o some")
    expect_exit(0, '"many.label1599"', "server prepare in/many.nrrd --label 1599 -o some")
    for words, options in (
            ("integers such as 3,7, or all", "--label 3.5 -o some"),
            ('"all" cannot be combined with names', "--label all,3 -o some"),
            ("given twice", "--label 3,3 -o some"),
            ("some.mtd is the name of one dataset, but 2 are to be prepared; give a folder", "--label all -o some.mtd"),
            ("line 1 is not a label", "--label 3 --label-names in/organs.seg.nrrd -o some"),
            ("need no plan", "--label 3 --plan 2 -o some"),
            ("requires --label", "--label-names names.ctbl -o some")):
        expect_exit(2, words, f"server prepare in/organs.seg.nrrd {options}")
    expect_exit(0, "Next: multitetra-server serve some.mtd", "server prepare in/organs.seg.nrrd --label 3 -o some.mtd")
    expect_exit(0, "some.mtd", "server info some.mtd")


def thin_labels_are_noticed_and_those_at_the_border_are_closed():
    # Parts one voxel thick lose volume in simplification: a notice states their share of a label.
    write_nrrd("thin.nrrd", (9, 9, 9), bytes(324) + b"\1" * 81 + bytes(324))
    expect_exit(0, "of the 81 voxels of label 1 81 are in parts one voxel thick", "server prepare thin.nrrd --label 1 -o thin")
    write_organs()
    lines = expect_exit(0, "1 member", "server prepare in/organs.seg.nrrd --label 3 -o thick")
    check("one voxel thick" not in lines, f"a ball is not thin: {lines}")
    write_nrrd("full.nrrd", (9, 9, 9), b"\1" * 729)
    run("server prepare full.nrrd --label 1 -o full --quiet")
    full = report_of("server extract full/full.label1.mtd --isovalue 0.5 --error 0 -o full.ply")
    check((full["euler_characteristic"], full["border_edges"]) == (2, 0), f"a label at the volume's border is open: {full}")
    run("server prepare full.nrrd --label 1 --pad-value void --pad 0 -o open --quiet")
    expect_exit(6, "empty", "server extract open/full.label1.mtd --isovalue 0.5 -o open.ply")


def served_labels():
    write_organs()
    pathlib.Path("names.ctbl").write_text("3 hepar 1 2 3 255\n")
    run(f"{ORGANS} --label-names names.ctbl --quiet")
    server = Started("server serve organs --tcp 127.0.0.1:0 --http 127.0.0.1:0")
    http, at = server.url("http"), f"--server {server.url('tcp')}"
    served_labels_are_listed(http, at, server)
    served_labels_are_drawn_in_their_colors(at)
    served_labels_are_fetched_together(http, at)
    server.ends_well()


def served_labels_are_listed(http, at, server):
    lines = [line for line in server.printed().splitlines() if " serving " in line]
    check(len(lines) == 1 and "serving series=organs datasets=2" in lines[0], f"not one line for a series: {lines}")
    datasets = json.loads(get(f"{http}/v1/datasets"))["datasets"]
    labels = [dataset["member"]["label"] for dataset in datasets]
    check([[label[key] for key in ("value", "name", "color")] for label in labels] ==
          [[3, "hepar", "#010203"], [7, "rest of it", None]], f"/v1/datasets does not list members: {datasets}")
    check([[label[key] for key in ("box", "centroid")] for label in labels] ==  # In samples, whatever the spacing is.
          [[[[6, 7, 6], [16, 17, 17]], [11, 12, 11.5]], [[[3, 4, 3], [19, 20, 20]], [11, 12, 11.5]]], f"other places: {labels}")
    check(all(label["samples"] > 0 for label in labels), f"no samples: {labels}")
    check({dataset["member"]["series"] for dataset in datasets} == {"organs"}, f"another series: {datasets}")
    expect_exit(0, '"organs", label 3 (hepar, #010203)', f"client list organs {at}")
    lines = expect_exit(0, "SERIES OF", f"client list {at}").splitlines()
    check(len(lines) == 2 and lines[1].startswith("organs "), f"a series is not one entry: {lines}")
    expect_exit(0, "organs.label7, isovalue 0.5: ", f"client estimate {at} --dataset organs")
    expect_exit(1, '"nowhere"; it has "organs".', f"client estimate {at} --dataset nowhere")


def served_labels_are_drawn_in_their_colors(at):
    snapshot = f"client snapshot {at} --size 160x120"
    expect_exit(0, "organs.png: 2 surfaces, isovalue 0.5", f"{snapshot} --dataset organs --error 0.5 --background light -o organs.png")
    for label, color in ((3, "#010203"), (7, "#adaefc")):  # Label 7 has no color in its file, but the viewer's.
        run(f"{snapshot} --dataset organs.label{label} --error 0.5 -o one.png --quiet")
        run(f"{snapshot} --dataset organs.label{label} --error 0.5 --surface-color '{color}' -o other.png --quiet")
        check(same_bytes("one.png", "other.png"), f"label {label} is not drawn in the color {color}")
    expect_exit(2, "there are 2 surfaces", f"{snapshot} --dataset organs --opacity 1,1,1 -o x.png")
    for name, color in (("two", ""), ("alike", "--surface-color '#010203'")):
        run(f"{snapshot} --dataset organs.label3 --isovalue 0.4,0.6 --opacity 0.5 {color} -o {name}.png --quiet")
    check(not same_bytes("two.png", "alike.png"), "two isovalues of a label have one color")
    expect_exit(2, "labels have none", f"{snapshot} --dataset organs --volume on -o never.png")
    expect_exit(0, "2 surfaces", f"client snapshot {at} --dataset organs --max-triangles 300 -o budget.png")


def served_labels_are_fetched_together(http, at):
    """As parts of one GLB, or as a file each, as `extract` names them; also over HTTP."""
    fetch = f"client fetch {at} --dataset organs"
    surfaces = report_of(f"{fetch} --error 0.5 -o fetched.glb")["surfaces"]
    check(parts_of("fetched.glb") == "hepar 3 010203, rest of it 7 adaefc", f"other parts: {parts_of('fetched.glb')}")
    check([surface["mesh_file"] for surface in surfaces] == 2 * ["fetched.glb"], f"the report of a series: {surfaces}")
    run(f"{fetch} --error 0.5 -o fetched.ply --save-steps fetched_steps --quiet")
    expect_files("fetched*.ply", "fetched_label3.ply", "fetched_label7.ply")
    for file in (name for label in (3, 7) for name in (f"fetched_label{label}.ply", f"fetched_steps/organs.label{label}/step_0.ply")):
        check(pathlib.Path(file).stat().st_size, f"{file} is empty")
    check(b"\ncomment name hepar\n" in pathlib.Path("fetched_label3.ply").read_bytes(), "no name in the file of a label")
    # The labels of one time share a budget.
    surfaces = report_of(f"{fetch} --max-triangles 300 --error 0 -o budget.ply")["surfaces"]
    triangles = [surface["triangles_written"] for surface in surfaces]
    check(len(triangles) == 2 and 150 < sum(triangles) <= 300, f"a budget of 300 triangles: {triangles}")
    expect_exit(2, "cannot be shared by 2 surfaces", f"{fetch} --max-triangles 1 -o x.ply")
    expect_exit(6, "is not written", f"{fetch} --isovalue 7 -o x.ply")
    label = get(f"{http}/v1/datasets/organs.label3/isosurface?format=glb")
    check(parts_of(label) == "hepar 3 010203", f"over HTTP: {parts_of(label)}")
    tiles = f"{http}/v1/3dtiles/organs.label3/iso/0.5"
    tile = get(f"{tiles}/{json.loads(get(f'{tiles}/tileset.json'))['root']['content']['uri']}")
    check(parts_of(tile) == "hepar 3 010203", f"a tile over HTTP: {parts_of(tile)}")
    fetched = report_of(f"client fetch {at} --dataset organs.label3 --isovalue 0.5 --error 0 --color-by organs.label7 -o colored.ply")
    extracted = report_of("server extract organs/organs.label3.mtd --isovalue 0.5 --error 0 -o x.ply")
    check(fetched["content_digest"] == extracted["content_digest"], "a fetched label is not the extracted one")
    check(b"property float" in pathlib.Path("colored.ply").read_bytes(), "no values of the other label at the vertices")


def ball(time):
    points = [(x, y, z) for z in range(12) for y in range(12) for x in range(12)]
    return [10 * (5 - time) - 10 * math.dist(point, (5.5, 5.5, 5.5)) for point in points]


def write_beat():
    """A four-dimensional NIfTI of a ball that shrinks."""
    head = bytearray(352)
    put = lambda at, form, *values: struct.pack_into("<" + form, head, at, *values)
    put(0, "i", 348); put(40, "8h", 4, 12, 12, 12, 3, 1, 1, 1); put(70, "2h", 16, 32)
    put(76, "8f", 1, 1, 1, 1, 0.25, 0, 0, 0); put(108, "3f", 352, 1, 0); head[123] = 2 | 8; head[344:347] = b"n+1"
    pathlib.Path("beat.nii").write_bytes(bytes(head) + b"".join(struct.pack("<1728f", *ball(time)) for time in range(3)))


def all_times_of_a_file_are_prepared():
    write_beat()
    expect_exit(2, "--all-times", "server prepare beat.nii -o beat.mtd")
    prepare = "server prepare beat.nii --all-times -o beat"
    expect_exit(0, "3 members, 0 failed", prepare)
    expect_exit(0, "beat.t0002: up to date", prepare)
    expect_info("beat/beat.t0002.mtd", '"beat", time 0.5 s', "--time 2")
    expect_exit(0, "beat.t0001", f"{prepare} --times 1,2,4 --time-unit h")
    expect_info("beat/beat.t0002.mtd", '"beat", time 4 h')
    for words, options in (("--times has 2 numbers, but there are 3 times", "--times 1,2"),
                           ("write increasing numbers", "--times 1,3,2"), ("write increasing numbers", "--times 0:-1"),
                           ("exclude each other", "--time 1")):
        expect_exit(2, words, f"{prepare} {options}")
    expect_exit(2, "requires --time-series or --all-times", "server prepare beat.nii --time 1 --times 0:1 -o one.mtd")
    # The second time, prepared separately, has the same surface.
    run("server prepare beat.nii --time 1 -o second.mtd --quiet")
    digests = {report_of(f"server extract {dataset} --isovalue 0.5 --error 0.2 -o x.ply")["content_digest"]
               for dataset in ("second.mtd", "beat/beat.t0001.mtd")}
    check(len(digests) == 1, "a member is not the time that it says")


def times_are_separate_files():
    """They are not parts of one scene. A ball that has shrunk to nothing has no file."""
    write_beat()
    run("server prepare beat.nii --all-times -o beat --quiet")
    server = Started("server serve beat --tcp 127.0.0.1:0")
    fetch = f"client fetch --server {server.url('tcp')} --dataset beat"
    run(f"{fetch} --isovalue 0.4,0.5 --error 0.2 -o beats.glb --quiet")
    for isovalue in (b"0.4", b"0.5"):
        check(b'"beat.t0002, isovalue %s"' % isovalue in pathlib.Path("beats_t0002.glb").read_bytes(),
              f"isovalue {isovalue} is not in the file of its time")
    expect_files("beats*.glb", "beats_t0000.glb", "beats_t0001.glb", "beats_t0002.glb")
    expect_exit(0, "beat_t0002.png: 1 surface, isovalue 0.5", f"{fetch.replace('fetch', 'snapshot')} --isovalue 0.5 --size 80x60 -o beat.png")
    expect_exit(0, "beat_t0002.png: volume of ", f"{fetch.replace('fetch', 'snapshot')} --volume on --size 80x60 -o beat.png")
    expect_files("beat*.png", "beat_t0000.png", "beat_t0001.png", "beat_t0002.png")
    notice = 'No file is written for empty surfaces; --allow-empty writes one for "beat.t0001", "beat.t0002".'
    expect_exit(0, notice, f"{fetch} --isovalue 35 -o shrunk.ply --report shrunk.json")
    expect_files("shrunk*.ply", "shrunk_t0000.ply")
    written = [surface["mesh_file"] for surface in read_json("shrunk.json")["surfaces"]]
    check(written == ["shrunk_t0000.ply", None, None], f"the report has other files: {written}")
    expect_exit(6, "is not written", f"{fetch} --isovalue 1e9 -o none.ply")
    expect_files("none*")
    server.ends_well()
    extract = "server extract beat"
    expect_exit(0, "pulse_t0002.glb", f"{extract} --isovalue 0.5 -o pulse.glb")
    expect_files("pulse*", "pulse_t0000.glb", "pulse_t0001.glb", "pulse_t0002.glb")
    for suffix in ("ply", "glb"):
        expect_exit(0, notice, f"{extract} --isovalue 35 -o waned.{suffix} --report waned.json")
        expect_files(f"waned*.{suffix}", f"waned_t0000.{suffix}")
    written = [surface["mesh_file"] for surface in read_json("waned.json")["surfaces"]]
    check(written == ["waned_t0000.glb", None, None], f"the report has other files: {written}")
    expect_exit(6, "is not written", f"{extract} --isovalue 1e9 -o none.ply")
    expect_exit(0, "none_t0002.ply", f"{extract} --isovalue 1e9 -o none.ply --allow-empty")
    expect_files("none*", "none_t0000.ply", "none_t0001.ply", "none_t0002.ply")


def write_run():
    """A file of two fields for each time, as solvers write them, in natural order: 2 before 10."""
    for number, time in ((2, 0), (10, 1), (9, 0.5)):
        keys = ('<FieldData><DataArray type="String" Name="about" NumberOfTuples="1" format="ascii">49 0</DataArray><DataArray '
                f'type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{5 * number - 7.5}</DataArray></FieldData>')
        write_vti(f"in/run_{number}.vti", 12, [("pressure", float, ball(time)), ("hot/cold", float, [-value for value in ball(time)])], keys)
    write_vti("in/small.vti", 2, [("pressure", float, range(1, 9))])


def numbered_files_are_times_of_fields():
    write_run()
    frames = "server prepare in/run_2.vti in/run_9.vti in/run_10.vti --time-series run"
    expect_exit(0, "6 members, 0 failed", f"{frames} --times 0:0.1 --time-unit s --field pressure,hot/cold -o run")
    expect_info("run/run.hot_cold.t0001.mtd", '"run", field hot/cold, time 0.1 s')
    expect_info("run/run.pressure.t0001.mtd", "run_9.vti")
    expect_exit(0, '"run.pressure.t0002", 12 x 12 x 12 f32', f"{frames} --field all -o frames")
    expect_info("frames/run.pressure.t0002.mtd", '"run", field pressure, time 42.5')
    fields_are_colored_by_others_at_the_same_time()
    untimed = pathlib.Path("in/run_9.vti").read_text().replace("TimeValue", "other")
    pathlib.Path("in/run_11.vti").write_text(untimed)
    expect_exit(0, "4 members, 0 failed",
                "server prepare in/run_10.vti in/run_11.vti in/run_2.vti in/run_9.vti --time-series timeless --field pressure -o frames")
    expect_info("frames/timeless.pressure.t0003.mtd", "time 3")
    for code, words, options in (
            (1, "members of a series must have the same grid", "in/run_9.vti in/small.vti --time-series mixed --field pressure -o mixed"),
            (2, "has no field density. Its fields are pressure, hot/cold", "in/run_2.vti --field density -o run"),
            (2, "no '/'", "in/run_9.vti --time-series a/b --field pressure -o mixed"),
            (0, "has only one time", "in/run_9.vti --all-times --field pressure -o one_time"),
            (0, "2 members, 0 failed", "in/run_2.vti --field all -o one_time"),
            (0, "arrays, 'pressure' is used", "in/run_2.vti -o one_array.mtd")):
        expect_exit(code, words, f"server prepare {options}")
    expect_info("one_time/run_2.pressure.mtd", '"run_2", field pressure')


def vertices_of(ply):
    """Returns the names of the properties, and the sorted vertices."""
    head, _, body = pathlib.Path(ply).read_bytes().partition(b"end_header\n")
    part = head.decode().split("element face")[0]
    count = int(part.split("element vertex ")[1].split()[0])
    properties = [line.split()[1:] for line in part.splitlines() if line.startswith("property")]
    form = "<" + "".join({"float": "f", "double": "d", "uchar": "B"}[kind] for kind, _ in properties)
    return ([name for _, name in properties], sorted(struct.unpack_from(form, body, i * struct.calcsize(form)) for i in range(count)))


def fields_are_colored_by_others_at_the_same_time():
    server = Started("server serve run --tcp 127.0.0.1:0")
    fetch = f"client fetch --server {server.url('tcp')}"
    surfaces = report_of(f"{fetch} --dataset run.pressure --error 0.5 --color-by hot/cold -o run.ply")["surfaces"]
    expect_files("run_*.ply", *(f"run_pressure.t000{time}.ply" for time in range(3)))
    check([surface["color_by"] for surface in surfaces] == [f"run.hot_cold.t000{time}" for time in range(3)], surfaces)
    check(len({tuple(surface["color_range"]) for surface in surfaces}) == 1, f"the times have several ranges: {surfaces}")
    check(len({surface["parameters"]["isovalue"] for surface in surfaces}) == 1, f"several isovalues: {surfaces}")
    # extract colors by another dataset as fetch does: the same vertices, values and colors.
    run(f"{fetch} --dataset run.pressure.t0001 --error 0.5 --color-by run.hot_cold.t0001 --color-range -30,10 -o fetched.ply --quiet")
    extract = "server extract run/run.pressure.t0001.mtd"
    expect_exit(0, "Colors between vertices may be off by up to", f"{extract} --error 0.5 --color-by run/run.hot_cold.t0001.mtd "
                "--color-range -30,10 -o extracted.ply --report extracted.json")
    expect_exit(0, "files have no values and colors", f"{extract} --error 2 --color-by run/run.hot_cold.t0001.mtd -o colored.stl")
    names, fetched = vertices_of("fetched.ply")
    check("scalar" in names and "red" in names, f"no colors: {names}")
    check((names, fetched) == vertices_of("extracted.ply"), "extract colors otherwise than fetch")
    report = read_json("extracted.json")
    check((report["color_by"], report["color_range"]) == ("run.hot_cold.t0001", [-30, 10]), report)
    expect_exit(2, "--color-by", f"{extract} --color-by run/run.hot_cold.t0001.mtd -o x.ply --report run/run.hot_cold.t0001.mtd")
    expect_exit(2, "need color_by", f"{extract} --color-range 1,2 -o x.ply")
    expect_exit(2, 'has several fields, and isovalues are for one. Choose one with --dataset: "run.hot_cold"',
                f"{fetch} --dataset run --isovalue 1 -o x.ply")
    server.ends_well()


def ome_zarr_has_times_channels_and_labels():
    axes = [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"}]
    write_zarr("cells.zarr", [2, 2, 3, 4, 5], bytes(range(240)), axes, [0.5, 1, 1, 1, 1], omero={"channels": [
        {"label": "DNA", "color": "0000FF", "window": {"start": 10, "end": 200, "min": 0, "max": 255}},
        {"label": "actin", "window": {"start": 9, "end": 9}}]})
    write_zarr("nuclei.zarr", [3, 4, 5], bytes(i % 3 for i in range(60)), **{"image-label": {
        "version": "0.4", "colors": [{"label-value": 1, "rgba": [255, 0, 16, 255]}], "properties": [{"label-value": 2, "class": "nucleus"}]}})
    lines = expect_exit(0, "4 members, 0 failed", "server prepare cells.zarr --all-times --field all -o cells")
    check("the window of channel 1 from 9 to 9 is ignored" in lines, f"an empty window without a notice: {lines}")
    expect_info("cells/cells.DNA.t0001.mtd", "10 to 200")
    for channel, window in (("DNA", [10, 200]), ("actin", None)):
        found = report_of(f"server info cells/cells.{channel}.t0001.mtd")["display_window"]
        check(found == window, f"the display window of {channel} is {found}")
    expect_info("cells/cells.actin.t0001.mtd", '"cells", field actin, time 0.5 s')
    expect_info("cells/cells.DNA.t0000.mtd", '"cells", field DNA, time 0 s, #0000ff')
    write_beat()
    run("server prepare beat.nii --time 0 -o beat.mtd --quiet")
    expect_exit(2, "color_anyway", "server extract beat.mtd --isovalue 0.5 --color-by cells/cells.DNA.t0000.mtd -o x.ply")
    expect_exit(0, "2 members, 0 failed", "server prepare nuclei.zarr --label all -o nuclei")
    expect_info("nuclei/nuclei.label1.mtd", "label 1 (#ff0010)")
    expect_info("nuclei/nuclei.label2.mtd", "label 2 (nucleus)")


def hdf5_has_fields_over_times():
    try:
        import h5py
        import numpy
    except ImportError as error:
        print(f"!! HDF5 is NOT TESTED: {error}", file=sys.stderr)
        return
    with h5py.File("flow.h5", "w") as file:
        samples = numpy.arange(2 * 4 * 5 * 6, dtype="<i2").reshape(2, 4, 5, 6)
        file["a/p"], file["a/q"], file["b/q"], file["mask"] = samples, -samples, samples + 7, samples[0]
        file["time"] = [0.0, 1.5]
        file["time"].attrs["units"] = "milliseconds"
        file["time"].make_scale("time")
        file["a/p"].dims[0].attach_scale(file["time"])
    with h5py.File("odd.h5", "w") as file:
        for name in ("a", "bell\x07name", "q"):
            file[name] = samples[0]
    expect_exit(2, "prepare several of one shape with --field", "server prepare flow.h5 -o flow.mtd")
    expect_exit(0, "6 members, 0 failed", "server prepare flow.h5 --all-times --field all -o flow")
    expect_info("flow/flow.p.t0001.mtd", '"flow", field p, time 1.5 ms')
    expect_info("flow/flow.b_q.t0001.mtd", '"flow", field b/q, time 1.5 ms', "127 to 246")
    expect_exit(0, r"field '/bell\x07name' is skipped", "server prepare odd.h5 --field all -o odd")
    expect_files("odd/*", "odd/odd.a.mtd", "odd/odd.q.mtd")
    expect_exit(0, "1 member", "server prepare flow.h5 --field p --time 1 -o flow_one")
    expect_exit(2, "Its fields are p, a/q, b/q.", "server prepare flow.h5 --field mask -o flow")


def dicom_images_at_the_same_positions_are_times():
    try:
        import pydicom
        from pydicom.dataset import FileDataset, FileMetaDataset
    except ImportError as error:
        print(f"!! DICOM with times is NOT TESTED: {error}", file=sys.stderr)
        return
    pathlib.Path("gated").mkdir()
    for number in range(8):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = "1.2.840.10008.5.1.4.1.1.2", f"1.2.3.{number}"
        meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
        data = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        data.is_little_endian, data.is_implicit_VR = True, False
        data.SOPClassUID, data.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
        data.SeriesInstanceUID, data.Modality, data.InstanceNumber = "1.2.3.100", "CT", number + 1
        data.Rows, data.Columns, data.SamplesPerPixel, data.PhotometricInterpretation = 6, 6, 1, "MONOCHROME2"
        data.BitsAllocated, data.BitsStored, data.HighBit, data.PixelRepresentation = 16, 16, 15, 1
        data.PixelSpacing, data.ImageOrientationPatient = [1, 1], [1, 0, 0, 0, 1, 0]
        data.ImagePositionPatient = [0, 0, 2 * (number % 4)]
        data.PixelData = struct.pack("<36H", *(1000 * (number // 4) + i for i in range(36)))
        data.save_as(f"gated/{number}.dcm", write_like_original=False)
    expect_exit(2, "prepare them with --all-times", "server prepare gated -o gated.mtd")
    for number in range(4):
        shutil.copy(f"gated/{number}.dcm", f"first_{number}.dcm")
    expect_exit(0, "4 i16", "server prepare 'first_*.dcm' -o first.mtd")
    expect_info("first.mtd", "0 to 35")
    expect_exit(0, "2 members, 0 failed", "server prepare gated --all-times -o gated_times")
    expect_info("gated_times/gated.t0001.mtd", "1000 to 1035")


def only_what_is_stale_is_removed_or_replaced():
    write_organs()
    for number in (1, 2, 3):
        run(f"server generate torus --size 9 --noise 0.01 --seed {number} -o v{number}.nrrd --quiet")
    expect_exit(0, "3 members, 0 failed", "server prepare v1.nrrd v2.nrrd v3.nrrd --time-series v -o latest")
    run(ORGANS.replace("-o organs", "-o latest --quiet"))
    expect_exit(0, "v.t0002.mtd: removed", "server prepare v1.nrrd v2.nrrd --time-series v -o latest")
    expect_files("latest/*", *(f"latest/{name}.mtd" for name in ("organs.label3", "organs.label7", "v.t0000", "v.t0001")))
    expect_exit(0, "1 member, 0 failed", "server prepare in/organs.seg.nrrd --label 3 --name organs -o latest")
    expect_files("latest/organs.label7.mtd", "latest/organs.label7.mtd")  # A label that was not requested stays.
    # A dataset of another source is replaced only on request.
    run("server prepare v1.nrrd -o kept.mtd --quiet")
    expect_exit(2, "kept.mtd is a dataset prepared from 'v1.nrrd'", "server prepare v2.nrrd -o kept.mtd")
    expect_exit(0, "kept.mtd", "server prepare v2.nrrd -o kept.mtd --force")


if __name__ == "__main__":
    run_groups(served_labels, times_are_separate_files, numbered_files_are_times_of_fields, labels_are_extracted_together,
               each_label_is_a_dataset, names_from_headers_do_not_steer_the_terminal, overlapping_segments_are_datasets_too,
               labels_are_chosen_and_named, thin_labels_are_noticed_and_those_at_the_border_are_closed,
               all_times_of_a_file_are_prepared, ome_zarr_has_times_channels_and_labels, hdf5_has_fields_over_times,
               dicom_images_at_the_same_positions_are_times, only_what_is_stale_is_removed_or_replaced)
