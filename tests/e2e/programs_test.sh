#!/usr/bin/env bash
# The programs as users run them: generate, prepare, info, extract, serve, list and fetch, with their error messages.
# Usage: programs_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
server=$bin/multitetra-server
client=$bin/multitetra-client
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"

# The value of a key in indented JSON, first occurrence.
value() { sed -n "s/^ *\"$2\": \"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}$/\1/p" "$1" | head -n 1; }
last_value() { sed -n "s/^ *\"$2\": \"\{0,1\}\([^\",]*\)\"\{0,1\},\{0,1\}$/\1/p" "$1" | tail -n 1; }

# --- every kind of volume is generated, prepared and extracted without a crack
for kind in sphere torus gyroid marschner-lobb box head; do
  "$server" generate "$kind" --size 33 --noise 0.01 -o "$kind.nrrd" --quiet
  "$server" prepare "$kind.nrrd" -o "$kind.mtd" --quiet
  "$server" info "$kind.mtd" --json >info.json
  [ "$(value info.json name)" = "$kind" ] || fail "the dataset of $kind.nrrd is not named $kind"
  "$server" verify "$kind.mtd" --quiet || fail "$kind.mtd is not whole"
  "$server" extract "$kind.mtd" -o "$kind.ply" --json --quiet >"$kind.json"
  [ "$(value "$kind.json" triangles)" -gt 0 ] || fail "$kind has no triangle"
  [ "$(value "$kind.json" open_edges)" = 0 ] || fail "$kind has open edges"
  [ "$(value "$kind.json" nonmanifold_edges)" = 0 ] || fail "$kind has non-manifold edges"
done
[ "$(value sphere.json euler_characteristic)" = 2 ] || fail "the sphere is none"

"$server" generate torus --size 33 -o torus.nrrd --quiet
"$server" prepare torus.nrrd -o torus.mtd --quiet
"$server" extract torus.mtd --isovalue 0 -o torus.ply --report report.json --json --quiet >torus.json
cmp -s torus.json report.json || fail "--report is not what --json prints: $(cat report.json)"
[ "$(value torus.json euler_characteristic)" = 0 ] || fail "the torus is none"

# --- all formats, coordinates and levels, and export of the model
for format in ply stl obj drc glb; do
  "$server" extract gyroid.mtd -o "mesh.$format" --coordinates index --quiet
  [ -s "mesh.$format" ] || fail "no mesh.$format"
done
"$server" reference gyroid.mtd -o level.ply --level 6 --model model.vtu --json --quiet >level.json
[ "$(value level.json tetrahedra)" = 768 ] || fail "level 6 has $(value level.json tetrahedra) tetrahedra, not 12 * 2^6"
grep -aq 'NumberOfCells="768"' model.vtu || fail "the model file does not hold 768 cells"
"$server" reference gyroid.mtd -o level.ply --level 6 --model model.vtu --model-scope surface --json --quiet >level.json
crossed=$(value level.json active_tetrahedra)
[ "$crossed" -lt 768 ] || fail "the surface crosses all of level 6"
grep -aq "NumberOfCells=\"$crossed\"" model.vtu || fail "the model file does not hold what the surface crosses"
ends 2 "--model" "$server" reference gyroid.mtd -o level.ply --model-scope surface
for errors in exact spectrum; do  # The dataset's errors are those of the reference, rounded up.
  "$server" reference gyroid.mtd -o reference.ply --error 0 --errors "$errors" --json --quiet >reference.json
  "$server" extract gyroid.mtd -o extracted.ply --error 0 --json --quiet >extracted.json
  [ "$(value reference.json content_digest)" = "$(value extracted.json content_digest)" ] || fail "the $errors errors give another surface"
done
python3 - reference.json extracted.json <<'END' || fail "reference and extract have different reports"
import json, sys
reference, extracted = (json.load(open(name)) for name in sys.argv[1:])
assert set(reference) - {"errors"} == set(extracted), set(reference) ^ set(extracted)
END

# --- certificates: meshes in every format; shifted, cut, and compared with another volume
"$server" generate gyroid --size 33 -o smooth.nrrd --quiet
"$server" prepare smooth.nrrd -o smooth.mtd --quiet
isovalue=$("$server" info smooth.mtd --json | grep -A 1 '"suggested_isovalues"' | sed -n '2s/[ ,]//gp')
certify() { "$server" certify "$1" --volume smooth.nrrd --isovalue "$isovalue" --quiet "${@:2}"; }
for format in ply stl obj glb vtp; do
  "$server" extract smooth.mtd --isovalue "$isovalue" --error 0.5 -o "smooth.$format" --quiet
  certify "smooth.$format" --error 0.5 --lattice 5 || fail "smooth.$format is not certified"
