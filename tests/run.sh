#!/usr/bin/env bash
# Builds and runs all tests. Repeated runs rebuild and rerun only what has changed.
#
#   bash tests/run.sh                everything, including slow tests
#   bash tests/run.sh --fast         without the tests labelled slow
#   bash tests/run.sh --all          also with the large public volumes, which takes long
#   bash tests/run.sh --preset asan  with another preset (dev, release, asan, tsan)
#   --strict                         warnings are errors, as in continuous integration
#   --yes                            installs missing packages without asking
set -euo pipefail

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$project"

preset=tests
install_options=()
cmake_options=()
ctest_options=(--output-on-failure --no-tests=error -j "$(($(nproc) + 1))") # Some tests mostly wait.
while [ $# -gt 0 ]; do
  case "$1" in
    --fast) ctest_options+=(-LE slow) ;;
    --all) export MULTITETRA_ALL_TESTS=1 ;;
    --preset) preset=${2:?--preset needs a name}; shift ;;
    --strict) cmake_options=(-DMULTITETRA_WARNINGS_AS_ERRORS=ON) ;;
    --yes) install_options=(--yes) ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "Unknown option $1; see --help." >&2; exit 2 ;;
  esac
  shift
done

bash docker/install.sh "${install_options[@]}" build package python tests
echo "== Building (preset $preset)"
cmake --preset "$preset" "${cmake_options[@]}" >/dev/null
cmake --build --preset "$preset"
echo "== Testing"
if [ ! -d ../shared/data ]; then
  echo "!! The public volumes are not at ../shared/data: the tests that need them are SKIPPED."
fi
code=0
ctest --test-dir "build/$preset" "${ctest_options[@]}" || code=$?
log=build/$preset/Testing/Temporary/LastTest.log
if grep -q "NOT TESTED" "$log"; then
  echo "!! Not tested here:"
  grep -o "NOT TESTED.*" "$log" | sort | uniq -c | sort -rn | head -n 30
fi
exit "$code"
