#!/usr/bin/env bash
# run.sh counts findings, not interrupted runs, with a fake build and a fake harness.
set -euo pipefail
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"

mkdir -p bin build/bin
printf '#!/bin/sh\n' >bin/cmake
printf '#!/bin/sh\n' >build/bin/write_seeds
printf '#!/bin/bash\ncase "$*" in *-merge=1*) exit 0 ;; esac\necho "stat::number_of_executed_units: 5"\n. "%s/end"\n' "$work" >build/bin/fuzz_frame
chmod +x bin/cmake build/bin/*
export PATH=$work/bin:$PATH MULTITETRA_FUZZ_BUILD=$work/build
# counts FINDINGS ENDING: the findings in the table of a run whose harness ends like this.
counts() {
  rm -f build/runs.tsv
  echo "$2" >end
  ! bash "$project/tests/fuzz/run.sh" --minutes 1 fuzz_frame >out 2>&1 || fail "\"$2\" is a complete run: $(cat out)"
  [ "$(cut -f 1,3,6 build/runs.tsv)" = "fuzz_frame"$'\t5\t'"$1" ] || fail "other findings than $1 by \"$2\": $(cat build/runs.tsv out)"
}
counts 0 'exit 72'  # What libFuzzer does after SIGINT and SIGTERM.
counts 0 'kill -TERM $$'
counts 0 'exit 130'
grep -q 'fuzz_frame was interrupted' out || fail "an interrupted run is not reported: $(cat out)"
counts 1 'exit 77'
counts 1 'exit 70'
counts 1 'kill -SEGV $$'
grep -q 'fuzz_frame found something' out || fail "a finding is not reported: $(cat out)"
echo 'exit 0' >end
bash "$project/tests/fuzz/run.sh" 1 fuzz_frame >out 2>&1 || fail "a complete run ends with $?: $(cat out)"