done
certify smooth.ply --error 0.5 --self-intersections --json >certificate.json
[[ $(value certificate.json lattice_allowance_world) =~ [1-9] ]] || fail "the lattice is not read from smooth.ply: $(cat certificate.json)"
[ "$(value certificate.json kept)" = true ] || fail "no certificate as JSON: $(cat certificate.json)"
[ "$(value certificate.json open_edges)" = 0 ] || fail "open edges: $(cat certificate.json)"
grep -q '"flat_triangles"' certificate.json || fail "self-intersections are not counted: $(cat certificate.json)"
"$server" extract smooth.mtd --isovalue "$isovalue" --error 0.5 -o index.ply --coordinates index --quiet
for error in 0 0.5; do  # Only simplification makes triangles that intersect others.
  "$server" extract smooth.mtd --isovalue "$isovalue" --error "$error" -o counted.ply --json >counted.json
  [ "$(grep -c '"self_intersecting_triangles": [0-9]' counted.json)" = "$([ "$error" = 0 ] && echo 0 || echo 1)" ] || fail "self-intersections at error $error: $(cat counted.json)"
done
for file in smooth.ply smooth.nrrd; do
  [ "$(grep -c "sha256\": \"$(sha256sum "$file" | cut -d' ' -f1)\"" certificate.json)" = 1 ] || fail "no digest of $file: $(cat certificate.json)"
done
certify index.ply --error 0.5 --lattice 5 --coordinates index || fail "not certified in sample indices"
ends 3 "NOT certified: smooth.ply" certify smooth.ply --error 0.01
ends 3 "NOT KEPT" certify smooth.ply --scale 1.1 --error 0.5
ends 3 "NOT KEPT" certify sphere.ply --error 1
certify sphere.ply --any-topology >/dev/null || fail "another topology is refused though it is allowed"
ends 1 "mesh.xyz" certify mesh.xyz
ends 1 "nowhere.nrrd" "$server" certify smooth.ply --volume nowhere.nrrd --isovalue 1
certify smooth.ply --error 0.5 --box 0,0,0,8,8,8 --json >boxed.json || fail "smooth.ply is not certified inside a box"
ends 2 "--box" certify smooth.ply --box 0,0,0,8,8,0
ends 2 "neither surface has a part inside" certify smooth.ply --box -90,-90,-90,-80,-80,-80
ends 3 "NOT KEPT" certify smooth.ply --space ras --error 0.5
ends 2 "--space" certify smooth.ply --coordinates index --space ras
ends 2 "--isovalue" "$server" certify smooth.ply --volume smooth.nrrd
"$server" prepare smooth.nrrd -o closed.mtd --outside -1000 --margin 1 --quiet  # The old names.
"$server" extract closed.mtd --isovalue "$isovalue" --error 0.5 -o closed.ply --quiet
ends 3 "--volume DATASET.mtd" certify closed.ply --error 0.5
"$server" certify closed.ply --volume closed.mtd --isovalue "$isovalue" --error 0.5 --quiet || fail "closed.ply is not certified with its dataset"
ends 2 "--pad" "$server" certify closed.ply --volume closed.mtd --isovalue "$isovalue" --margin 1

# --- raw files
head -c 4096 /dev/zero >zeros.raw
printf 'abcdef' | cat - zeros.raw >raw_with_header.raw
"$server" prepare raw_with_header.raw --dims 16,16,8 --type u16 --endian big --header-bytes 6 --spacing 1,1,2.5 \
  -o raw.mtd --outside 1 --margin 1 --quiet
for words in "--dims 16x16x8 --type uint16" "--dims 16X16X8 --type UInt16" "--dims=16,16,8 --type=ushort"; do
  # shellcheck disable=SC2086
  "$server" prepare raw_with_header.raw $words --endian big --header-bytes 6 --spacing 1,1,2.5 -o words.mtd --outside 1 --margin 1 --quiet
  [ "$("$server" info words.mtd --json | grep -v '"name"\|content')" = "$("$server" info raw.mtd --json | grep -v '"name"\|content')" ] ||
    fail "$words: $("$server" info words.mtd)"
done
ends 2 "--dims" "$server" prepare raw_with_header.raw --dims 16x16 --type u16 -o never.mtd
ends 2 "uint8" "$server" prepare raw_with_header.raw --dims 16x16x8 --type complex -o never.mtd
"$server" prepare sphere.nrrd -o microns.mtd --length-unit microns --quiet
[ "$(value <("$server" info microns.mtd --json) length_unit)" = µm ] || fail "microns: $("$server" info microns.mtd --json | grep unit)"
raw="raw_with_header.raw --dims 16,16,8 --type u16 --header-bytes 6"
for told in "" "--orient x,-y,-z" "--space LPS" "--length-unit um"; do
  # shellcheck disable=SC2086
  "$server" prepare $raw -o told.mtd --force $told >out 2>&1
  [ "$(grep -c "does not say which axis is up" out)" = "$([ -z "$told" ] && echo 1 || echo 0)" ] || fail "the axes with \"$told\": $(cat out)"
done
"$server" prepare sphere.nrrd -o turned.mtd --origin 1,2,3 --orient x,-z,y --quiet
"$server" info turned.mtd --json | tr -d ' \n' | grep -qF '"columns":[[1.0,0.0,0.0],[0.0,0.0,-1.0],[0.0,1.0,0.0]],"translation":[1.0,2.0,3.0]' ||
  fail "--orient x,-z,y: $("$server" info turned.mtd --json)"
