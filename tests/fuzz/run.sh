#!/usr/bin/env bash
# Builds all libFuzzer harnesses and runs each, or those that are named, for SECONDS (60 by default), or all
# of them together for MINUTES; as many at once as there are processors. No further one begins after a
# finding. Each begins with what earlier runs have learnt, in tests/fuzz/corpus. What it learns stays in
# build/fuzz/corpus, no more inputs than are needed for what they reach; --keep packs them into
# tests/fuzz/corpus. A finding is kept in build/fuzz/findings: mend it, and keep it as a golden file or in a
# test with a name.
#   bash tests/fuzz/run.sh [--keep] [SECONDS | --all-for MINUTES] [HARNESS...]
set -euo pipefail
cd "$(dirname "$0")/../.."
harnesses=(fuzz_dataset_file fuzz_frame fuzz_client_message fuzz_server_message fuzz_tile
  fuzz_tile_round_trip fuzz_shell fuzz_shell_round_trip fuzz_http_request fuzz_volume_metadata fuzz_volume_file fuzz_label_names)
export is_kept=false
if [ "${1:-}" = --keep ]; then
  is_kept=true
  shift
fi
export seconds=${1:-60}
minutes=
if [ "$seconds" = --all-for ]; then
  minutes=${2:?--all-for needs minutes}
  shift
fi
if [ $# -gt 1 ]; then harnesses=("${@:2}"); fi
if [ -n "$minutes" ]; then
  rounds=$(((${#harnesses[@]} + $(nproc) - 1) / $(nproc)))
  seconds=$(awk "BEGIN { printf \"%d\", 60 * $minutes / $rounds + 1 }")
fi
export build=${MULTITETRA_FUZZ_BUILD:-build/fuzz}
if [ -w /dev/shm ]; then export TMPDIR=/dev/shm; fi  # Harnesses that read files write many.

cmake --preset fuzz -B "$build" >/dev/null
cmake --build "$build"
"$build/bin/write_seeds" "$build/seeds"
mkdir -p "$build/findings"

# Runs one harness, then reduces its corpus to the least that reaches as much; 255 (which ends xargs) when
# it found something.
fuzz() {
  local harness=$1
  local corpus=$build/corpus/$harness log=$build/findings/$harness.log
  local kept=tests/fuzz/corpus/$harness.tar.xz
  mkdir -p "$corpus"
  if [ -f "$kept" ]; then tar -xJf "$kept" -C "$build/corpus"; fi
  if ! "$build/bin/$harness" -max_total_time="$seconds" -max_len=16384 -timeout=10 -rss_limit_mb=1024 \
      -malloc_limit_mb=512 -print_final_stats=1 -verbosity=0 -artifact_prefix="$build/findings/$harness-" \
      "$corpus" "$build/seeds/$harness" 2>"$log"; then
    tail -40 "$log" >&2
    echo "$harness found something: see $build/findings" >&2
    return 255
  fi
  local runs memory
  runs=$(awk '/number_of_executed_units/ { print $2 }' "$log")
  memory=$(awk '/peak_rss_mb/ { print $2 }' "$log")
  rm -rf "$corpus.least"
  mkdir "$corpus.least"
  "$build/bin/$harness" -merge=1 -max_len=16384 -verbosity=0 "$corpus.least" "$corpus" \
    "$build/seeds/$harness" 2>>"$log" || return 255
  rm -rf "$corpus"
  mv "$corpus.least" "$corpus"
  if [ "$is_kept" = true ]; then
    mkdir -p tests/fuzz/corpus
    XZ_OPT=-9e tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -cJf "$kept" \
      -C "$build/corpus" "$harness"
  fi
  echo "$harness: $runs inputs in $seconds s, at most $memory MiB;" \
    "corpus: $(find "$corpus" -type f | wc -l) inputs, $(du -sh --apparent-size "$corpus" | cut -f1)"
}
export -f fuzz
if ! printf '%s\n' "${harnesses[@]}" | xargs -P "$(nproc)" -I{} bash -c 'fuzz {}'; then
  exit 1
fi
echo "No finding."
