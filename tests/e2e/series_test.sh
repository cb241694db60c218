#!/usr/bin/env bash
# Preparing and serving series of datasets: the labels of a segmentation, the times of a series, the fields of a
# simulation. Usage: series_test.sh DIRECTORY_OF_PROGRAMS [PYTHON_WITH_H5PY]
set -euo pipefail

bin=$(cd "$1" && pwd)
server=$bin/multitetra-server
client=$bin/multitetra-client
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

# says FILE WORDS: checks that the dataset's facts contain the words.
says() {
  "$server" info "$1" >facts.txt
  grep -qF -- "$2" facts.txt || fail "\"$2\" is not in the facts of $1: $(cat facts.txt)"
}
digest() { sed -n 's/^ *"content_digest": "\([^"]*\)".*/\1/p' "$1" | tail -n 1; }

# --- labels: a ball of label 3 inside one of label 7, as 3D Slicer writes segments
python3 - <<'EOPY'
import math, pathlib
side = 24
radius = lambda x, y, z: math.dist((x, y, z), (11, 12, 11.5))
label = lambda r: 3 if r < 6 else 7 if r < 9 else 0
samples = bytes(label(radius(x, y, z)) for z in range(side) for y in range(side) for x in range(side))
head = ("NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 24\n"
        "space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n")
keys = ("Segment0_ID:=a\nSegment0_Name:=liver\nSegment0_Color:=0.866667 0.509804 0.396078\nSegment0_LabelValue:=3\n"
        "Segment1_Name:=rest of it\nSegment1_LabelValue:=7\nSegment2_Name:=elsewhere\nSegment2_LabelValue:=9\nSegment2_Layer:=1\n")
pathlib.Path("in").mkdir(exist_ok=True)
open("in/organs.seg.nrrd", "wb").write((head + keys + "\n").encode() + samples)
open("in/many.nrrd", "wb").write(b"NRRD0004\ntype: uint16\ndimension: 3\nsizes: 40 40 1\nendian: little\nencoding: raw\n\n" +
                              b"".join(i.to_bytes(2, "little") for i in range(1600)))
EOPY
ends 0 "--label all" "$server" prepare in/organs.seg.nrrd -o whole.mtd
for name in . ..; do
  ends 2 'refers to another folder in paths and URLs' "$server" prepare in/organs.seg.nrrd -o dots.mtd --name $name
done
ends 1 "A dataset's name must be UTF-8 without '/'" "$server" prepare in/organs.seg.nrrd --label all --name ../out -o below/organs
[ -z "$(ls -d dots.mtd out.* below/out* below/organs 2>/dev/null)" ] || fail "something was written under a name that leads elsewhere"
mkdir there && cp whole.mtd there && ends 2 "no volume in there, only datasets. Serve them with: multitetra-server serve there" \
  "$server" prepare there -o elsewhere
ends 0 "2 members, 0 failed" "$server" prepare in/organs.seg.nrrd --label all --name organs -o organs
[ "$(grep -c '^prepare organs.label' out)" = 2 ] || fail "not a line of progress for each label: $(cat out)"
ends 0 "organs.label7: up to date" "$server" prepare in/organs.seg.nrrd --label all --name organs -o organs
ends 0 "of which the surface encloses" "$server" prepare in/organs.seg.nrrd --label all --name organs -o printed
says organs/organs.label3.mtd '"organs", label 3 (liver, #dd8265)'
says organs/organs.label7.mtd '"organs", label 7 (rest of it)'
grep -qE ', of which the surface encloses (98|99|100|101)[. ]' <("$server" info organs/organs.label3.mtd) ||
  fail "a ball's volume: $("$server" info organs/organs.label3.mtd | grep encloses)"
"$server" info organs/organs.label7.mtd --json >facts.json
grep -q '"surface_samples"' facts.json || fail "no volume: $(cat facts.json)"
says organs/organs.label7.mtd 'suggested isovalues 0.5'
# Meshes of all labels: in one file with their names, or one each. Those that touch share triangles.
ends 0 '"rest of it"' "$server" extract organs --error 0.5 -o organs.glb
parts_of() {  # parts_of FILE.glb: prints the name of each node, the number of its label and its color.
  python3 - "$1" <<'EOPY'
import json, struct, sys
data = open(sys.argv[1], "rb").read()
scene = json.loads(data[20:20 + struct.unpack("<I", data[12:16])[0]])
srgb = lambda light: round(255 * (12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055))
def color(node):
    material = scene["materials"][scene["meshes"][node["mesh"]]["primitives"][0]["material"]]
    return "".join(f"{srgb(light):02x}" for light in material["pbrMetallicRoughness"]["baseColorFactor"][:3])
print(", ".join(f"{node.get('name')} {node.get('extras', {}).get('label')} {color(node)}" for node in scene["nodes"]))
EOPY
}
[ "$(parts_of organs.glb)" = "liver 3 dd8265, rest of it 7 adaefc" ] || fail "other parts: $(parts_of organs.glb)"
ends 0 "common_triangles" "$server" extract organs --error 0.5 -o organs.stl --json
"$server" extract organs/organs.label3.mtd --error 0.5 -o alone.stl --report alone.json --quiet
python3 - out alone.json <<'EOPY' || fail "the report of a folder lacks what that of one surface has: $(cat out)"
import json, sys
text = open(sys.argv[1]).read()
folder, alone = json.loads(text[text.index("{"):]), json.load(open(sys.argv[2]))
for surface in folder["surfaces"]:
    assert set(alone) | {"common_triangles"} == set(surface), set(alone) ^ set(surface)
    assert abs(surface["volume"]) > surface["volume_bound"] > 0 and surface["triangles_written"] == surface["triangles"]