ends 2 "--orient" "$server" prepare sphere.nrrd -o never.mtd --orient x,y,y
ends 2 "give -x,y,-z or x,-y,-z" "$server" prepare sphere.nrrd -o never.mtd --orient x,y,-z
ends 2 "without mirroring" "$server" prepare sphere.nrrd -o never.mtd --orient x,-y,-z --mirror
ends 2 "--mirror" "$server" prepare sphere.nrrd -o never.mtd --mirror
"$server" prepare sphere.nrrd -o mirrored.mtd --orient x,y,-z --mirror --quiet
"$server" info mirrored.mtd | grep -q -- "--orient x,y,-z --mirror" || fail "--mirror is not noted: $("$server" info mirrored.mtd)"
ends 2 "4102" "$server" prepare raw_with_header.raw --dims 16,16,9 --type u16 -o never.mtd
[ ! -e never.mtd ] || fail "a failed prepare left a file"

# --- several volumes and a folder of volumes: failures are reported, up-to-date datasets stay
mkdir -p many/inside
cp gyroid.nrrd many/a.nrrd
cp sphere.nrrd many/inside/b.nrrd
printf 'NRRD0004\nbroken' >many/broken.nrrd
echo "no volume" >many/notes.txt
ends 1 "3 volumes, 1 failed" "$server" prepare many -o datasets
ends 0 "b.nrrd: up to date" "$server" prepare many/a.nrrd many/inside/b.nrrd -o datasets
cp torus.nrrd many/a.nrrd
ends 0 'a.nrrd: "a"' "$server" prepare many/a.nrrd many/inside/b.nrrd -o datasets
ends 0 'b.nrrd: "b"' "$server" prepare many/inside/b.nrrd many/a.nrrd -o datasets --margin 1
ends 0 'a.nrrd: "other"' "$server" prepare many/a.nrrd -o datasets --name other
[ -e datasets/other.mtd ] || fail "--name names no file of a folder"
ends 0 'inside.mtd: "b"' "$server" prepare many/inside -o inside.mtd
ends 2 "give a folder" "$server" prepare many -o one.mtd
mkdir -p empty
ends 2 "There is no volume in empty" "$server" prepare empty -o empty.mtd
ends 2 "There is no volume in empty" "$server" prepare empty -o new_folder
[ ! -e new_folder ] || fail "a folder was left in which there is nothing"
ends 2 "--component" "$server" prepare many/a.nrrd -o a.mtd --component last
ends 0 "OME-Zarr" "$server" formats

# --- a file that crashes its reader is refused, as a volume and as a threshold grid
{ printf '# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nPOINT_DATA 24\nSCALARS s '
  head -c 5000 /dev/zero | tr '\0' x
  printf ' 1\nLOOKUP_TABLE default\n'; head -c 48 /dev/zero; } >crash.vtk
ends 2 "crash.vtk" "$server" prepare crash.vtk -o crash.mtd
ends 2 "crash.vtk" "$server" extract gyroid.mtd --error 1 --threshold-grid crash.vtk -o x.ply

# --- grids beyond 4096 steps, with the finest lattice that their coordinates allow
head -c 20000 /dev/zero | tr '\0' 'x' >long.raw
"$server" prepare long.raw --dims 5000,2,2 -o long.mtd --quiet
ends 2 "at most 7" "$server" extract long.mtd --isovalue 1 --error 1 --lattice 8 -o x.ply

# --- the file is what its report says, far from the origin, too
"$server" prepare sphere.nrrd --origin 500000,5400000,120 --spacing 0.5,0.5,0.5 -o far.mtd --force --quiet
for format in ply obj vtp glb; do
  "$server" extract far.mtd --isovalue 0 --error 0 -o "far.$format" --json --quiet >far.json
  "$server" certify "far.$format" --volume far.mtd --isovalue 0 --error 0 --lattice 5 --json --quiet >certificate.json
  python3 - <<'END' || fail "far.$format is not what its report says: $(cat far.json certificate.json)"
import json
report, found = json.load(open("far.json")), json.load(open("certificate.json"))
assert found["kept"] and report["written"]["degenerate_triangles"] == 0
for key in "triangles", "vertices", "euler_characteristic", "components", "nonmanifold_edges":
    assert report[key] == report["written"][key] == found["mesh"][key], key
END
done
for format in stl drc; do
  ends 2 "--coordinates index, or --shift -500000,-5400000," "$server" extract far.mtd --isovalue 0 --error 0 -o "far.$format"
  "$server" extract far.mtd --isovalue 0 --error 0 --shift -500000,-5400000,0 -o "far.$format" --report far.json --quiet
  grep -q '"shift"' far.json || fail "the shift is not in the report"
  "$server" certify "far.$format" --volume far.mtd --isovalue 0 --error 0 --lattice 5 --shift -500000,-5400000,0 --quiet
done
printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 1\nencoding: ascii\n\n1 2 3 4\n' >slice.nrrd
ends 2 "a single slice has no surface" "$server" prepare slice.nrrd -o never.mtd
"$server" prepare slice.nrrd --outside 0 --margin 1 -o slice.mtd --quiet
printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n%s\n' "$(yes nan | head -8 | tr '\n' ' ')" >void.nrrd
ends 2 "all its samples are void" "$server" prepare void.nrrd -o never.mtd
printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n%s\n' "$(yes 1152921504606846976 | head -8 | tr '\n' ' ')" >constant.nrrd
"$server" prepare constant.nrrd -o constant.mtd --quiet

