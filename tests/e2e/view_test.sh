#!/usr/bin/env bash
# `multitetra view` opens a volume in the browser with one command. Usage: view_test.sh DIRECTORY_OF_PROGRAMS
set -euo pipefail

bin=$(cd "$1" && pwd)
view=$bin/multitetra
server=$bin/multitetra-server
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$(dirname "${BASH_SOURCE[0]}")/../support/programs.sh"
export XDG_CACHE_HOME=$work/cache BROWSER=$work/browser
unset DISPLAY WAYLAND_DISPLAY MULTITETRA_HTTP

# A fake browser that records the addresses it opens.
cat >browser <<'END'
#!/bin/sh
echo "$1" >>"$(dirname "$0")/opened"
END
chmod +x browser

# starts NAME WORDS...: sets `url` to the server's address, without the settings of the page.
starts() {
  local name=$1
  start "$name" "$view" view --quiet "${@:2}"
  url=
  for _ in $(seq 1200); do
    url=$(sed -n 's/.*\(http:\/\/[^ ]*\).*/\1/p' "$name.log" | head -n 1)
    [ -z "$url" ] || break
    kill -0 "$pid" 2>/dev/null || break
    sleep 0.05
  done
  [ -n "$url" ] || { fail "view $* prints no address: $(cat "$name.log")"; return; }
  shown=${url#*&dataset=}
  token=${url#*#token=}
  token=${token%%&*}
  url=${url%%/#*}
  url=${url%/}
}
listed() { curl -s -H "Authorization: Bearer $token" "$url/v1/datasets"; }
names() {
  listed | python3 -c 'import json, sys; print(*sorted(d["name"] for d in json.load(sys.stdin)["datasets"]))'
}
# lists NAMES: waits until these datasets are listed, as some are prepared while others are served.
lists() {
  for _ in $(seq 600); do
    [ "$(names)" != "$1" ] || return 0
    sleep 0.05
  done
  fail "datasets \"$(names)\" instead of \"$1\""
}
# completes: waits until the errors of all datasets are computed.
completes() {
  for _ in $(seq 600); do
    list=$(listed)
    [[ "$list" == *'"name"'* && ! "$list" =~ '"missing":'\ *'"errors"' ]] && return
    sleep 0.05
  done
  fail "errors are missing: $list"
}
ends_by_interrupt() { ends_by INT; }  # Ctrl-C.
ends_by() {
  local status=0
  kill -"$1" "$pid"
  for _ in $(seq 200); do kill -0 "$pid" 2>/dev/null || break; sleep 0.05; done
  ! kill -0 "$pid" 2>/dev/null || { fail "still running after SIG$1"; kill -9 "$pid"; }
  wait "$pid" || status=$?
  [ "$status" = 0 ] || fail "exit code $status after SIG$1"
}
# volume FILE KIND: writes 12 samples per side; KIND is a function of x and y.
volume() {
  python3 - "$1" "$2" <<'END'
import sys
samples = bytes(eval(sys.argv[2], {"x": x, "y": y}) for _ in range(12) for y in range(12) for x in range(12))
header = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nspacings: 1 1 1\nencoding: raw\n\n"
open(sys.argv[1], "wb").write(header + samples)
END
}

# --- without a file: the demo volume; the browser opens the page
starts demo
[ "${shown%%&*}" = visible_female_head ] || fail "the demo shows $shown"
case "$shown" in
  *'&isovalue=-300.5&'*'&surfaces=300.5,'*) ;;
  *) fail "the demo does not show bone below the skin: $shown" ;;
esac
grep -qF "look='${shown#visible_female_head}'" "$project/server/demo.sh" || fail "demo.sh shows something else than $shown"
lists "visible_female_head"
# Everybody can read the words that the browser is started with: they lead to the page once, and hold no token.
opened=$(cat opened)
[[ "$opened" == "$url/open/"* && "$opened" != *"$token"* ]] || fail "the browser opened $opened"
followed() { curl -s -o /dev/null "$@" -w '%{http_code} %{redirect_url}' "$opened"; }
[ "$(followed -I)" = "404 " ] || fail "the link is used up by a look ahead"
[ "$(followed)" = "303 $url/#token=$token&dataset=$shown" ] || fail "the link leads to $(followed)"
[ "$(followed)" = "404 " ] || fail "the link leads to the page again"
[ "$(curl -s -o /dev/null -w '%{http_code}' "$url/v1/datasets")" = 401 ] || fail "others may list the datasets"
[ "$(curl -s -o /dev/null -w '%{http_code}' -H 'Host: other.example' "$url/")" = 421 ] || fail "the page answers to other names"
curl -s "$url/" | grep -qi '<html\|no viewer' || fail "no page at $url/"
ends_by HUP  # The terminal was closed.

# --- prepared datasets are found again by content, also in another folder
mkdir volumes  # Volumes are prepared again when there are newer files beside them, which may belong to them.
volume volumes/bar.nrrd '20 * x + y'
starts first --no-browser volumes/bar.nrrd
lists "bar"
completes
ends_by_interrupt
made=$(ls cache/multitetra/datasets/bar-*/bar.mtd)
"$server" prepare volumes/bar.nrrd -o bar.mtd --quiet
cmp bar.mtd "$made" || fail "view makes another dataset than prepare"
before=$(stat -c %Y.%i "$made")
starts again --no-browser volumes/bar.nrrd
ends_by_interrupt
[ "$(stat -c %Y.%i "$made")" = "$before" ] || fail "the same volume was prepared twice"
volume volumes/bar.nrrd '255 - 20 * x - y'
starts changed --no-browser volumes/bar.nrrd
ends_by_interrupt
[ "$(ls cache/multitetra/datasets | grep -c '^bar-')" = 2 ] || fail "another volume of that name was not prepared"
[ "$(wc -l <opened)" = 1 ] || fail "--no-browser opened one"

# A large file contains its samples and is found in any folder; a small one may be the header of others beside it.
mkdir here there
"$server" generate torus --size 65 -o here/torus.nrrd --quiet
[ "$(stat -c %s here/torus.nrrd)" -gt 1048576 ] || fail "the volume is too small"
for folder in here there; do
  [ "$folder" = here ] || cp here/torus.nrrd there
  starts "large_$folder" --no-browser "$folder/torus.nrrd"
  lists "torus"
  completes
  ends_by_interrupt
  stat -c %Y.%i cache/multitetra/datasets/torus-*/torus.mtd >"made_$folder"
done
cmp made_here made_there || fail "a copy of a volume in another folder was prepared again"

# --- borders are those of `prepare`; another border makes another dataset
starts closed --no-browser --pad-value 0 --pad 1 volumes/bar.nrrd
ends_by_interrupt
found=0
for made in cache/multitetra/datasets/bar-*/bar.mtd; do
  "$server" info "$made" | grep -q 'outside.* 0 (value beyond the data)' && found=$((found + 1))
done
[ "$found" = 1 ] || fail "view --outside 0 made $found datasets with that value"
if "$view" view --no-browser --pad-value nothing volumes/bar.nrrd 2>err.txt; then fail "--pad-value nothing is taken"; fi
grep -q 'write void or a finite number' err.txt || fail "--pad-value nothing: $(cat err.txt)"

# --- the cache is bounded: the least recently used dataset is evicted, displayed ones stay
starts bounded --no-browser --cache-dir-bytes 1 volumes/bar.nrrd
for _ in $(seq 200); do [ "$(ls cache/multitetra/datasets | wc -l)" = 2 ] && break; sleep 0.05; done
[ "$(ls cache/multitetra/datasets | wc -l)" = 2 ] || fail "the cache keeps $(ls cache/multitetra/datasets)"
lists "bar"
ends_by_interrupt
[ -z "$(find cache/multitetra -perm /077)" ] || fail "others may read $(find cache/multitetra -perm /077)"
rm -rf cache

# --- a cache deletes nothing but its own entries, and shares no folder with other files or users
mkdir -p mine/thesis mine/photos marked shared
echo text >mine/thesis/thesis.tex
ends 2 "holds files that are not of this cache" "$view" view --no-browser --cache-dir mine --cache-dir-bytes 1 volumes/bar.nrrd
chmod o+w shared
ends 2 "other users may write" "$view" view --no-browser --cache-dir shared volumes/bar.nrrd
starts marked --no-browser --cache-dir marked volumes/bar.nrrd
ends_by_interrupt
mkdir marked/thesis marked/datasets/thesis marked/datasets/photos-0123456789abcdef
cp mine/thesis/thesis.tex marked/thesis
cp mine/thesis/thesis.tex marked/datasets/thesis
cp mine/thesis/thesis.tex marked/datasets/photos-0123456789abcdef
volume volumes/other.nrrd '7 * x + y'
starts evicts --no-browser --cache-dir marked --cache-dir-bytes 1 volumes/other.nrrd
for _ in $(seq 200); do [ "$(ls -d marked/datasets/bar-* 2>/dev/null)" ] || break; sleep 0.05; done
[ -z "$(ls -d marked/datasets/bar-* 2>/dev/null)" ] || fail "the cache has no limit: $(ls marked/datasets)"
ends_by_interrupt
[ "$(find mine marked -name thesis.tex | wc -l)" = 4 ] || fail "files of others were deleted: $(find mine marked)"
TMPDIR=$work/tmp
mkdir "$TMPDIR"
export TMPDIR
starts uncached --no-browser --no-cache volumes/bar.nrrd
lists "bar"
ends_by_interrupt
[ ! -e cache ] || fail "--no-cache keeps $(find cache)"
[ -z "$(ls "$TMPDIR")" ] || fail "--no-cache leaves $(ls "$TMPDIR")"

# --- consecutively numbered files are one series, other files are separate datasets
mkdir flow
for i in 1 2 3; do volume "flow/flow_$i.nrrd" "10 * x + y + $i"; done
starts series --no-browser flow
lists "flow.t0000 flow.t0001 flow.t0002"
ends_by_interrupt
# The address appears when the first member is prepared.
mkdir late
for i in 1 2 3; do
  { printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 128 128 128\nencoding: raw\n\n'; head -c 2097152 /dev/urandom; } >"late/late_$i.nrrd"
done
starts late --no-browser late
lists "late.t0000 late.t0001 late.t0002"
ends_by_interrupt
[ cache/multitetra/datasets/late_1-*/late.t0002.mtd -nt late.log ] ||
  fail "the address is not printed before the last member is prepared: $(ls -l --full-time late.log cache/multitetra/datasets/late*)"
mkdir jet
python3 - <<'END'
for time in range(2):
    arrays = "".join(f'<DataArray type="UInt8" Name="{name}" format="ascii">{" ".join(str((i * step + time) % 200) for i in range(216))}'
                     "</DataArray>" for name, step in (("pressure", 3), ("heat", 7)))
    open(f"jet/jet_{time}.vti", "w").write(
        '<VTKFile type="ImageData"><ImageData WholeExtent="0 5 0 5 0 5" Origin="0 0 0" Spacing="1 1 1">'
        f'<Piece Extent="0 5 0 5 0 5"><PointData>{arrays}</PointData></Piece></ImageData></VTKFile>')
END
starts fields --no-browser jet
[ "$shown" = jet.pressure.t0000 ] || fail "another field than the first is shown: $shown"
lists "jet.heat.t0000 jet.heat.t0001 jet.pressure.t0000 jet.pressure.t0001"
ends_by_interrupt
# A ParaView collection names the times, also in a folder.
cat >jet/jet.pvd <<'END'
<VTKFile type="Collection" version="0.1"><Collection>
<DataSet timestep="2.5" part="0" file="jet_1.vti"/><DataSet timestep="0.5" part="0" file="jet_0.vti"/>
</Collection></VTKFile>
END
starts collection --no-browser jet/jet.pvd
lists "jet.heat.t0000 jet.heat.t0001 jet.pressure.t0000 jet.pressure.t0001"
listed | tr -d ' \n' | grep -qF '"time":2.5' || fail "the times are not those of the collection: $(listed)"
ends_by_interrupt
starts besides --no-browser jet
lists "jet.heat.t0000 jet.heat.t0001 jet.pressure.t0000 jet.pressure.t0001"
listed | tr -d ' \n' | grep -qF '"time":2.5' || fail "a folder's collection is ignored: $(listed)"
ends_by_interrupt
sed 's/timestep="2.5"/timestep="0.5"/' jet/jet.pvd >jet/twice.pvd
ends 2 "it has several files of time 0.5" "$server" view --no-browser jet/twice.pvd
sed 's/timestep="2.5"//' jet/jet.pvd >jet/untimed.pvd
ends 2 "files that each have a time step" "$server" prepare jet/untimed.pvd -o pvd
sed 's/jet_1/..\/jet_1/' jet/jet.pvd >jet/outside.pvd
ends 2 "--follow" "$server" prepare jet/outside.pvd -o pvd
mkdir two
volume two/a.nrrd '20 * x + y'
volume two/b.nrrd '255 - 20 * x - y'
starts folder --no-browser two
lists "a b"
ends_by_interrupt

# --- label images of an OME-Zarr are offered as labels of the volume
python3 - <<'END'
import json, pathlib
def image(folder, dtype, samples):
    (folder / "0").mkdir(parents=True)
    axes = [{"name": axis, "type": "space", "unit": "micrometer"} for axis in "zyx"]
    scale = {"type": "scale", "scale": [1, 1, 1]}
    (folder / ".zgroup").write_text('{"zarr_format": 2}')
    (folder / ".zattrs").write_text(json.dumps({"multiscales": [
        {"version": "0.4", "axes": axes, "datasets": [{"path": "0", "coordinateTransformations": [scale]}]}]}))
    (folder / "0/.zarray").write_text(json.dumps({"zarr_format": 2, "shape": [6, 6, 6], "chunks": [6, 6, 6], "dtype": dtype,
        "order": "C", "compressor": None, "filters": None, "fill_value": 0}))
    (folder / "0/0.0.0").write_bytes(samples)
image(pathlib.Path("slide.zarr"), "|u1", bytes(i % 200 for i in range(216)))
image(pathlib.Path("slide.zarr/labels/cells"), "|u1", bytes(1 + i % 2 for i in range(216)))
END
starts zarr --no-browser slide.zarr
[ "$shown" = slide ] || fail "the labels are shown instead of the image: $shown"
lists "cells.label1 cells.label2 slide"
ends_by_interrupt

# --- volumes of another server
start files python3 "$project/tests/support/serve_folder.py" .
for _ in $(seq 200); do [ -s files.log ] && break; sleep 0.05; done
files=$(cut -d ' ' -f 1 files.log)
starts remote --no-browser "$files/slide.zarr"
[ "$shown" = slide ] || fail "$files/slide.zarr is shown as $shown"
lists "slide"
ends_by_interrupt

# --- on all interfaces the address is one that works on this machine
MULTITETRA_HTTP=http://0.0.0.0:0 starts everywhere --no-browser volumes/bar.nrrd
case "$url" in
  http://localhost:[1-9]*)
    lists "bar"
    [ "$(curl -s -o /dev/null -w '%{http_code}' -H 'Host: other.example' "$url/")" = 421 ] || fail "all interfaces answer to other names"
    ;;
  *) fail "the address of all interfaces is $url" ;;
esac
grep -q 'traffic is not encrypted' everywhere.log || fail "no warning that other machines can connect"
ends_by_interrupt

# --- label maps, beside a volume or opened directly, are offered as labels
mkdir scan
volume scan/ct.nrrd '20 * x + y'
volume scan/ct_seg.nrrd 'x // 4'
starts labels --no-browser scan/ct.nrrd
[ "$shown" = ct ] || fail "the labels are shown instead of the volume: $shown"
lists "ct ct_seg.label1 ct_seg.label2"
ends_by_interrupt
sed 's/spacings: 1 1 1/spacings: 0.5 1 1/' scan/ct_seg.nrrd >half.nrrd
start other "$view" view --no-browser scan/ct.nrrd --labels half.nrrd
for _ in $(seq 600); do grep -q 'labels of .half.nrrd. are on another grid, of the same size, than .ct. (12 x 12 x 12)' other.log && break; sleep 0.05; done
grep -q 'on another grid' other.log || fail "labels of another grid without a notice: $(cat other.log)"
ends_by_interrupt
ends 2 "'scan/no.nrrd' does not exist" "$view" view --no-browser scan/ct.nrrd --labels scan/no.nrrd
ends 2 "--labels needs the volume that they belong to" "$server" view --no-browser --labels scan/ct_seg.nrrd
for name in ct organs; do
  sed 's/spacings: 1 1 1/space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0.5,1)/' "scan/$([ $name = ct ] && echo ct || echo ct_seg).nrrd" >tilted_$name.nrrd
done
ends 2 "with --resample" "$view" view --no-browser tilted_ct.nrrd
starts tilted --no-browser --resample tilted_ct.nrrd --labels tilted_organs.nrrd
lists "tilted_ct tilted_organs.label1 tilted_organs.label2"
grids=$(listed | python3 -c 'import json, sys; print(len({json.dumps([d["dims"], d["index_to_world"]]) for d in json.load(sys.stdin)["datasets"]}))')
[ "$grids" = 1 ] || fail "tilted labels have another grid than their volume: $(listed)"
ends_by_interrupt
printf '1 0 255 0 1 1 1 "left half"\n2 255 0 0 1 1 1 "right half"\n' >halves.txt
starts named --no-browser scan/ct.nrrd --labels scan/ct_seg.nrrd --label-names halves.txt
[ "$shown" = "ct&labels=ct_seg:&opacity=0.35" ] || fail "named labels are not shown: $shown"
lists "ct ct_seg.label1 ct_seg.label2"
listed | python3 -c 'import json, sys; print(*[d["member"]["label"]["name"] for d in json.load(sys.stdin)["datasets"] if d["member"]], sep=";")' >names.txt
[ "$(cat names.txt)" = "left half;right half" ] || fail "the labels are named $(cat names.txt)"
ends_by_interrupt
"$server" prepare scan/ct_seg.nrrd --label all -o prepared_labels --quiet
starts prepared_labels --no-browser scan/ct.nrrd --labels prepared_labels
lists "ct ct_seg.label1 ct_seg.label2"
ends_by_interrupt
starts unlabelled --no-browser --no-labels scan/ct.nrrd
lists "ct"
ends_by_interrupt
starts map --no-browser scan/ct_seg.nrrd
lists "ct_seg ct_seg.label1 ct_seg.label2"
ends_by_interrupt

# --- prepared datasets are served directly, also those in subfolders
mkdir -p prepared/organs
"$server" prepare scan/ct.nrrd -o prepared/ct.mtd --quiet
"$server" prepare scan/ct_seg.nrrd --label all -o prepared/organs --quiet
starts datasets --no-browser prepared
lists "ct ct_seg.label1 ct_seg.label2"
ends_by_interrupt

# --- options for what the file does not specify
starts placed --no-browser --spacing 2,2,3 --length-unit um volumes/bar.nrrd
listed | tr -d ' \n' | grep -qF '"spacing":[2.0,2.0,3.0]' || fail "--spacing changes nothing: $(listed)"
listed | grep -q 'µm' || fail "--length-unit changes nothing"
ends_by_interrupt

starts turned --no-browser --up -y --orient x,-z,y volumes/bar.nrrd
[ "$shown" = "bar&up=-y" ] || fail "--up is not in the address: $shown"
ends_by_interrupt

# --- samples are served first; what another run has left incomplete is completed, without another preparation
rm -rf cache
"$server" generate head --size 200 -o slow.nrrd --quiet
starts early --no-browser slow.nrrd
listed | grep -q '"missing": *"errors"' || fail "the errors are not computed behind: $(listed)"
curl -sf -H "Authorization: Bearer $token" "$url/v1/datasets/slow/isosurface?format=ply&error=1" -o early.ply || fail "no surface without errors"
isovalue=$(curl -s -H "Authorization: Bearer $token" "$url/v1/datasets/slow" | python3 -c 'import json, sys; print(json.load(sys.stdin)["suggested_isovalues"][0])')
ends_by_interrupt
"$server" certify early.ply --volume slow.nrrd --isovalue "$isovalue" --error 1 --quiet >certificate.txt ||
  fail "a surface without errors is not certified: $(cat certificate.txt)"
starts resumed --no-browser slow.nrrd
completes
ends_by_interrupt
"$server" prepare slow.nrrd -o slow.mtd --quiet
cmp slow.mtd cache/multitetra/datasets/slow-*/slow.mtd || fail "a dataset that was completed later differs"

# --- errors
head -c 100 volumes/bar.nrrd >damaged.nrrd
ends 2 "damaged.nrrd" "$view" view --no-browser damaged.nrrd
ends 2 "nowhere.nrrd" "$view" view --no-browser nowhere.nrrd
ends 2 "--spacing" "$view" view --no-browser volumes/bar.nrrd --spacing 0,1,1
