#!/usr/bin/env bash
# Our streams beside other software, on whole volumes: bytes, triangles and seconds from "isovalue named" to "encoded
# mesh" against the real distance to the full surface. Makes a folder with one page (README.md), plots (SVG) and all numbers
# (compare.json). Peers are optional: the page says which ran. Times are those of a machine with nothing else to do; everything
# takes about half an hour.
#
#   bash tests/bench/compare.sh      into build/compare
#   --out DIR                        into another folder
#   --quick                          only two volumes of 128 samples a side and less, one run of each: whether it works
#   --runs N                         runs of each, the least time counts (default 3)
#   --programs DIR                   takes the programs in DIR instead of building the bench preset
#   --yes                            installs missing packages without asking: all of the section [bench], VTK and OpenVDB too
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
public_data=$project/../shared/data
out=$project/build/compare
runs=3
quick=false
programs=
install_options=()
while [ $# -gt 0 ]; do
  case "$1" in
    --out) out=$(realpath -m "${2:?--out needs a folder}"); shift ;;
    --quick) quick=true; runs=1 ;;
    --runs) runs=${2:?--runs needs a number}; shift ;;
    --programs) programs=$(realpath "${2:?--programs needs a folder}"); shift ;;
    --yes) install_options=(--yes) ;;
    -h | --help) sed -n '2,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "Unknown option $1; see --help." >&2; exit 2 ;;
  esac
  shift
done
cd "$project"

bash docker/install.sh "${install_options[@]}" build bench
if [ -z "$programs" ]; then
  echo "== Building (preset bench)"
  cmake --preset bench >/dev/null
  cmake --build --preset bench --target multitetra_server_program compare_bench
  programs=$project/build/bench/bin
fi
server=$programs/multitetra-server
python=/usr/bin/python3  # Debian's, for which its packages are.

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
left_out=()

# compare NAME FILE ISOVALUE: prepares and measures it.
compare() {
  echo "== $1, isovalue $3"
  "$server" prepare "$2" -o "$work/$1.mtd" --name "$1" --quiet
  "$programs/compare_bench" "$work/$1.mtd" --isovalue "$3" --runs "$runs" >"$work/$1.json"
  rm "$work/$1.mtd"
}
# public NAME FILE ISOVALUE: of ../shared/data, if it is there.
public() {
  local file=$public_data/$2
  if [ ! -f "$file" ]; then
    left_out+=("$1: ../shared/data/$2 is not there")
    return
  fi
  compare "$1" "$file" "$3"
}
generated() {
  "$server" generate head --size "$2" --noise 20 -o "$work/$1.nrrd" --quiet
  compare "$1" "$work/$1.nrrd" 500.5
  rm "$work/$1.nrrd"
}

if [ "$quick" = true ]; then
  generated head_128 128
  public headsq headsq/quarter.nhdr 1150.5
else
  generated head_512 512
  public visible_female_head visible_female_head_512x512x234_HU.nrrd 300
  public embryo embryo_256x256x256.vti 80.5
  public engine engine/engine.mhd 180.5
  public stent stent.nrrd 0.45
fi
for what in "${left_out[@]}"; do echo "!! LEFT OUT: $what"; done
"$python" "$project/tests/bench/compare/page.py" "$work" "$out"
echo "$out/README.md"