# --- serving and fetching
start server "$server" serve . --tcp 127.0.0.1:0 --http 127.0.0.1:0
url=$(url_of server tcp)

"$client" list --server "$url" | grep -q gyroid || fail "list does not name gyroid"
for dataset in gyroid head torus; do
  for error in 0 0.7; do
    "$client" fetch --server "$url" --dataset "$dataset" --error "$error" -o fetched.ply --report report.json \
      --save-steps steps --quiet
    for threads in 1 2 4; do
      "$server" extract "$dataset.mtd" --error "$error" -o extracted.ply --threads "$threads" --json --quiet >extract.json
      [ "$(last_value report.json content_digest)" = "$(value extract.json content_digest)" ] ||
        fail "$dataset at error $error: the fetched mesh is not the one extracted with $threads threads"
    done
    # All ways to a file give the same bytes.
    for format in ply glb obj vtp; do
      "$client" fetch --server "$url" --dataset "$dataset" --error "$error" -o "fetched.$format" --quiet
      "$server" extract "$dataset.mtd" --error "$error" -o "extracted.$format" --quiet
      python3 -c 'import sys, urllib.request; open(sys.argv[2], "wb").write(urllib.request.urlopen(sys.argv[1]).read())' \
        "$(url_of server http)/v1/datasets/$dataset/isosurface?format=$format&error=$error" "served.$format"
      cmp "fetched.$format" "extracted.$format" || fail "$dataset at error $error: fetch and extract write different bytes"
      cmp "served.$format" "extracted.$format" || fail "$dataset at error $error: HTTP and extract send different bytes"
    done
  done
done
ls steps/step_0.ply >/dev/null || fail "no saved step"

# Threshold maps with parts of all kinds, on both command lines.
{ printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\nspace dimension: 3\n'
  printf 'space directions: (12,0,0) (0,90,0) (0,0,90)\nspace origin: (6,45,45)\n\n1.5 nan\n'; } >grid.nrrd
map=(--error 3 --region ball:9,9,9,7=0.1 --region box:9,9,25,30,30,30=0.6 --region-coordinates index
  --view eye=-20,10,10,fov=50,height=400,pixels=8,look=20,10,10,outside=4 --threshold-grid grid.nrrd)
for combine in order minimum; do
  "$client" fetch --server "$url" --dataset gyroid "${map[@]}" --combine "$combine" -o fetched.ply --report report.json --quiet
  "$server" extract gyroid.mtd "${map[@]}" --combine "$combine" -o extracted.ply --json --quiet >extract.json
  [ "$(last_value report.json content_digest)" = "$(value extract.json content_digest)" ] ||
    fail "with a threshold map ($combine) the fetched mesh is not the extracted one"
  grep -q '"radius"' report.json || fail "the report has no threshold map"
done
# With a budget both programs make the same mesh.
for budget in "--max-triangles 3000" "--max-bytes 9000"; do
  # shellcheck disable=SC2086
  "$client" fetch --server "$url" --dataset gyroid --error 0 $budget -o fetched.ply --report report.json --quiet
  # shellcheck disable=SC2086
  "$server" extract gyroid.mtd --error 0 $budget -o extracted.ply --json --quiet >extract.json
  [ "$(last_value report.json content_digest)" = "$(value extract.json content_digest)" ] ||
    fail "with $budget the fetched mesh is not the extracted one"
done
[ "$("$client" estimate --server "$url" --dataset gyroid --error 0.7 --json | grep -c '"triangles"')" = 1 ] || fail "no estimate"
[ "$("$client" estimate --server "$url" --dataset gyroid --error 0.7 --json | grep -cE '"triangles_(least|most)"')" = 2 ] || fail "no range of triangles"
"$client" fetch --server "$url" --dataset gyroid --error 3 -o coarse.ply --quiet
[ "$(stat -c %s coarse.ply)" -lt "$(stat -c %s fetched.ply)" ] || fail "a finer region gives no larger mesh"
ends 2 "does not begin with a shape" "$client" fetch --server "$url" --dataset gyroid --region cone:1=2 -o x.ply
ends 2 "regions[0].ball.radius" "$client" fetch --server "$url" --dataset gyroid --region ball:1,2,3,-4=2 -o x.ply
ends 2 "the file does not exist" "$client" fetch --server "$url" --dataset gyroid --threshold-grid none.nrrd -o x.ply
# Snapshots are reproducible and change with the view.
"$client" snapshot --server "$url" --dataset gyroid --size 320x200 -o once.png --quiet
"$client" snapshot --server "$url" --dataset gyroid --size 320x200 --threads 3 -o twice.png --json >snapshot.json
cmp once.png twice.png || fail "the same picture has other bytes the second time"
[ "$(value snapshot.json width)" = 320 ] && [ "$(value snapshot.json triangles)" -gt 0 ] || fail "the report of snapshot"
"$client" snapshot --server "$url" --dataset gyroid --size 320x200 --wireframe --shading facets -o wires.png --quiet
! cmp -s once.png wires.png || fail "a picture with wires is the same as without"
"$client" snapshot --server "$url" --dataset gyroid --size 320x200 --bare -o bare.png --quiet
! cmp -s once.png bare.png || fail "--bare leaves the scale bar"
"$client" snapshot --server "$url" --dataset gyroid --size 320x200 --azimuth 80 -o aside.png --quiet
"$client" snapshot --server "$url" --dataset gyroid --size 320x200 --up -y -o up.png --quiet
! cmp -s once.png up.png || fail "--up changes nothing"
ends 2 "--up" "$client" snapshot --server "$url" --dataset gyroid --up w -o x.png
! cmp -s once.png aside.png || fail "a picture from the side is that from the front"

