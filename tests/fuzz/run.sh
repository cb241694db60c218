#!/usr/bin/env bash
# Builds all libFuzzer harnesses and runs each, or those that are named, for SECONDS (60 by default), or all of them together
# for MINUTES; as many at once as there are processors. No further one begins after a finding. Each begins with what earlier
# runs have learnt, in tests/fuzz/corpus. What it learns stays in build/fuzz/corpus, no more inputs than are needed for what
# they reach; --keep packs them into tests/fuzz/corpus. A finding is kept in build/fuzz/findings: mend it, and keep it as a
# golden file or in a test with a name.
#   bash tests/fuzz/run.sh [--keep] [SECONDS | --all-for MINUTES | --minutes MINUTES] [HARNESS...]
#
# --minutes gives each harness so many minutes of processor time, counted over all such runs: in slices of five minutes, each
# of which adds a line to build/fuzz/runs.tsv. A run that was stopped goes on with what is missing. Prints the table of all
# runs. Beside other work at a lower priority (nice), where inputs take longer than their 10 seconds, set
# MULTITETRA_FUZZ_TIMEOUT.
set -euo pipefail
cd "$(dirname "$0")/../.."
# The list of tests/fuzz/CMakeLists.txt.
mapfile -t harnesses < <(sed -n '/set(harnesses/,/)/p' tests/fuzz/CMakeLists.txt | grep -o 'fuzz_[a-z_]*')
export is_kept=false
if [ "${1:-}" = --keep ]; then
  is_kept=true
  shift
fi
export seconds=${1:-60} wanted=
minutes=
if [ "$seconds" = --all-for ] || [ "$seconds" = --minutes ]; then
  minutes=${2:?$1 needs minutes}
  shift
fi
if [ $# -gt 1 ]; then harnesses=("${@:2}"); fi
if [ "$seconds" = --all-for ]; then
  rounds=$(((${#harnesses[@]} + $(nproc) - 1) / $(nproc)))
  seconds=$(awk "BEGIN { printf \"%d\", 60 * $minutes / $rounds + 1 }")
elif [ "$seconds" = --minutes ]; then
  seconds=300
  wanted=$(awk "BEGIN { printf \"%d\", 60 * $minutes }")
fi
export build=${MULTITETRA_FUZZ_BUILD:-build/fuzz}
export runs=$build/runs.tsv
if [ -w /dev/shm ]; then export TMPDIR=/dev/shm; fi  # Harnesses that read files write many.

cmake --preset fuzz -B "$build" >/dev/null
cmake --build "$build"
"$build/bin/write_seeds" "$build/seeds"
mkdir -p "$build/findings"

# The last value of "cov: 123" and the like in a log; 0 without one.
last_of() { grep -o "$2: [0-9]*" "$1" | tail -n 1 | grep -o '[0-9]*$' || echo 0; }

# Runs one harness for some seconds, then reduces its corpus to the least that reaches as much; 255 (which ends xargs) when it
# found something.
fuzz_for() {
  local harness=$1 time=$2 findings=0 processor TIMEFORMAT=%0U
  local corpus=$build/corpus/$harness log=$build/findings/$harness.log
  local kept=tests/fuzz/corpus/$harness.tar.xz
  mkdir -p "$corpus"
  if [ -f "$kept" ]; then tar -xJf "$kept" -C "$build/corpus"; fi
  processor=$({ time "$build/bin/$harness" -max_total_time="$time" -max_len=16384 \
    -timeout="${MULTITETRA_FUZZ_TIMEOUT:-10}" -rss_limit_mb=1024 -malloc_limit_mb=512 -print_final_stats=1 \
    -print_funcs=0 -artifact_prefix="$build/findings/$harness-" "$corpus" "$build/seeds/$harness" >"$log" 2>&1; } 2>&1) || findings=1
  local inputs memory
  inputs=$(awk '/number_of_executed_units/ { print $2 }' "$log")
  memory=$(awk '/peak_rss_mb/ { print $2 }' "$log")
  if [ -n "$wanted" ]; then
    printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$harness" "$processor" "${inputs:-0}" "$(last_of "$log" cov)" \
      "$(last_of "$log" ft)" "$findings" >>"$runs"
  fi
  if [ "$findings" -gt 0 ]; then
    tail -40 "$log" >&2
    echo "$harness found something: see $build/findings" >&2
    return 255
  fi
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
  echo "$harness: $inputs inputs in $time s, at most $memory MiB;" \
    "corpus: $(find "$corpus" -type f | wc -l) inputs, $(du -sh --apparent-size "$corpus" | cut -f1)"
}
# Seconds that a harness has run, by the table.
seconds_of() { awk -F '\t' -v name="$1" '$1 == name { sum += $2 } END { print sum + 0 }' "$runs"; }
fuzz() {
  if [ -z "$wanted" ]; then
    fuzz_for "$1" "$seconds"
    return
  fi
  local left
  while left=$((wanted - $(seconds_of "$1"))) && [ "$left" -gt 0 ]; do
    fuzz_for "$1" $((left < seconds ? left + 5 : seconds)) || return 255
  done
}
print_table() {
  echo
  echo "| harness | minutes | inputs | edges | features | findings |"
  echo "| --- | --- | --- | --- | --- | --- |"
  sort "$runs" | awk -F '\t' '
    function row() { if (name) printf "| %s | %.1f | %d | %d | %d | %d |\n", name, time / 60, inputs, edges, features, findings }
    $1 != name { row(); name = $1; time = inputs = edges = features = findings = 0 }
    { time += $2; inputs += $3; findings += $6; if ($4 > edges) edges = $4; if ($5 > features) features = $5 }
    END { row() }'
}
export -f fuzz fuzz_for last_of seconds_of
if [ -n "$wanted" ]; then touch "$runs"; fi
result=0
printf '%s\n' "${harnesses[@]}" | xargs -P "$(nproc)" -I{} bash -c 'fuzz {}' || result=1
if [ -n "$wanted" ]; then print_table; fi
[ "$result" -eq 0 ] || exit 1
echo "No finding."
