#!/usr/bin/env bash
# Measures when surfaces are complete at a client: isovalues never requested before, links of 1 Mbit/s to 1 Gbit/s,
# clients that support sample shells or only Draco, two threads for server and client together. Creates a folder with
# one page (README.md), which has all tables of README.md and tests/bench/README.md about streams, a plot
# (certified.svg), and all numbers (quality.json). Run it on an idle machine; everything takes about half an hour.
#
#   bash tests/bench/quality.sh      into build/quality
#   --out DIR                        into another folder
#   --quick                          one volume of 128 samples per side and two links, as a quick check
#   --programs DIR                   uses the programs in DIR instead of building the bench preset
#   --yes                            installs missing packages without asking
set -euo pipefail

options=(--out --quick) out=build/quality
packages=(build tests) targets=(quality_bench final_steps_bench shell_bench)
# shellcheck source=tests/bench/set_up.sh
source "$(dirname "${BASH_SOURCE[0]}")/set_up.sh" "$@"

# Arguments of the benchmarks: files and isovalues, "--" between volumes.
streams=() finals=() shells=()

# measure NAME FILE "ISOVALUES" "ISOVALUES of final steps, or empty": prepares a volume and adds it to the measurements.
measure() {
  "$server" prepare "$2" -o "$work/$1.mtd" --name "$1" --quiet
  # shellcheck disable=SC2206
  streams+=(${streams:+--} "$work/$1.mtd" $3)
  # shellcheck disable=SC2206
  if [ -n "$4" ]; then finals+=(${finals:+--} "$work/$1.mtd" $4); fi
  shells+=("$1" "$2" "${3%% *}")
}
generated() {
  generated_head "head_$1" "$1"
  measure "head_$1" "$work/head_$1.nrrd" 500.5 500.5
}

echo "== Volumes"
links=0,1000,100,10,1 errors=0.5,0 final_errors=0.5,1,2,4
if [ "$quick" = true ]; then
  generated 128
  links=0,10 final_errors=0.5,2
else
  public measure visible_female_head visible_female_head_512x512x234_HU.nrrd 300.5 "-300.5 300.5"
  generated 256
  public measure embryo embryo_256x256x256.vti 80.5 80.5
  public measure mri_head MRI-Head_256x256x256.nrrd 60.5 ""
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
say_left_out
"$python" "$project/tests/bench/quality/page.py" "$out"
echo "$out/README.md"