# --- several surfaces: parts of one GLB, or a file each; one picture; one budget
two="--server $url --dataset gyroid --isovalue -0.5,0.5"
"$client" fetch $two --error 1 -o both.glb --json --quiet >both.json
[ "$(grep -c '"mesh_file": "both.glb"' both.json)" = 2 ] || fail "the report of two surfaces"
grep -aq '"name":"isovalue -0.5"' both.glb && grep -aq '"name":"isovalue 0.5"' both.glb || fail "a GLB without both parts"
[ "$("$client" fetch $two --error 1 -o both.glb 2>&1 | grep -c 'both.glb written')" = 1 ] || fail "one file is named twice"
"$client" fetch $two --error 1 -o both.ply --save-steps both_steps --quiet
[ -s both_-0.5.ply ] && [ -s both_0.5.ply ] && [ ! -e both.ply ] || fail "a file for each surface"
[ -s both_steps/isovalue_0.5/step_0.ply ] || fail "steps of each surface"
cmp -s both_-0.5.ply both_0.5.ply && fail "two isovalues, one surface"
for suffix in glb ply; do
  "$client" fetch $two --error 1 -o "fetched_both.$suffix" --quiet
  ends 0 "isovalue 0.5, " "$server" extract gyroid.mtd --isovalue -0.5,0.5 --error 1 -o "extracted_both.$suffix" --report both.json
done
for file in both.glb both_-0.5.ply both_0.5.ply; do
  [ "$(stat -c %s "fetched_$file")" = "$(stat -c %s "extracted_$file")" ] || fail "fetch and extract write another $file"
done
[ "$(grep -c '"mesh_file": "extracted_both_-\{0,1\}0.5.ply"' both.json)" = 2 ] || fail "the report of two extracted surfaces: $(cat both.json)"
ends 2 "are for one isovalue" "$server" extract gyroid.mtd --isovalue -0.5,0.5 --max-triangles 3000 -o never.ply
ends 6 "never_1e+09.ply is not written" "$server" extract gyroid.mtd --isovalue 0.5,1e9 -o never.ply
[ ! -e never_0.5.ply ] || fail "one of two surfaces was written by extract"
"$client" fetch $two --error 0 --max-triangles 3000 -o budget.ply --json --quiet >budget.json
[ "$(sed -n 's/^ *"triangles": \([0-9]*\),*$/\1/p' budget.json | sort -n | tail -n 1)" -le 3000 ] || fail "a budget is for all surfaces"
ends 2 "cannot be shared" "$client" fetch $two --max-triangles 1 -o never.ply
ends 6 "never_1e+09.ply is not written" "$client" fetch --server "$url" --dataset gyroid --isovalue 0.5,1e9 -o never.ply
[ ! -e never_0.5.ply ] || fail "one of two surfaces was written"
ends 2 "one surface" "$client" estimate $two
"$client" snapshot $two --size 320x200 --opacity 0.4,1 --surface-color '#ff0000,#0000ff' -o both.png --json >both.json
[ "$(grep -c '"is_empty": false' both.json)" = 2 ] || fail "two surfaces in a picture"
ends 2 "opacity" "$client" snapshot $two --opacity 0.1,0.2,0.3 -o never.png
ends 2 "opacity" "$client" snapshot $two --opacity 0 -o never.png
ends 2 "#dd8265" "$client" snapshot $two --surface-color red -o never.png

# Files to print have notices of open edges and self-intersections, others have not.
for command in "$client fetch --server $url --dataset marschner-lobb" "$server extract marschner-lobb.mtd"; do
  ends 0 "cannot be printed: it ends at the border of the data" $command --error 1 -o printed.stl
  ends 0 " that intersect others; --intersection-free avoids them." $command --error 2 -o printed.stl
  $command --error 2 -o printed.ply --quiet >out 2>&1 && ! grep "printed\|intersection-free" out || fail "a notice of a .ply: $(cat out)"
done
ends 0 "The budget raised the error from 0.5 to" "$client" fetch --server "$url" --dataset gyroid --error 0.5 --max-bytes 4KB -o x.ply
ends 0 "The budget raised the error from 0.5 to" "$server" extract gyroid.mtd --error 0.5 --max-bytes 4KB -o x.ply

# Empty surfaces are reported, and written only with --allow-empty.
for command in "$client snapshot --server $url --dataset gyroid -o nothing.png" \
  "$client fetch --server $url --dataset gyroid -o nothing.ply" "$server extract gyroid.mtd -o nothing.obj"; do
  ends 6 'there is no surface at isovalue 1e+09; values of "gyroid" range from' $command --isovalue 1e9
  ends 6 "the surface is empty" $command --isovalue 1e9 --quiet
  ! grep -q "Notice:" out || fail "--quiet prints notices: $(cat out)"
  ends 6 '"is_empty": true' $command --isovalue 1e9 --json
  ! ls nothing.* 2>/dev/null || fail "an empty surface was written by $command"
  ends 0 "The surface is empty" $command --isovalue 1e9 --allow-empty
  [ "$(ls nothing.* | wc -l)" = 1 ] || fail "--allow-empty wrote nothing: $command"
  rm nothing.*