liver = folder["surfaces"][0]
assert abs(liver["volume"] - alone["volume"]) <= liver["volume_bound"] + alone["volume_bound"]
assert abs(liver["volume_bound"] / liver["area"] * alone["area"] / alone["volume_bound"] - 1) < 0.1
EOPY
for key in open_edges nonmanifold_edges; do
  # Of each surface, and of its file.
  [ "$(grep -c "\"$key\": 0" out)" = 4 ] || fail "$key: $(cat out)"
done
[ "$(grep -o '"common_triangles": [1-9][0-9]*' out | sort -u | wc -l)" = 1 ] || fail "no common border: $(cat out)"
[ -s organs_label3.stl ] && [ -s organs_label7.stl ] || fail "no file for each label: $(ls)"
ends 2 "are for one dataset, not a folder" "$server" extract organs --max-triangles 100 -o organs.glb
ends 2 "are for one dataset, not a folder" "$server" extract organs --topology-tolerance 2 -o organs.glb
ends 6 "is not written" "$server" extract organs --isovalue 7 -o empty.glb
[ ! -e empty.glb ] || fail "an empty surface is written"
mkdir grids && cp whole.mtd organs/organs.label3.mtd grids
"$server" generate gyroid --size 17 -o other.nrrd >/dev/null && "$server" prepare other.nrrd -o grids/other.mtd >/dev/null 2>&1
ends 2 "have different grids" "$server" extract grids --isovalue 0.5 -o grids.glb
# Label names from headers are stripped of terminal controls and of marks that change the writing direction.
sed 's/Name:=liver/Name:=li\xc2\x9b2J\xe2\x80\xaever/' in/organs.seg.nrrd >odd.seg.nrrd
ends 0 "1 member, 0 failed" "$server" prepare odd.seg.nrrd --label 3 --name odd -o odd
says odd/odd.label3.mtd '"odd", label 3 ('
! LC_ALL=C grep -q $'\xc2\x9b\|\xe2\x80\xae' facts.txt || fail "a label's name steers the terminal: $(cat -v facts.txt)"
mkdir $'turned\xe2\x80\xae' && cp odd/odd.label3.mtd $'turned\xe2\x80\xae'
for command in info verify; do
  "$server" $command $'turned\xe2\x80\xae/odd.label3.mtd' >facts.txt
  grep -qF 'turned\xe2\x80\xae/' facts.txt || fail "$command prints a path raw: $(cat -v facts.txt)"
done
printf 'NRRD0004\ntype: int\n' >broken.nrrd
ends 2 "broken.nrrd" "$server" prepare broken.nrrd --label all -o new_folder
[ ! -e new_folder ] || fail "a folder was left in which there is nothing"

# --- overlapping segments are in separate layers, each with its own numbering
python3 - <<'EOPY'
import math, pathlib
side = 24
places = [(x, y, z) for z in range(side) for y in range(side) for x in range(side)]
near = lambda place, middle, radius: math.dist(place, middle) < radius
liver = [1 if near(p, (9, 12, 12), 6) else 2 if near(p, (19, 12, 12), 3) else 0 for p in places]
tumour = [1 if near(p, (13, 12, 12), 5) else 0 for p in places]
head = "NRRD0004\ntype: uint8\nspace: left-posterior-superior\nencoding: raw\nspace origin: (0,0,0)\n"
layers = ("dimension: 4\nsizes: 2 24 24 24\nkinds: list domain domain domain\n"
          "space directions: none (1,0,0) (0,1,0) (0,0,1)\n")
keys = "".join(f"Segment{i}_Name:={name}\nSegment{i}_LabelValue:={value}\nSegment{i}_Layer:={layer}\n"
               for i, (name, value, layer) in enumerate([("liver", 1, 0), ("tumour", 1, 1), ("spleen", 2, 0), ("none", 2, 1)]))
