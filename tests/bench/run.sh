#!/usr/bin/env bash
# Measures preparing, opening and extracting on whole volumes, compared with VTK's flying edges. Run it on an idle
# machine; everything takes about twenty minutes. Works in a temporary folder, which it removes.
#
#   bash tests/bench/run.sh           heads of 128, 256 and 512 samples per side, and two public volumes if available
#   bash tests/bench/run.sh --quick   only the smallest head, few runs, as a quick check
#   --runs N                          counted runs of each (default 5)
#   --programs DIR                    uses the programs in DIR instead of building the bench preset
#   --yes                             installs missing packages without asking (never VTK)
set -euo pipefail

options=(--quick --runs) runs=5
packages=(build tests) targets=(volume_bench measured_run)
# shellcheck source=tests/bench/set_up.sh
source "$(dirname "${BASH_SOURCE[0]}")/set_up.sh" "$@"

busy_warning=

# With other load, two threads run like one.
busy=$(awk '/^cpu / { print $2 + $3 + $4 }' /proc/stat)
sleep 1
busy=$(awk -v before="$busy" '/^cpu / { print $2 + $3 + $4 - before }' /proc/stat)
if [ "$busy" -gt 20 ]; then
  busy_warning="!! THE MACHINE WAS BUSY before we began ($busy % of one processor): the figures are not reliable."
  echo "$busy_warning"
fi

# volume NAME FILE ISOVALUE: adds a volume to the measurements.
names=() files=() isovalues=()
volume() { names+=("$1"); files+=("$2"); isovalues+=("$3"); }

echo "== Volumes"
sizes=(128 256 512)
[ "$quick" = true ] && sizes=(128)
for size in "${sizes[@]}"; do
  generated_head "head_$size" "$size"
  volume "head_$size" "$work/head_$size.nrrd" 500.5
done
if ! ldd "$programs/volume_bench" | grep -q libvtk; then
  leave_out "flying edges: VTK is not there (bash docker/install.sh bench, then run this again)"
fi
if [ "$quick" = true ]; then
  leave_out "all but the smallest head (--quick)"
else
  public volume embryo embryo_256x256x256.vti 80.5
  public volume visible_female_head visible_female_head_512x512x234_HU.nrrd 300
fi

# Prints the number of samples of a prepared file: the product of its dims.
voxels_of() {
  "$server" info "$1" --json | tr -d ' \n' | sed 's/.*"dims":\[\([0-9]*\),\([0-9]*\),\([0-9]*\)\].*/\1 \2 \3/' |
    awk '{ printf "%.0f\n", $1 * $2 * $3 }'
}

# prepare_row NAME FILE: prepares it with 1 and 2 threads, adds a row to prepare.txt and keeps the dataset in NAME.mtd.
prepare_row() {
  local dataset=$work/$1.mtd one two
  one=$("$programs/measured_run" "$runs" "$server" prepare "$2" -o "$dataset" --name "$1" --threads 1 --quiet)
  two=$("$programs/measured_run" "$runs" "$server" prepare "$2" -o "$dataset" --name "$1" --threads 2 --quiet)
  echo "$one $two" | awk -v name="$1" -v voxels="$(voxels_of "$dataset")" '{
    printf "| %s | %.1f | %.2f (%.2f) | %.1f | %.2f (%.2f) | %.1f | %.2f | %.0f | %.0f |\n", name, voxels / 1e6,
      $1, $2, voxels / 1e6 / $1, $4, $5, voxels / 1e6 / $4, $1 / $4, $3 / 1024, $6 / 1024 }' >>"$work/prepare.txt"
  tail -n 1 "$work/prepare.txt"
}

prepare_header="\
| volume | million voxels | prepare s (least), threads 1 | million voxels/s | threads 2 | million voxels/s | \
t(1)/t(2) | peak MiB, threads 1 | threads 2 |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
for i in "${!names[@]}"; do
  echo "== ${names[i]}"
  echo "$prepare_header"
  prepare_row "${names[i]}" "${files[i]}"
  "$programs/volume_bench" "$work/${names[i]}.mtd" --isovalue "${isovalues[i]}" --runs "$runs" --threads 1,2 |
    tee -a "$work/extract.txt"
  rm -f "$work/${names[i]}.nrrd" "$work/${names[i]}.mtd"
done

# Noise over the full range: every point has errors in every bin, the worst case.
if [ "$quick" = false ]; then
  echo "== white_noise (1 run)"
  echo "$prepare_header"
  head -c 16777216 /dev/urandom >"$work/white.raw"
  printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1024 1024 16\nencoding: raw\ndata file: white.raw\n' >"$work/white.nhdr"
  counted=$runs runs=1
  prepare_row white_noise "$work/white.nhdr"
  runs=$counted
fi

echo
echo "== Everything: medians (and least) of $runs runs after one that is not counted, $(nproc) processors"
echo "$prepare_header"
cat "$work/prepare.txt"
echo
grep -v '^|' "$work/extract.txt"
awk '/^\|/ && !(/^\| (volume|---) / && seen[$0]++)' "$work/extract.txt"
say_left_out
if [ -n "$busy_warning" ]; then echo "$busy_warning"; fi
