#!/bin/bash
# Builds the decoder of sample shells as WebAssembly and decodes the golden ones: shell_wasm_test.sh OUT.wasm
set -euo pipefail
project=$(realpath "$(dirname "$0")/../../..")
bash "$project/common/codec/wasm/build.sh" "$1"
${NODE:-node} "$project/tests/common/codec/shell_wasm_test.mjs" "$1" "$project/tests/golden"
