#!/usr/bin/env bash
# Compares the tables, figures and claims of Zhou, Chen and Kaufman (IEEE Visualization 1997) with this project. Creates
# a folder with a page (README.md), pictures and all numbers (paper.json), in minutes. Run it on an idle machine.
#
#   bash tests/bench/paper.sh        into build/paper
#   --out DIR                        into another folder
#   --publish                        shows a head that may be published: the Visible Human Female's or the generated one, with
#                                    the counts of the paper's head; server/core/paper is made this way
#   --programs DIR                   uses the programs in DIR instead of building the bench preset
#   --runs N                         timed runs, of which the minimum counts (default 3)
#   --yes                            installs missing packages without asking: all of [bench], including VTK
set -euo pipefail

options=(--out --publish --runs) out=build/paper runs=3
packages=(build bench) targets=(multitetra_client_program paper_bench)
# shellcheck source=tests/bench/set_up.sh
source "$(dirname "${BASH_SOURCE[0]}")/set_up.sh" "$@"
client=$programs/multitetra-client

pid=
trap '[ -z "$pid" ] || kill "$pid"; rm -rf "$work"' EXIT
cd "$work"
mkdir served

# note NAME WORDS...: stores a text for the page.
note() { local name=$1; shift; printf '%s\n' "$*" >"$name.txt"; }

# dataset NAME ISOVALUE VOLUME WORDS...: prepares it with options WORDS; the framework pads it to 129^3 points.
dataset() {
  local name=$1
  note "$name.isovalue" "$2"
  "$server" prepare "$3" -o "served/$name.mtd" --name "$name" --quiet "${@:4}"
}

echo "== Volumes"
# All samples are solid: the padding closes the surface, one step outside.
head -c $((62 * 127 * 67)) /dev/zero | tr '\0' '\377' >box.raw
dataset box 127.5 box.raw --dims 62,127,67 --type u8 --pad-value 0 --pad 1
note box.about "all 62 x 127 x 67 samples solid, the surface closed on all sides"

ct=$public_data/head_128x128x112.dat
if [ -f "$ct" ]; then
  cp "$ct" head.dat  # Headers may only name files in their folder. It is stored upside down.
  cat >head.nhdr <<END
NRRD0004
type: uint16
dimension: 3
sizes: 128 128 112
endian: little
encoding: raw
byte skip: 6
space: left-posterior-superior
space directions: (1,0,0) (0,-1,0) (0,0,-1)
space origin: (0,127,111)
data file: head.dat
END
  dataset head 500.5 head.nhdr --pad-value 0
  note head.about "the CT head of the paper, 112 of its 113 slices, 128 x 128 x 112, at isovalue 500.5"
else
  echo "!! ../shared/data/$(basename "$ct") is not there: the generated head stands in for the paper's."
  "$server" generate head --size 128 --noise 20 -o head.nrrd --quiet
  dataset head 500.5 head.nrrd --pad-value 0
  note head.about "NOT the paper's head, which is not on this machine, but a generated one of 128 x 128 x 128 samples"
fi
portrait=head
female=$public_data/visible_female_head_512x512x234_HU.nrrd
if [ "$publish" = true ] && [ -f "$female" ]; then
  portrait=portrait
  "$python" "$project/tests/bench/paper/averaged.py" "$female" 4 portrait.nrrd
  dataset portrait -300.5 portrait.nrrd --pad-value -1024
  note portrait.about "the head of the Visible Human Female (U.S. National Library of Medicine, public domain), means of 4 x 4 x 4 samples: 128 x 128 x 58, at isovalue -300.5"
elif [ "$publish" = true ] && [ -f "$ct" ]; then
  portrait=portrait
  "$server" generate head --size 128 --noise 20 -o portrait.nrrd --quiet
  dataset portrait 500.5 portrait.nrrd --pad-value 0
  note portrait.about "a generated head of 128 x 128 x 128 samples, at isovalue 500.5"
fi
note portrait.name "$portrait"

echo "== Table 1 and Figure 5"
for name in box head; do
  "$programs/paper_bench" "served/$name.mtd" --isovalue "$(cat $name.isovalue.txt)" --runs "$runs" >"$name.counts.json"
done

