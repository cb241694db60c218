#!/bin/bash
# Builds the decoder of sample shells as WebAssembly, and decodes the golden shells and those of a folder that
# write_shells has filled: shell_wasm_test.sh OUT.wasm FOLDER. With the compiler of the checked-in shell_decoder.wasm,
# both files must be identical.
set -euo pipefail
project=$(realpath "$(dirname "$0")/../../..")
bash "$project/common/codec/wasm/build.sh" "$1"
${NODE:-node} "$project/tests/common/codec/shell_wasm_test.mjs" "$1" "$project/tests/golden"
${NODE:-node} "$project/tests/common/codec/shell_wasm_test.mjs" "$1" "$2"
version=$(${CLANG:-clang++} -dumpversion)
if [ "${version%%.*}" != 14 ]; then
  echo "!! clang is version $version, not 14: the checked-in shell_decoder.wasm is NOT COMPARED."
  exit 0
fi
if ! cmp "$1" "$project/common/codec/wasm/shell_decoder.wasm"; then
  echo "The checked-in shell_decoder.wasm is not what its sources make: run common/codec/wasm/build.sh and commit the file."
  exit 1
fi