pathlib.Path("overlap").mkdir()
open("overlap/layers.seg.nrrd", "wb").write((head + layers + keys + "\n").encode() + bytes(b for both in zip(liver, tumour) for b in both))
alone = "dimension: 3\nsizes: 24 24 24\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
open("overlap/tumour.nrrd", "wb").write((head + alone + "\n").encode() + bytes(tumour))
EOPY
ends 0 "the numbers of the segments are used as labels, 1 to 4" "$server" prepare overlap/layers.seg.nrrd --label all --name layers -o layers
[ "$(ls layers | tr '\n' ' ')" = "layers.label1.mtd layers.label2.mtd layers.label3.mtd " ] || fail "other datasets: $(ls layers)"
says layers/layers.label1.mtd '"layers", label 1 (liver)'
says layers/layers.label2.mtd '"layers", label 2 (tumour)'
says layers/layers.label3.mtd '"layers", label 3 (spleen)'
ends 0 "layers.label2: up to date" "$server" prepare overlap/layers.seg.nrrd --label 2,1 --name layers -o layers
ends 0 "1 member, 0 failed" "$server" prepare overlap/tumour.nrrd --label 1 --name alone -o layers
"$server" extract layers/layers.label2.mtd --error 0 -o of_layer.ply --json --quiet >of_layer.json
"$server" extract layers/alone.label1.mtd --error 0 -o alone.ply --json --quiet >alone.json
[ "$(digest of_layer.json)" = "$(digest alone.json)" ] || fail "a segment of the second layer has another surface than alone"
ends 2 "has no segment 5; it has 1 to 4" "$server" prepare overlap/layers.seg.nrrd --label 5 -o some
ends 1 "segment 4 (none) is empty" "$server" prepare overlap/layers.seg.nrrd --label 4 -o some
! "$server" prepare overlap/layers.seg.nrrd --label 4 -o some 2>/dev/null | grep 'Next:' || fail "there is nothing to serve"
ends 2 "it is a segmentation: 4 segments in 2 layers, because some overlap. Prepare each segment with --label all" \
  "$server" prepare overlap/layers.seg.nrrd -o some.mtd
ends 0 "1 member, 0 failed" "$server" prepare overlap/layers.seg.nrrd --label 1 --component 1 --name chosen -o layers
says layers/chosen.label1.mtd '"chosen", label 1 (tumour)'
printf '3 hepar 1 2 3 255\n' >names.ctbl
ends 0 "organs.label7: up to date" "$server" prepare in/organs.seg.nrrd --label all --label-names names.ctbl --name organs -o organs
says organs/organs.label3.mtd '"organs", label 3 (hepar, #010203)'
ends 1 "label 4 does not occur in it. Its labels are 3, 7." "$server" prepare in/organs.seg.nrrd --label 4,3 -o some
[ -e some/organs.seg.label3.mtd ] || fail "after a label that is missing the others are not made"
ends 2 "Select some of them, such as --label 3,7" "$server" prepare in/many.nrrd --label all -o some
ends 0 '"many.label1599"' "$server" prepare in/many.nrrd --label 1599 -o some
ends 2 "integers such as 3,7, or all" "$server" prepare in/organs.seg.nrrd --label 3.5 -o some
ends 2 '"all" cannot be combined with names' "$server" prepare in/organs.seg.nrrd --label all,3 -o some
ends 2 "given twice" "$server" prepare in/organs.seg.nrrd --label 3,3 -o some
ends 2 "some.mtd is the name of one dataset, but 2 are to be prepared; give a folder" "$server" prepare in/organs.seg.nrrd --label all -o some.mtd
ends 0 "Next: multitetra-server serve some.mtd" "$server" prepare in/organs.seg.nrrd --label 3 -o some.mtd
ends 0 "some.mtd" "$server" info some.mtd && rm some.mtd
ends 2 "line 1 is not a label" "$server" prepare in/organs.seg.nrrd --label 3 --label-names in/organs.seg.nrrd -o some
ends 2 "exclude each other" "$server" prepare in/organs.seg.nrrd --label 3 --plan 2 -o some
ends 2 "requires --label" "$server" prepare in/organs.seg.nrrd --label-names names.ctbl -o some
# The inner label's surface equals the inner boundary of the outer label.
"$server" extract organs/organs.label3.mtd --isovalue 0.5 --error 0 -o inner.ply --json --quiet >inner.json
grep -q '"euler_characteristic": 2' inner.json || fail "the surface of a ball's label is no ball"
"$server" extract organs/organs.label7.mtd --isovalue 0.5 --error 0 -o outer.ply --json --quiet >outer.json
grep -q '"euler_characteristic": 4' outer.json || fail "the surface of a shell's label is not two balls"

