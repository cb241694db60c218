#!/usr/bin/env bash
# Builds all libFuzzer harnesses and runs each for SECONDS (60 by default), or all of them together for
# MINUTES; stops at the first finding. What was learnt stays in build/fuzz/corpus for the next run: no
# more inputs than are needed for what they reach. A finding is kept in build/fuzz/findings: mend it, and
# keep it as a golden file with a named test.
#   bash tests/fuzz/run.sh [SECONDS | --all-for MINUTES]
set -euo pipefail
cd "$(dirname "$0")/../.."
harnesses=(fuzz_dataset_file fuzz_frame fuzz_client_message fuzz_server_message fuzz_tile
  fuzz_tile_round_trip fuzz_http_request fuzz_volume_metadata fuzz_manifest fuzz_label_names)
seconds=${1:-60}
if [ "$seconds" = --all-for ]; then
  seconds=$(awk "BEGIN { printf \"%d\", 60 * ${2:?--all-for needs minutes} / ${#harnesses[@]} + 1 }")
fi
build=${MULTITETRA_FUZZ_BUILD:-build/fuzz}

cmake --preset fuzz -B "$build" >/dev/null
cmake --build "$build"
"$build/bin/write_seeds" "$build/seeds"
mkdir -p "$build/findings"
for harness in "${harnesses[@]}"; do
  mkdir -p "$build/corpus/$harness"
  echo "== $harness, $seconds s"
  if ! "$build/bin/$harness" -max_total_time="$seconds" -max_len=16384 -timeout=10 \
      -rss_limit_mb=1024 -malloc_limit_mb=512 -print_final_stats=1 -verbosity=0 \
      -artifact_prefix="$build/findings/$harness-" "$build/corpus/$harness" \
      "$build/seeds/$harness" 2>"$build/findings/$harness.log"; then
    tail -40 "$build/findings/$harness.log"
    echo "$harness found something: see $build/findings" >&2
    exit 1
  fi
  grep -E 'number_of_executed_units|peak_rss_mb' "$build/findings/$harness.log"
  # The least that reaches as much.
  rm -rf "$build/corpus/$harness.least"
  mkdir "$build/corpus/$harness.least"
  "$build/bin/$harness" -merge=1 -max_len=16384 -verbosity=0 "$build/corpus/$harness.least" \
    "$build/corpus/$harness" "$build/seeds/$harness" 2>>"$build/findings/$harness.log"
  rm -rf "$build/corpus/$harness"
  mv "$build/corpus/$harness.least" "$build/corpus/$harness"
  echo "corpus: $(find "$build/corpus/$harness" -type f | wc -l) inputs, $(du -sh "$build/corpus/$harness" | cut -f1)"
done
echo "No finding."
