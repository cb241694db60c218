#!/usr/bin/env bash
# When surfaces are complete at a client: isovalues that were never requested before, links of 1 Mbit/s to 1 Gbit/s, clients that
# know sample shells or Draco alone, two threads for server and client together. Makes a folder with one page (README.md) that has
# all tables of README.md and tests/bench/README.md about streams, a plot (certified.svg), and all numbers (quality.json). Times
# are those of a machine with nothing else to do; everything takes about half an hour.
#
#   bash tests/bench/quality.sh      into build/quality
#   --out DIR                        into another folder
#   --quick                          one volume of 128 samples a side and two links: whether it works
#   --programs DIR                   takes the programs in DIR instead of building the bench preset
#   --yes                            installs missing packages without asking
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
public_data=$project/../shared/data
out=$project/build/quality
quick=false
programs=
install_options=()
while [ $# -gt 0 ]; do
  case "$1" in
    --out) out=$(realpath -m "${2:?--out needs a folder}"); shift ;;
    --quick) quick=true ;;
    --programs) programs=$(realpath "${2:?--programs needs a folder}"); shift ;;
    --yes) install_options=(--yes) ;;
    -h | --help) sed -n '2,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "Unknown option $1; see --help." >&2; exit 2 ;;
  esac
  shift
done
cd "$project"

if [ -z "$programs" ]; then
  bash docker/install.sh "${install_options[@]}" build tests
  echo "== Building (preset bench)"
  cmake --preset bench >/dev/null
  cmake --build --preset bench --target multitetra_server_program quality_bench final_steps_bench shell_bench
  programs=$project/build/bench/bin
fi
server=$programs/multitetra-server
python=/usr/bin/python3  # Debian's, for which its packages are.

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
left_out=()
# Arguments of the benches: files and isovalues, "--" between volumes.
streams=() finals=() shells=()

# measure NAME FILE "ISOVALUES" "ISOVALUES of final steps, or none": notes a volume to be measured, prepared.
measure() {
  "$server" prepare "$2" -o "$work/$1.mtd" --name "$1" --quiet
  # shellcheck disable=SC2206
  streams+=(${streams:+--} "$work/$1.mtd" $3)
  # shellcheck disable=SC2206
  if [ -n "$4" ]; then finals+=(${finals:+--} "$work/$1.mtd" $4); fi
  shells+=("$1" "$2" "${3%% *}")
}
# public NAME FILE ...: of ../shared/data, if it is there.
public() {
  local name=$1 file=$public_data/$2
  if [ -f "$file" ]; then
    measure "$name" "$file" "$3" "$4"
  else
    left_out+=("$name: ../shared/data/$2 is not there")
  fi
}
generated() {
  "$server" generate head --size "$1" --noise 20 -o "$work/head_$1.nrrd" --quiet
  measure "head_$1" "$work/head_$1.nrrd" 500.5 500.5
}

echo "== Volumes"
links=0,1000,100,10,1 errors=0.5,0 final_errors=0.5,1,2,4
if [ "$quick" = true ]; then
  generated 128
  links=0,10 final_errors=0.5,2
else
  public visible_female_head visible_female_head_512x512x234_HU.nrrd 300.5 "-300.5 300.5"
  generated 256
  public embryo embryo_256x256x256.vti 80.5 80.5
  public mri_head MRI-Head_256x256x256.nrrd 60.5 ""
fi

mkdir -p "$out"
echo "== Streams"
"$programs/quality_bench" --json --links "$links" --errors "$errors" "${streams[@]}" | tee "$out/quality.txt"
echo "== Final steps"
"$programs/final_steps_bench" --errors "$final_errors" "${finals[@]}" | tee "$out/final_steps.md"
echo "== Sample shells beside Draco"
for ((i = 0; i < ${#shells[@]}; i += 3)); do
  echo "${shells[i]}, ${shells[i + 2]}"
  "$programs/shell_bench" "${shells[i + 1]}" "${shells[i + 2]}"
done | tee "$out/shells.txt"
for what in "${left_out[@]}"; do echo "!! LEFT OUT: $what"; done
"$python" "$project/tests/bench/quality/page.py" "$out"
echo "$out/README.md"
