#!/usr/bin/env bash
# Compares our streams with other software on whole volumes: bytes, triangles and seconds from the isovalue to the
# encoded mesh, against the measured distance to the full surface. Creates a folder with one page (README.md), plots
# (SVG) and all numbers (compare.json). Other software is optional: the page lists what ran. Run it on an idle machine;
# everything takes about half an hour.
#
#   bash tests/bench/compare.sh      into build/compare
#   --out DIR                        into another folder
#   --quick                          only two volumes of at most 128 samples per side, one run of each, as a quick check
#   --runs N                         runs of each, of which the minimum counts (default 3)
#   --programs DIR                   uses the programs in DIR instead of building the bench preset
#   --yes                            installs missing packages without asking: all of [bench], including VTK and OpenVDB
set -euo pipefail

options=(--out --quick --runs) out=build/compare runs=3
packages=(build bench) targets=(compare_bench)
# shellcheck source=tests/bench/set_up.sh
source "$(dirname "${BASH_SOURCE[0]}")/set_up.sh" "$@"

# compare NAME FILE ISOVALUE: prepares and measures it.
compare() {
  echo "== $1, isovalue $3"
  "$server" prepare "$2" -o "$work/$1.mtd" --name "$1" --quiet
  "$programs/compare_bench" "$work/$1.mtd" --isovalue "$3" --runs "$runs" >"$work/$1.json"
  rm "$work/$1.mtd"
}
generated() {
  generated_head "$1" "$2"
  compare "$1" "$work/$1.nrrd" 500.5
  rm "$work/$1.nrrd"
}

if [ "$quick" = true ]; then
  generated head_128 128
  public compare headsq headsq/quarter.nhdr 1150.5
else
  generated head_512 512
  public compare visible_female_head visible_female_head_512x512x234_HU.nrrd 300
  public compare embryo embryo_256x256x256.vti 80.5
  public compare engine engine/engine.mhd 180.5
  public compare stent stent.nrrd 0.45
fi
say_left_out
"$python" "$project/tests/bench/compare/page.py" "$work" "$out"
echo "$out/README.md"