done
ends 6 '"mesh_file": null' "$client" fetch --server "$url" --dataset gyroid --isovalue 1e9 -o x.ply --json
ends 6 'empty' "$client" fetch --server "$url" --dataset gyroid --isovalue 1e9 -o x.ply
grep -q 'topology preserved *empty' out || fail "an empty mesh preserves a topology"
ends 0  '"notices": [' "$client" estimate --server "$url" --dataset gyroid --isovalue 1e9 --json
# Notices for regions without data; errors for invalid boxes.
ends 0 "Region 2 is outside" "$client" fetch --server "$url" --dataset gyroid --region-coordinates index --region ball:9,9,9,3=0 \
  --region ball:90,90,90,3=0 -o x.ply
ends 0 "from (0, 0, 0) to (32, 32, 32) in sample indices" "$server" extract gyroid.mtd --region-coordinates index \
  --region halfspace:0,0,1,40=0 -o x.ply
ends 2 "low corner above its high corner along y" "$client" fetch --server "$url" --dataset gyroid --region box:1,9,1,9,1,9=0 -o x.ply
ends 2 "1280x960" "$client" snapshot --server "$url" --dataset gyroid --size 12by9 -o x.png
ends 2 "PNG" "$client" snapshot --server "$url" --dataset gyroid -o x.jpg
ends 2 '--dataset: "a", "b", "box" and ' "$client" snapshot --server "$url" -o x.png
ends 0 "more than --max-bytes" "$server" extract gyroid.mtd --error 0 --max-bytes 20KB -o x.stl
ends 0 "more than --max-bytes" "$client" fetch --server "$url" --dataset gyroid --error 0 --max-bytes 20KB -o x.stl
# Files omit small components and reports count them; the whole surface is checked.
"$server" generate head --size 33 --noise 120 --seed 3 -o dusty.nrrd --quiet
"$server" prepare dusty.nrrd -o dusty.mtd --quiet
"$server" extract dusty.mtd --isovalue 100 --error 0 -o whole.ply --json --quiet >whole.json
"$server" extract dusty.mtd --isovalue 100 --error 0 --min-component 12 -o large.ply --json >large.json 2>err.txt
all=$(value whole.json components_written)
few=$(value large.json components_written)
[ "$all" = "$(value whole.json components)" ] && [ "$few" -ge 1 ] && [ "$few" -lt "$all" ] || fail "components: $few of $all"
grep -q "The file has $few of .* components, those with a diagonal of 12 samples or more" err.txt || fail "removed components are not reported: $(cat err.txt)"
[ "$(value whole.json content_digest)" = "$(value large.json content_digest)" ] || fail "another surface without dust"
[ "$(stat -c %s large.ply)" -lt "$(stat -c %s whole.ply)" ] || fail "no triangle is left out"
ends 6 "is empty" "$server" extract dusty.mtd --isovalue 100 --min-component 1000 -o none.ply
# Certificates ignore removed components if the file or an option names their size.
dust() { "$server" certify "$1" --volume dusty.nrrd --isovalue 100 --error 0 --lattice 5 --quiet "${@:2}"; }
dust large.ply || fail "large.ply is not certified"
"$server" extract dusty.mtd --isovalue 100 --error 0 --min-component largest -o largest.ply --json >largest.json 2>/dev/null
[ "$(value largest.json triangles_written)" -lt "$(value largest.json triangles)" ] || fail "triangles_written counts the whole surface: $(cat largest.json)"
ends 0 "whole surface: $("$server" extract dusty.mtd --isovalue 100 --error 0 -o x.ply 2>/dev/null | sed -n 's/.*, \(.* triangles\),.*/\1/p')" \
  "$server" extract dusty.mtd --isovalue 100 --error 0 --min-component largest -o x.ply
[ "$(value largest.json components_written)" = 1 ] || fail "the largest component is not alone: $(cat largest.json)"
dust largest.ply || fail "largest.ply is not certified"
"$server" extract dusty.mtd --isovalue 100 --error 0 --min-component 12 -o large.glb --quiet
ends 3 "compare without them: --min-component" dust large.glb
dust large.glb --min-component 12 || fail "large.glb is not certified with --min-component"
ends 3 "NOT KEPT" dust whole.ply --min-component 12
# Measures are those of the components in the file.
start dusty "$server" serve dusty.mtd --tcp 127.0.0.1:0 --http off
dusty="--server $(url_of dusty tcp) --isovalue 100 --error 0 --quiet"
"$client" fetch $dusty -o x.ply --report whole.json
"$client" fetch $dusty --min-component 12 -o x.ply --report large.json
python3 - whole.json large.json <<'END' || fail "measures count components that are not written"
import json, sys
whole, large = (json.load(open(name)) for name in sys.argv[1:])
assert large["components_written"] < whole["components_written"]
assert 0 < large["area"] < whole["area"]
END
"$server" extract dusty.mtd --isovalue 100 --error 0 --min-component 12 -o x.ply --report own.json --quiet
python3 - own.json large.json <<'END' || fail "extract reports other measures than fetch"
import json, math, sys
own, fetched = (json.load(open(name)) for name in sys.argv[1:])
transfer = {"server", "final_only", "tiles_held", "tiles_received", "bytes_received", "reconnections", "steps"}
assert set(fetched) - transfer == set(own) - {"seconds"}, set(fetched) ^ set(own)
for key in "area", "is_full_resolution", "volume", "volume_reason", "volume_bound":
    # The order of summation differs.
    same = math.isclose(own[key], fetched[key], rel_tol=1e-12) if isinstance(own[key], float) else own[key] == fetched[key]
    assert same, (key, own[key], fetched[key])
