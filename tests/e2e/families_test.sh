#!/usr/bin/env bash
# Families of datasets as users make and serve them: the labels of a segmentation, the times of a series, the fields of a
# simulation. Usage: families_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
server=$bin/multitetra-server
client=$bin/multitetra-client
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

# says FILE WORDS: the dataset's facts have them.
says() {
  "$server" info "$1" >facts.txt
  grep -qF -- "$2" facts.txt || fail "\"$2\" is not told of $1: $(cat facts.txt)"
}
digest() { sed -n 's/^ *"content_digest": "\([^"]*\)".*/\1/p' "$1" | tail -n 1; }

# --- labels: a ball of label 3 in one of label 7, as 3D Slicer writes segments
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
ends 0 "2 members, 0 failed" "$server" prepare in/organs.seg.nrrd --label all --name organs -o organs
ends 0 "organs.label7: up to date" "$server" prepare in/organs.seg.nrrd --label all --name organs -o organs
says organs/organs.label3.mtd '"organs", label 3 (liver, #dd8265)'
says organs/organs.label7.mtd '"organs", label 7 (rest of it)'
says organs/organs.label7.mtd 'suggested isovalues 0.5'
printf '3 hepar 1 2 3 255\n' >names.ctbl
ends 0 "organs.label7: up to date" "$server" prepare in/organs.seg.nrrd --label all --label-names names.ctbl --name organs -o organs
says organs/organs.label3.mtd '"organs", label 3 (hepar, #010203)'
ends 1 "label 4 does not occur in it. Its labels are 3, 7." "$server" prepare in/organs.seg.nrrd --label 4,3 -o some
[ -e some/organs.seg.label3.mtd ] || fail "after a label that is missing the others are not made"
ends 2 "Name those that you want, such as --label 3,7" "$server" prepare in/many.nrrd --label all -o some
ends 0 '"many.label1599"' "$server" prepare in/many.nrrd --label 1599 -o some
ends 2 "whole numbers such as 3,7, or all" "$server" prepare in/organs.seg.nrrd --label 3.5 -o some
ends 2 "all is for itself" "$server" prepare in/organs.seg.nrrd --label all,3 -o some
ends 2 "named twice" "$server" prepare in/organs.seg.nrrd --label 3,3 -o some
ends 2 "give a folder" "$server" prepare in/organs.seg.nrrd --label 3 -o some.mtd
ends 2 "line 1 is no label" "$server" prepare in/organs.seg.nrrd --label 3 --label-names in/organs.seg.nrrd -o some
ends 2 "exclude each other" "$server" prepare in/organs.seg.nrrd --label 3 --plan 2 -o some
ends 2 "for --label" "$server" prepare in/organs.seg.nrrd --label-names names.ctbl -o some
# The inner label's surface, and the hole in the outer one's field, which is the same.
"$server" extract organs/organs.label3.mtd --isovalue 0.5 --error 0 -o inner.ply --json --quiet >inner.json
grep -q '"euler_characteristic": 2' inner.json || fail "the surface of a ball's label is no ball"
"$server" extract organs/organs.label7.mtd --isovalue 0.5 --error 0 -o outer.ply --json --quiet >outer.json
grep -q '"euler_characteristic": 4' outer.json || fail "the surface of a shell's label is not two balls"

# --- served: they tell what they are, and one colours another
start server "$server" serve organs --tcp 127.0.0.1:0 --http 127.0.0.1:0
url=$(url_of server tcp)
http=$(url_of server http)
curl -s "$http/v1/datasets" >datasets.json
python3 - <<'EOPY' || fail "/v1/datasets does not tell members: $(cat datasets.json)"
import json
datasets = json.load(open("datasets.json"))["datasets"]
assert [d["member"]["label"] for d in datasets] == [
    {"value": 3, "name": "hepar", "color": "#010203"}, {"value": 7, "name": "rest of it", "color": None}], datasets
assert {d["member"]["family"] for d in datasets} == {"organs"}
EOPY
"$client" fetch --server "$url" --dataset organs.label3 --isovalue 0.5 --error 0 --color-by organs.label7 -o coloured.ply --report report.json --quiet
[ "$(digest report.json)" = "$(digest inner.json)" ] || fail "a fetched label is not the extracted one"
grep -aq "property float" coloured.ply || fail "no values of the other label at the vertices"
ends_well server "$pid"