echo "== Figures 6 to 11"
: >serve.log # Exists before it is read.
"$server" serve served --tcp 127.0.0.1:0 --http off >serve.log 2>&1 &
pid=$!
url=
for _ in $(seq 600); do
  url=$(sed -n 's/.*listening on \(tcp:\/\/[^ "]*\).*/\1/p' serve.log | head -n 1)
  [ -z "$url" ] || break
  sleep 0.05
done
[ -n "$url" ] || { cat serve.log >&2; exit 1; }

paper_rule=(--bound paper --topology-rule paper --simplify off)
halves=(--error 4 --region halfspace:-1,0,0,-64=0 --region-coordinates index)
# counted FILE DATASET WORDS...: the exact model and the checks of its surface.
counted() {
  local name=$2
  "$server" reference "served/$name.mtd" --isovalue "$(cat "$name.isovalue.txt")" -o mesh.ply --json --quiet \
    "${@:3}" >"$1.counts.json"
}
# picture FILE DATASET PIXELS WORDS...
picture() {
  local name=$2
  "$client" snapshot --server "$url" --dataset "$name" --isovalue "$(cat "$name.isovalue.txt")" --size "$3x$3" --bare --wireframe \
    --background light -o "$1.png" --json --quiet "${@:4}" >"$1.json"
}
looking_at_head=(--azimuth 30 --elevation 12)
for error in 0 1.5 2.5 4; do
  counted "box_$error" box "${paper_rule[@]}" --error "$error"
  picture "box_$error" box 480 "${paper_rule[@]}" --error "$error" --shading facets --azimuth 40 --elevation 25
done
for name in head "$portrait"; do
  for error in 0 4; do counted "${name}_$error" "$name" "${paper_rule[@]}" --error "$error"; done
  counted "${name}_halves" "$name" "${paper_rule[@]}" "${halves[@]}"
  counted "${name}_halves_simplified" "$name" "${halves[@]}"
  counted "${name}_simplified_4" "$name" --error 4
done
for error in 0 4; do
  picture "portrait_$error" "$portrait" 480 "${paper_rule[@]}" --error "$error" "${looking_at_head[@]}"
done
picture portrait_halves "$portrait" 480 "${paper_rule[@]}" "${halves[@]}" --azimuth 0 --elevation 0
picture portrait_halves_simplified "$portrait" 480 "${halves[@]}" --azimuth 0 --elevation 0
picture portrait_border "$portrait" 2880 "${paper_rule[@]}" "${halves[@]}" --azimuth 0 --elevation 0 --shading facets

echo "== Volume rendering"
for name in head "$portrait"; do
  isovalue=$(cat "$name.isovalue.txt")
  for error in 0 1 4; do
    "$server" reference "served/$name.mtd" --isovalue "$isovalue" "${paper_rule[@]}" --error "$error" --errors spectrum -o mesh.ply \
      --model model.vtu --quiet
    xvfb-run -a "$python" "$project/tests/bench/paper/volume.py" model.vtu --isovalue "$isovalue" "${looking_at_head[@]}" \
      -o "${name}_volume_$error.png" >"${name}_volume_$error.json"
  done
done

# The viewer's rays and VTK's, of a head that may be shown.
viewer=$programs/../share/multitetra/viewer
chromium=${CHROMIUM:-/usr/bin/chromium}
if [ -f "$female" ] && [ -f "$viewer/index.html" ] && [ -x "$chromium" ] && command -v node >/dev/null; then
  camera=(--dataset rays --eye 232 -78 128 --target 126 128 54)
  "$python" "$project/tests/bench/paper/averaged.py" "$female" 2 rays.nrrd
  mkdir rays
  "$server" prepare rays.nrrd -o rays/rays.mtd --name rays --samples-only --quiet
  CHROMIUM=$chromium node "$project/tests/bench/paper/viewer_picture.mjs" "$server" "$viewer" rays \
    "$("$python" "$project/tests/bench/paper/raycast.py" rays.nrrd "${camera[@]}")" rays_viewer.png
  xvfb-run -a "$python" "$project/tests/bench/paper/raycast.py" rays.nrrd rays_viewer.png "${camera[@]}" -o rays_vtk.png >rays.json
else
  echo "!! LEFT OUT: the viewer's rays beside VTK's: they need the Visible Female, the viewer, node and Chromium"
fi

echo "== The page"
"$python" "$project/tests/bench/paper/page.py" "$work" "$out"
echo "$out/README.md"