END
# A client stops at its deadline, however large the surface is.
ends 1 "Timed out before" "$client" fetch --server "$url" --dataset gyroid --error 0 --deadline 0.002 -o x.ply
ends 1 "127.0.0.1:1" "$client" fetch --server tcp://127.0.0.1:1 --deadline 0.1 -o x.ply
"$client" fetch --server "$url" --dataset gyroid --error 1 --deadline 60 -o x.ply --quiet || fail "a long deadline is too short"
# Errors are printed in the unit of the request.
"$client" estimate --server "$url" --dataset gyroid --error 0.5 | grep -q 'at most 0.5 voxels (0.5 mm)' ||
  fail "an estimate in other units: $("$client" estimate --server "$url" --dataset gyroid --error 0.5)"
"$client" fetch --server "$url" --dataset gyroid --error 1 --region ball:9,9,9,3=2 -o x.ply 2>&1 >/dev/null |
  grep -q 'errors up to 2 voxels' || fail "errors of a map are printed in other units"
# Unwritable outputs are reported before anything is fetched or computed.
ends 1 "nowhere/x.ply" "$client" fetch --server tcp://127.0.0.1:1 --dataset gyroid -o nowhere/x.ply
ends 1 "nowhere/x.json" "$client" fetch --server tcp://127.0.0.1:1 --dataset gyroid -o x.ply --report nowhere/x.json
ends 1 "nowhere/x.png" "$client" snapshot --server tcp://127.0.0.1:1 --dataset gyroid -o nowhere/x.png
ends 2 "--report: ./x.ply is also written by --output" "$client" fetch --server tcp://127.0.0.1:1 --dataset gyroid -o x.ply --report ./x.ply
ends 1 "standard output" sh -c "'$client' list --server '$url' >/dev/full"
ends 1 "standard output" sh -c "'$server' info gyroid.mtd --json >/dev/full"

ends 1 '"nowhere"; it has "' "$client" fetch --server "$url" --dataset nowhere -o x.ply
ends 1 'it has "torus", ' "$client" fetch --server "$url" --dataset toru -o x.ply
grep -q '"torus"\(, "[^"]*"\)\{2\} and [0-9]* more\. Did you mean "torus"?' out || fail "all names are printed: $(cat out)"
ends 2 "error threshold" "$client" fetch --server "$url" --dataset gyroid --error -1 -o x.ply
ends 2 "suffix" "$client" fetch --server "$url" --dataset gyroid -o x.xyz
ends 2 "isovalue" "$client" fetch --server "$url" --dataset gyroid --isovalue nan -o x.ply
ends 1 "127.0.0.1:1" "$client" list --server tcp://127.0.0.1:1
ends_well server "$pid"

# --- errors are explained
ends 2 "missing.nrrd" "$server" prepare missing.nrrd -o x.mtd
# Inputs are never overwritten, under any name, nor files that are not datasets.
cp torus.nrrd volume.nrrd
ln -s volume.nrrd link.mtd
sum=$(sha256sum <volume.nrrd)
ends 2 "input" "$server" prepare volume.nrrd -o volume.nrrd
ends 2 "input" "$server" prepare volume.nrrd -o ./volume.nrrd --force
ends 2 "input" "$server" prepare volume.nrrd -o link.mtd
ends 2 ".mtd" "$server" prepare volume.nrrd -o other.nrrd
cp volume.nrrd taken.mtd
ends 2 "is not a dataset" "$server" prepare volume.nrrd -o taken.mtd
ends 1 "nowhere/x.mtd" "$server" prepare volume.nrrd -o nowhere/x.mtd
ends 2 "file" "$server" reference torus.mtd -o mesh.ply --model torus.mtd
ends 2 "--model: mesh.ply is also written by --output" "$server" reference torus.mtd -o mesh.ply --model mesh.ply
[ "$sum" = "$(sha256sum <volume.nrrd)" ] && [ ! -e other.nrrd ] || fail "prepare wrote where it must not"
"$server" prepare volume.nrrd -o taken.mtd --force --quiet && "$server" prepare volume.nrrd -o taken.mtd --quiet ||
  fail "--force does not replace, or a dataset is not replaced without it"
