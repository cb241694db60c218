#!/usr/bin/env bash
# Builds the libFuzzer harnesses, all or the named ones, and runs each for SECONDS (default: 60), or all of them together
# for MINUTES, one per processor at a time. Stops starting harnesses after a finding. Each starts with the corpus of
# earlier runs in tests/fuzz/corpus. New inputs stay in build/fuzz/corpus, minimized to those needed for their coverage;
# --keep packs them into tests/fuzz/corpus. Findings are stored in build/fuzz/findings: fix them, and add each as a
# golden file or a named test.
#   bash tests/fuzz/run.sh [--keep] [SECONDS | --all-for MINUTES | --minutes MINUTES] [HARNESS...]
#
# --minutes gives each harness that much processor time, summed over all such runs, in slices of five minutes, each of
# which adds a line to build/fuzz/runs.tsv. An interrupted run continues with the missing time. Prints the table of all
# runs. At low priority (nice), where inputs may exceed the limit of 10 seconds, set MULTITETRA_FUZZ_TIMEOUT.
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
cmake --build "$build" --target write_seeds "${harnesses[@]}"
"$build/bin/write_seeds" "$build/seeds"
mkdir -p "$build/findings"

# Prints the last value of "cov: 123" and the like in a log; 0 if there is none.
last_of() { grep -o "$2: [0-9]*" "$1" | tail -n 1 | grep -o '[0-9]*$' || echo 0; }

# Runs one harness for some seconds, then minimizes its corpus; returns 255 (which ends xargs) after a finding.
fuzz_for() {
  local harness=$1 time=$2 status=0 findings=0 processor TIMEFORMAT=%0U
  local corpus=$build/corpus/$harness log=$build/findings/$harness.log
  local kept=tests/fuzz/corpus/$harness.tar.xz
  mkdir -p "$corpus"
  if [ -f "$kept" ]; then tar -xJf "$kept" -C "$build/corpus"; fi
  processor=$({ time "$build/bin/$harness" -max_total_time="$time" -max_len=16384 \
    -timeout="${MULTITETRA_FUZZ_TIMEOUT:-10}" -rss_limit_mb=1024 -malloc_limit_mb=512 -print_final_stats=1 \
    -print_funcs=0 -artifact_prefix="$build/findings/$harness-" "$corpus" "$build/seeds/$harness" >"$log" 2>&1; } 2>&1) || status=$?
  case $status in 0 | 72 | 130 | 143) ;; *) findings=1 ;; esac  # By SIGINT or SIGTERM libFuzzer exits with 72.
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
  if [ "$status" -ne 0 ]; then
    echo "$harness was interrupted" >&2
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
# Prints the seconds that a harness has run, from the table.
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