# Parts one voxel thick lose volume in simplification: a notice states their share of a label.
{ printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\n'; head -c 324 /dev/zero; head -c 81 /dev/zero | tr '\0' '\1'; head -c 324 /dev/zero; } >in/thin.nrrd
ends 0 "of the 81 voxels of label 1 81 are in parts one voxel thick" "$server" prepare in/thin.nrrd --label 1 -o thin
! grep -q 'one voxel thick' <("$server" prepare in/organs.seg.nrrd --label 3 -o thick 2>&1) || fail "a ball is not thin"

# A label that reaches the volume's border is closed there by default.
{ printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 9 9\nencoding: raw\n\n'; head -c 729 /dev/zero | tr '\0' '\1'; } >in/full.nrrd
"$server" prepare in/full.nrrd --label 1 -o full --quiet
"$server" extract full/full.label1.mtd --isovalue 0.5 --error 0 -o full.ply --json --quiet >full.json
grep -q '"euler_characteristic": 2' full.json && grep -q '"border_edges": 0' full.json || fail "a label at the volume's border is open"
"$server" prepare in/full.nrrd --label 1 --pad-value void --pad 0 -o open --quiet
ends 6 "empty" "$server" extract open/full.label1.mtd --isovalue 0.5 -o open.ply

# --- serving: members are listed, and one colors another
start server "$server" serve organs --tcp 127.0.0.1:0 --http 127.0.0.1:0
url=$(url_of server tcp)
http=$(url_of server http)
curl -s "$http/v1/datasets" >datasets.json
[ "$(grep -c ' serving ' server.log)" = 1 ] && grep -q 'serving series=organs datasets=2' server.log || fail "not one line for a series: $(cat server.log)"
python3 - <<'EOPY' || fail "/v1/datasets does not list members: $(cat datasets.json)"
import json
datasets = json.load(open("datasets.json"))["datasets"]
assert [{key: d["member"]["label"][key] for key in ("value", "name", "color")} for d in datasets] == [
    {"value": 3, "name": "hepar", "color": "#010203"}, {"value": 7, "name": "rest of it", "color": None}], datasets
places = [[d["member"]["label"][key] for key in ("box", "centroid")] for d in datasets]  # In samples, whatever the spacing.
assert places == [[[[6, 7, 6], [16, 17, 17]], [11, 12, 11.5]], [[[3, 4, 3], [19, 20, 20]], [11, 12, 11.5]]], places
assert all(d["member"]["label"]["samples"] > 0 for d in datasets), datasets
assert {d["member"]["series"] for d in datasets} == {"organs"}
EOPY
"$client" list --server "$url" | grep -F "\"organs\", label 3 (hepar, #010203)" >/dev/null || fail "list does not print members: $("$client" list --server "$url")"
ends 0 "organs.label7, isovalue 0.5: " "$client" estimate --server "$url" --dataset organs
ends 1 '"nowhere"; it has "organs".' "$client" estimate --server "$url" --dataset nowhere
ends 0 "organs.png: 2 surfaces, isovalue 0.5" "$client" snapshot --server "$url" --dataset organs --error 0.5 --size 160x120 --background light -o organs.png
for color in "" "--surface-color #010203"; do
  "$client" snapshot --server "$url" --dataset organs.label3 --error 0.5 --size 160x120 $color -o "liver$color.png" --quiet
done
cmp liver.png "liver--surface-color #010203.png" || fail "a label is not drawn in its color"
for color in "" "--surface-color #adaefc"; do # Label 7 has no color in its file.
  "$client" snapshot --server "$url" --dataset organs.label7 --error 0.5 --size 160x120 $color -o "rest$color.png" --quiet
done
cmp rest.png "rest--surface-color #adaefc.png" || fail "a label without a color is not drawn in the viewer's"
ends 2 "there are 2 surfaces" "$client" snapshot --server "$url" --dataset organs --opacity 1,1,1 -o x.png
"$client" snapshot --server "$url" --dataset organs.label3 --isovalue 0.4,0.6 --opacity 0.5 --size 160x120 -o two.png --quiet
"$client" snapshot --server "$url" --dataset organs.label3 --isovalue 0.4,0.6 --opacity 0.5 --surface-color '#010203' --size 160x120 -o alike.png --quiet
! cmp -s two.png alike.png || fail "two isovalues of a label have one color"
ends 0 "2 surfaces" "$client" snapshot --server "$url" --dataset organs --max-triangles 300 -o budget.png
# All labels of a series: parts of one GLB, or a file each, as `extract` names them; also over HTTP.
"$client" fetch --server "$url" --dataset organs --error 0.5 -o fetched.glb --json --quiet >fetched.json
[ "$(parts_of fetched.glb)" = "hepar 3 010203, rest of it 7 adaefc" ] || fail "other parts: $(parts_of fetched.glb)"
[ "$(grep -c '"mesh_file": "fetched.glb"' fetched.json)" = 2 ] || fail "the report of a series: $(cat fetched.json)"
"$client" fetch --server "$url" --dataset organs --error 0.5 -o fetched.ply --save-steps fetched_steps --quiet
for label in 3 7; do
  [ -s "fetched_label$label.ply" ] && [ -s "fetched_steps/organs.label$label/step_0.ply" ] || fail "no file for each label: $(ls)"
done
grep -aq '^comment name hepar$' fetched_label3.ply || fail "no name in $(head -4 fetched_label3.ply)"
[ ! -e fetched.ply ] || fail "a file of no label"
# The labels of one time share a budget.
"$client" fetch --server "$url" --dataset organs --max-triangles 300 --error 0 -o budget.ply --json --quiet >budget.json
python3 - <<'EOPY'
import json
triangles = [one["triangles_written"] for one in json.load(open("budget.json"))["surfaces"]]
assert len(triangles) == 2 and 150 < sum(triangles) <= 300, triangles
EOPY
ends 2 "cannot be shared by 2 surfaces" "$client" fetch --server "$url" --dataset organs --max-triangles 1 -o x.ply
ends 6 "is not written" "$client" fetch --server "$url" --dataset organs --isovalue 7 -o x.ply
curl -sf "$http/v1/datasets/organs.label3/isosurface?format=glb" >label.glb
[ "$(parts_of label.glb)" = "hepar 3 010203" ] || fail "over HTTP: $(parts_of label.glb)"
tile=$(curl -sf "$http/v1/3dtiles/organs.label3/iso/0.5/tileset.json" | python3 -c 'import json, sys; print(json.load(sys.stdin)["root"]["content"]["uri"])')
curl -sf "$http/v1/3dtiles/organs.label3/iso/0.5/$tile" >tile.glb
[ "$(parts_of tile.glb)" = "hepar 3 010203" ] || fail "a tile over HTTP: $(parts_of tile.glb)"
"$client" fetch --server "$url" --dataset organs.label3 --isovalue 0.5 --error 0 --color-by organs.label7 -o colored.ply --report report.json --quiet
[ "$(digest report.json)" = "$(digest inner.json)" ] || fail "a fetched label is not the extracted one"
grep -aq "property float" colored.ply || fail "no values of the other label at the vertices"
ends_well server "$pid"

# --- times: a four-dimensional NIfTI, and one file of two fields for each time, as solvers write them
python3 - <<'EOPY'
import json, math, pathlib, struct
side, times = 12, 3
points = [(x, y, z) for z in range(side) for y in range(side) for x in range(side)]
ball = lambda t: [10 * (5 - t) - 10 * math.dist(p, (5.5, 5.5, 5.5)) for p in points]
head = bytearray(352)
put = lambda at, form, *values: struct.pack_into("<" + form, head, at, *values)
put(0, "i", 348); put(40, "8h", 4, side, side, side, times, 1, 1, 1); put(70, "2h", 16, 32)
put(76, "8f", 1, 1, 1, 1, 0.25, 0, 0, 0); put(108, "3f", 352, 1, 0); head[123] = 2 | 8; head[344:347] = b"n+1"
pathlib.Path("in/beat.nii").write_bytes(bytes(head) + b"".join(struct.pack(f"<{len(points)}f", *ball(t)) for t in range(times)))
# In natural order, 2 before 10.
for name, t in (("run_2", 0), ("run_10", 1), ("run_9", 0.5)):
    arrays = "".join(f'<DataArray type="Float32" Name="{field}" format="ascii">' +
                     " ".join(f"{v * scale:.3f}" for v in ball(t)) + "</DataArray>"
                     for field, scale in (("pressure", 1), ("hot/cold", -1)))
    pathlib.Path(f"in/{name}.vti").write_text(
        '<VTKFile type="ImageData"><ImageData WholeExtent="0 11 0 11 0 11"><FieldData>'
        '<DataArray type="String" Name="about" NumberOfTuples="1" format="ascii">49 0</DataArray>'
        f'<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{5 * int(name[4:]) - 7.5}</DataArray>'
        '</FieldData><Piece Extent="0 11 0 11 0 11"><PointData>' +
        arrays + "</PointData></Piece></ImageData></VTKFile>")
pathlib.Path("in/small.vti").write_text(
    '<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 1 0 1"><Piece Extent="0 1 0 1 0 1"><PointData>'
    '<DataArray type="Float32" Name="pressure" format="ascii">1 2 3 4 5 6 7 8</DataArray></PointData></Piece></ImageData></VTKFile>')
# An OME-Zarr of two times and two channels, and an OME-Zarr of labels.
def zarr(name, axes, scale, shape, samples, more):
    folder = pathlib.Path("in") / name
    (folder / "0").mkdir(parents=True)
    (folder / ".zgroup").write_text('{"zarr_format": 2}')
    (folder / ".zattrs").write_text(json.dumps({"multiscales": [{"version": "0.4", "axes": axes, "datasets": [
        {"path": "0", "coordinateTransformations": [{"type": "scale", "scale": scale}]}]}], **more}))
    (folder / "0/.zarray").write_text(json.dumps({"zarr_format": 2, "shape": shape, "chunks": shape, "dtype": "|u1", "order": "C",
                                                  "compressor": None, "fill_value": 0, "filters": None}))
    (folder / "0" / ".".join("0" for _ in shape)).write_bytes(samples)
space = [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"]
zarr("cells.zarr", [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"}] + space,
     [0.5, 1, 1, 1, 1], [2, 2, 3, 4, 5], bytes(range(240)), {"omero": {"channels": [
         {"label": "DNA", "color": "0000FF", "window": {"start": 10, "end": 200, "min": 0, "max": 255}},
         {"label": "actin", "window": {"start": 9, "end": 9}}]}})
zarr("nuclei.zarr", space, [1, 1, 1], [3, 4, 5], bytes(i % 3 for i in range(60)),
     {"image-label": {"version": "0.4", "colors": [{"label-value": 1, "rgba": [255, 0, 16, 255]}],
                      "properties": [{"label-value": 2, "class": "nucleus"}]}})
EOPY
ends 2 "--all-times" "$server" prepare in/beat.nii -o beat.mtd
ends 0 "3 members, 0 failed" "$server" prepare in/beat.nii --all-times -o beat
ends 0 "beat.t0002: up to date" "$server" prepare in/beat.nii --all-times -o beat
says beat/beat.t0002.mtd '"beat", time 0.5 s'
says beat/beat.t0002.mtd '--time 2'
ends 0 "beat.t0001" "$server" prepare in/beat.nii --all-times --times 1,2,4 --time-unit h -o beat
says beat/beat.t0002.mtd '"beat", time 4 h'
ends 2 "--times has 2 numbers, but there are 3 times" "$server" prepare in/beat.nii --all-times --times 1,2 -o beat
ends 2 "write increasing numbers" "$server" prepare in/beat.nii --all-times --times 1,3,2 -o beat
ends 2 "write increasing numbers" "$server" prepare in/beat.nii --all-times --times 0:-1 -o beat
ends 2 "exclude each other" "$server" prepare in/beat.nii --all-times --time 1 -o beat
ends 2 "requires --time-series or --all-times" "$server" prepare in/beat.nii --time 1 --times 0:1 -o one.mtd
# The second time, prepared separately, has the same surface.
"$server" prepare in/beat.nii --time 1 -o second.mtd --quiet
for dataset in second.mtd beat/beat.t0001.mtd; do
  "$server" extract "$dataset" --isovalue 0.5 --error 0.2 -o x.ply --json --quiet >x.json
  digest x.json
done | uniq | wc -l | grep -qx 1 || fail "a member is not the time that it says"

# Times are not parts of one scene.
start beats "$server" serve beat --tcp 127.0.0.1:0
"$client" fetch --server "$(url_of beats tcp)" --dataset beat --isovalue 0.4,0.5 --error 0.2 -o beats.glb --quiet
for isovalue in 0.4 0.5; do
  grep -aq "\"beat.t0002, isovalue $isovalue\"" beats_t0002.glb || fail "isovalue $isovalue is not in the file of its time"
done
[ "$(echo beats_*.glb | wc -w)" = 3 ] && [ ! -e beats.glb ] || fail "not one file for each time: $(ls)"
ends 0 "beat_t0002.png: 1 surface, isovalue 0.5" "$client" snapshot --server "$(url_of beats tcp)" --dataset beat --isovalue 0.5 --size 80x60 -o beat.png
# A ball that has shrunk to nothing after the first time.
ends 0 'No file is written for empty surfaces; --allow-empty writes one for "beat.t0001", "beat.t0002".' \
  "$client" fetch --server "$(url_of beats tcp)" --dataset beat --isovalue 35 -o shrunk.ply --report shrunk.json
[ "$(echo shrunk_*.ply)" = shrunk_t0000.ply ] || fail "fetch writes empty times: $(ls)"
python3 -c 'import json; assert [one["mesh_file"] for one in json.load(open("shrunk.json"))["surfaces"]] == ["shrunk_t0000.ply", None, None]' ||
  fail "the report has other files: $(cat shrunk.json)"
ends 6 "is not written" "$client" fetch --server "$(url_of beats tcp)" --dataset beat --isovalue 1e9 -o none.ply
[ "$(echo none*)" = "none*" ] || fail "fetch writes a series without a surface: $(ls)"
[ "$(echo beat_*.png)" = "beat_t0000.png beat_t0001.png beat_t0002.png" ] && [ ! -e beat.png ] || fail "not one picture for each time: $(ls)"
ends_well beats "$pid"
ends 0 "pulse_t0002.glb" "$server" extract beat --isovalue 0.5 -o pulse.glb
[ "$(echo pulse*.glb)" = "pulse_t0000.glb pulse_t0001.glb pulse_t0002.glb" ] || fail "not one file for each time: $(ls)"
for suffix in ply glb; do
  ends 0 'No file is written for empty surfaces; --allow-empty writes one for "beat.t0001", "beat.t0002".' \
    "$server" extract beat --isovalue 35 -o waned.$suffix --report waned.json
  [ "$(echo waned_*.$suffix)" = waned_t0000.$suffix ] || fail "extract writes empty times: $(ls)"
done
grep -c '"mesh_file": null' waned.json | grep -qx 2 || fail "the report has other files: $(cat waned.json)"
ends 6 "is not written" "$server" extract beat --isovalue 1e9 -o none.ply
ends 0 "none_t0002.ply" "$server" extract beat --isovalue 1e9 -o none.ply --allow-empty
[ "$(echo none_*)" = "none_t0000.ply none_t0001.ply none_t0002.ply" ] || fail "--allow-empty leaves out a time: $(ls)"

ends 0 "6 members, 0 failed" "$server" prepare in/run_*.vti --time-series run --times 0:0.1 --time-unit s --field pressure,hot/cold -o run
says run/run.hot_cold.t0001.mtd '"run", field hot/cold, time 0.1 s'
says run/run.pressure.t0001.mtd 'run_9.vti'
ends 0 '"run.pressure.t0002", 12 x 12 x 12 f32' "$server" prepare in/run_*.vti --time-series run --field all -o frames
says frames/run.pressure.t0002.mtd '"run", field pressure, time 42.5'
# A field of a series: its times, colored by another field at the same time, in one range.
start runs "$server" serve run --tcp 127.0.0.1:0
url=$(url_of runs tcp)
"$client" fetch --server "$url" --dataset run.pressure --error 0.5 --color-by hot/cold -o run.ply --report run.json --quiet
[ "$(echo run_*.ply)" = "run_pressure.t0000.ply run_pressure.t0001.ply run_pressure.t0002.ply" ] || fail "not the times of a field: $(ls)"
python3 - <<'EOPY'
import json
surfaces = json.load(open("run.json"))["surfaces"]
assert [one["color_by"] for one in surfaces] == [f"run.hot_cold.t000{time}" for time in range(3)], surfaces
assert len({tuple(one["color_range"]) for one in surfaces}) == 1, surfaces
assert len({one["parameters"]["isovalue"] for one in surfaces}) == 1, surfaces
EOPY
# extract colors by another dataset as fetch does: the same vertices, values and colors.
"$client" fetch --server "$url" --dataset run.pressure.t0001 --error 0.5 --color-by run.hot_cold.t0001 --color-range -30,10 -o fetched.ply --quiet
ends 0 "Colors between vertices may be off by up to" "$server" extract run/run.pressure.t0001.mtd --error 0.5 \
  --color-by run/run.hot_cold.t0001.mtd --color-range -30,10 -o extracted.ply --report extracted.json
python3 - <<'EOPY'
import json, struct
def vertices(path):
    head, _, body = open(path, "rb").read().partition(b"end_header\n")
    part = head.decode().split("element face")[0]
    count = int(part.split("element vertex ")[1].split()[0])
    properties = [line.split()[1:] for line in part.splitlines() if line.startswith("property")]
    form = "<" + "".join({"float": "f", "double": "d", "uchar": "B"}[kind] for kind, _ in properties)
    size = struct.calcsize(form)
    return [name for _, name in properties], sorted(struct.unpack_from(form, body, i * size) for i in range(count))
names, fetched = vertices("fetched.ply")
assert "scalar" in names and "red" in names, names
assert (names, fetched) == vertices("extracted.ply"), (names, vertices("extracted.ply")[0])
report = json.load(open("extracted.json"))
assert (report["color_by"], report["color_range"]) == ("run.hot_cold.t0001", [-30, 10]), report
EOPY
ends 2 "--color-by" "$server" extract run/run.pressure.t0001.mtd --color-by run/run.hot_cold.t0001.mtd -o x.ply --report run/run.hot_cold.t0001.mtd
ends 2 "need color_by" "$server" extract run/run.pressure.t0001.mtd --color-range 1,2 -o x.ply
"$server" extract organs --color-by whole.mtd -o colored.glb --quiet
grep -aq COLOR_0 colored.glb || fail "the surfaces of a folder are not colored"
ends 2 "has several fields, and isovalues are for one. Choose one with --dataset: \"run.hot_cold\"" "$client" fetch --server "$url" --dataset run --isovalue 1 -o x.ply
ends_well runs "$pid"
sed 's/TimeValue/other/' in/run_9.vti >in/run_11.vti
ends 0 "4 members, 0 failed" "$server" prepare in/run_*.vti --time-series timeless --field pressure -o frames
says frames/timeless.pressure.t0003.mtd 'time 3'
rm in/run_11.vti
ends 1 "members of a series must have the same grid" "$server" prepare in/run_9.vti in/small.vti --time-series mixed --field pressure -o mixed
ends 2 "has no field density. Its fields are pressure, hot/cold" "$server" prepare in/run_2.vti --field density -o run
ends 2 "no '/'" "$server" prepare in/run_9.vti --time-series a/b --field pressure -o mixed
ends 0 "has only one time" "$server" prepare in/run_9.vti --all-times --field pressure -o one_time
ends 0 "2 members, 0 failed" "$server" prepare in/run_2.vti --field all -o one_time
ends 0 "arrays, 'pressure' is used" "$server" prepare in/run_2.vti -o one_array.mtd
says one_time/run_2.pressure.mtd '"run_2", field pressure'

ends 0 "4 members, 0 failed" "$server" prepare in/cells.zarr --all-times --field all -o cells
grep -qF 'the window of channel 1 from 9 to 9 is ignored' out || fail "an empty window without a notice: $(cat out)"
says cells/cells.DNA.t0001.mtd '10 to 200'
ends 2 "color_anyway" "$server" extract beat/beat.t0000.mtd --isovalue 0.5 --color-by cells/cells.DNA.t0000.mtd -o x.ply
"$server" info cells/cells.DNA.t0001.mtd --json | tr -d ' \n' | grep -qF '"display_window":[10.0,200.0]' || fail "the display window is not in the report"
"$server" info cells/cells.actin.t0001.mtd --json | tr -d ' \n' | grep -qF '"display_window":null' || fail "an empty display window is taken"
says cells/cells.actin.t0001.mtd '"cells", field actin, time 0.5 s'
says cells/cells.DNA.t0000.mtd '"cells", field DNA, time 0 s, #0000ff'
ends 0 "2 members, 0 failed" "$server" prepare in/nuclei.zarr --label all -o nuclei
says nuclei/nuclei.label1.mtd 'label 1 (#ff0010)'
says nuclei/nuclei.label2.mtd 'label 2 (nucleus)'

# --- HDF5 with two fields over times, written by h5py
if [ -n "${2:-}" ]; then
  "$2" - <<'EOPY'
import h5py, numpy
with h5py.File("in/flow.h5", "w") as file:
    samples = numpy.arange(2 * 4 * 5 * 6, dtype="<i2").reshape(2, 4, 5, 6)
    file["a/p"] = samples
    file["a/q"] = -samples
    file["b/q"] = samples + 7
    file["mask"] = samples[0]
    file["time"] = [0.0, 1.5]
    file["time"].attrs["units"] = "milliseconds"
    file["time"].make_scale("time")
    file["a/p"].dims[0].attach_scale(file["time"])
EOPY
  ends 2 "prepare several of one shape with --field" "$server" prepare in/flow.h5 -o flow.mtd
  ends 0 "6 members, 0 failed" "$server" prepare in/flow.h5 --all-times --field all -o flow
  says flow/flow.p.t0001.mtd '"flow", field p, time 1.5 ms'
  "$2" - <<'EOPY'
import h5py, numpy
with h5py.File("in/odd.h5", "w") as file:
    for name in ("a", "bell\x07name", "q"):
        file[name] = numpy.arange(120, dtype="<i2").reshape(4, 5, 6)
EOPY
  ends 0 "field '/bell\\x07name' is skipped" "$server" prepare in/odd.h5 --field all -o odd
  [ -f odd/odd.a.mtd ] && [ -f odd/odd.q.mtd ] || fail "a field that has a name is left out"
  says flow/flow.b_q.t0001.mtd '"flow", field b/q, time 1.5 ms'
  says flow/flow.b_q.t0001.mtd '127 to 246'
  ends 0 "1 member" "$server" prepare in/flow.h5 --field p --time 1 -o flow_one
  ends 2 "Its fields are p, a/q, b/q." "$server" prepare in/flow.h5 --field mask -o flow
  # DICOM with two images at each of four positions.
  "$2" - <<'EOPY'
import pathlib, pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
pathlib.Path("in/gated").mkdir()
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
    data.PixelData = b"".join((1000 * (number // 4) + i).to_bytes(2, "little") for i in range(36))
    data.save_as(f"in/gated/{number}.dcm", write_like_original=False)
EOPY
  ends 2 "prepare them with --all-times" "$server" prepare in/gated -o gated.mtd
  for number in 0 1 2 3; do cp "in/gated/$number.dcm" "in/first_$number.dcm"; done
  ends 0 "4 i16" "$server" prepare 'in/first_*.dcm' -o first.mtd
  says first.mtd '0 to 35'
  ends 0 "2 members, 0 failed" "$server" prepare in/gated --all-times -o gated
  says gated/gated.t0001.mtd '1000 to 1035'
fi

# --- preparing a series again removes stale members, but none of another kind
mkdir again
for i in 1 2 3; do "$server" generate torus --size 9 --noise 0.01 --seed "$i" -o "again/v$i.nrrd" --quiet; done
ends 0 "3 members, 0 failed" "$server" prepare again/v1.nrrd again/v2.nrrd again/v3.nrrd --time-series v -o latest
"$server" prepare in/organs.seg.nrrd --label all --name organs -o latest --quiet
ends 0 "v.t0002.mtd: removed" "$server" prepare again/v1.nrrd again/v2.nrrd --time-series v -o latest
[ "$(ls latest | tr '\n' ' ')" = "organs.label3.mtd organs.label7.mtd v.t0000.mtd v.t0001.mtd " ] || fail "other members: $(ls latest)"
ends 0 "1 member, 0 failed" "$server" prepare in/organs.seg.nrrd --label 3 --name organs -o latest
[ -e latest/organs.label7.mtd ] || fail "a label that was not requested is removed"

# --- a dataset of another source is replaced only on request
"$server" prepare again/v1.nrrd -o kept.mtd --quiet
ends 2 "kept.mtd is a dataset prepared from 'v1.nrrd'" "$server" prepare again/v2.nrrd -o kept.mtd
ends 0 "kept.mtd" "$server" prepare again/v2.nrrd -o kept.mtd --force
