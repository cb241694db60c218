#!/usr/bin/env bash
# CMake without a preset builds, installs and runs: each file is compiled alone, so that it includes what it uses.
# Takes a quarter of an hour, so it runs only if MULTITETRA_ALL_TESTS is set, and exits with 77 otherwise.
set -euo pipefail
[ -n "${MULTITETRA_ALL_TESTS:-}" ] || { echo "!! MULTITETRA_ALL_TESTS is not set: the plain build is NOT TESTED." >&2; exit 77; }
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$project/tests/support/programs.sh"

cmake -S "$project" -B build -DMULTITETRA_TESTS=OFF >/dev/null
cmake --build build -j "$(nproc)"
cmake --install build --prefix "$work/prefix" >/dev/null
ends 0 "multitetra" prefix/bin/multitetra --version
[ -s prefix/share/multitetra/viewer/index.html ] || fail "the viewer is not installed"