ends 0 "--pad 1 closes them" "$server" prepare torus.nrrd -o x.mtd --pad-value 0
ends 2 "--pad-value" "$server" prepare torus.nrrd -o x.mtd --outside nothing
ends 2 "it is already a prepared dataset" "$server" prepare torus.mtd -o again.mtd
ends 1 "torus.nrrd" "$server" extract torus.nrrd -o x.ply
ends 2 "suffix" "$server" extract torus.mtd -o x.xyz
ends 2 "error threshold" "$server" extract torus.mtd -o x.ply --error nan
ends 5 "no dataset" "$server" serve missing.mtd --tcp 127.0.0.1:0 --http off
"$server" plot torus.mtd -o torus.svg --isovalues 8 --errors 0.5,2 --json >plot.json
"$server" plot torus.mtd -o torus.pdf --isovalues 8 --errors 0.5,2 --quiet
grep -q '</svg>' torus.svg && head -c 4 torus.pdf | grep -q '%PDF' || fail "plot does not write SVG and PDF"
[ "$(value plot.json plot_file)" = torus.svg ] || fail "the report of plot"
ends 2 "*.svg" "$server" plot torus.mtd -o torus.jpg
"$server" verify torus.mtd --json | grep -q '"is_whole": true' || fail "the report of verify"
mkdir folder
for name in a b c; do cp torus.mtd "folder/$name.mtd"; done
ends 0 "3 datasets, 0 damaged." "$server" verify folder
ends 0 '"torus" in folder/c.mtd' "$server" info folder
[ "$("$server" info folder --json | grep -c '"spectrum_bins"')" = 3 ] || fail "info does not list a whole folder as JSON"
printf 'x' | dd of=folder/a.mtd bs=1 seek=$(($(wc -c <torus.mtd) / 2)) conv=notrunc status=none
ends 1 "3 datasets, 1 damaged." "$server" verify folder
ends 1 'folder/b.mtd: all checksums match' "$server" verify folder
ends 2 "There is no dataset in empty" "$server" verify empty
ends 2 "Did you mean --isovalue" "$client" fetch --isovale 3
ends 2 "Did you mean snapshot" "$client" snapshoot
# Completions that bash offers at the end of a line.
offers() {
  local offered
  offered=$(source "$project/docker/debian/completion.bash" && COMP_WORDS=("${@:2}") && COMP_CWORD=$(($# - 2)) && _multitetra &&
    echo "${COMPREPLY[*]}")
  [ "$offered" = "$1" ] || fail "after \"${*:2}\" bash offers \"$offered\" and not \"$1\""
}
offers "fetch" "$client" fe
offers "snapshot" "$client" sn
offers "voxel world" "$client" fetch --unit ""
offers "--previews" "$client" fetch --pre
offers "" "$client" fetch --retries ""
offers "torus.mtd" "$server" info torus.m
"$client" --help-all | grep -e --previews >/dev/null || fail "--help-all lacks the options of a command"
ends 2 "cube" "$server" generate cube -o x.nrrd
ends 2 "2 to 4097" "$server" generate sphere --size 1 -o x.nrrd
head -c 2000 torus.mtd >cut.mtd
ends 1 "cut.mtd" "$server" info cut.mtd
cp torus.mtd damaged.mtd
printf 'x' | dd of=damaged.mtd bs=1 seek=$(($(wc -c <torus.mtd) / 2)) conv=notrunc status=none
ends 1 '"samples": brick' "$server" verify damaged.mtd
ends 1 '"samples"' "$server" extract damaged.mtd --error 0 -o x.ply
for command in generate prepare info plot verify extract reference serve token; do "$server" "$command" --help | grep Examples >/dev/null || fail "$command --help has no examples"; done
[ "$("$client" view --dataset "a head" --isovalue -300 --error 0.5 --region ball:1,2,3,4=0)" = \
  "http://127.0.0.1:7480/#dataset=a%20head&isovalue=-300&error=0.5&region=ball:1,2,3,4=0" ] || fail "another address of the viewer"
[ "$("$client" view --dataset a --min-component 12.5)" = "http://127.0.0.1:7480/#dataset=a&min_component=12.5" ] ||
  fail "the viewer's address does not name the hidden components"
[ "$("$client" view --dataset a --up -y)" = "http://127.0.0.1:7480/#dataset=a&up=-y" ] || fail "view --up is not in the address"
[ "$("$client" view --min-component largest)" = "http://127.0.0.1:7480/#min_component=largest" ] || fail "view --min-component largest"
ends 2 "--min-component" "$client" view --min-component -1
[ "$("$client" view --isovalue 1e30)" = "http://127.0.0.1:7480/#isovalue=1e30" ] || fail "a large isovalue is no number in the viewer's address"
[ "$(MULTITETRA_SERVER=wss://site.org/volumes/ "$client" view --dataset a)" = "https://site.org/volumes/#dataset=a" ] ||
  fail "view ignores MULTITETRA_SERVER"
[ "$("$client" view --server ws://h:7481)" = "http://h:7481/" ] && [ "$("$client" view --server tcp://h:7410)" = "http://h:7480/" ] ||
  fail "view ignores --server"
"$client" view --server tcp://h:7410 2>&1 >/dev/null | grep "at port 7480; --http" >/dev/null || fail "the guessed port is not reported"
[ -z "$("$client" view --server ws://h:7481 2>&1 >/dev/null)" ] || fail "a known port is reported as a guess"
"$client" view --region halfspace:1,0,0,2=0 2>/dev/null && fail "the viewer has no half-spaces"
for command in list estimate fetch snapshot view; do "$client" "$command" --help | grep Examples >/dev/null || fail "$command --help has no examples"; done
