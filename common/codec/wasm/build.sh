#!/bin/bash
# Compiles the decoder of sample shells to WebAssembly: bash build.sh OUT.wasm. It needs clang with its wasm32 target and
# wasm-ld (packages clang and lld), no other headers and no library.
#
# shell_decoder.wasm beside this script is what clang 14 (Debian 12) makes of these sources: the viewer is built with it, so
# that no second compiler is needed for that. After a change of the decoder: bash build.sh common/codec/wasm/shell_decoder.wasm
set -euo pipefail
out=$(realpath "$1")
cd "$(dirname "$0")/../../.."
${CLANG:-clang++} --target=wasm32 -std=c++20 -O2 -ffp-contract=off -nostdlib -fno-exceptions -fno-rtti \
  -fno-threadsafe-statics -mbulk-memory -I. -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Werror \
  -Wl,--no-entry -Wl,--strip-all -Wl,-z,stack-size=65536 -o "$out" common/codec/wasm/shell_wasm.cpp \
  common/codec/shell_decoder.cpp common/codec/shell_format.cpp common/codec/detail/cell_cases.cpp \
  common/codec/detail/crossed_edges.cpp common/codec/detail/level_scale.cpp common/codec/detail/marching.cpp \
  common/codec/detail/shell_model.cpp
