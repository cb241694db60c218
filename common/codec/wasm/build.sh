#!/bin/bash
# Compiles the decoder of sample shells to WebAssembly: bash build.sh OUT.wasm. Needs clang with its wasm32 target and
# wasm-ld (packages clang and lld), but no other headers or libraries.
#
# shell_decoder.wasm in this folder is the output of clang 14 (Debian 12), so that building the viewer needs no second
# compiler. After changing the decoder: bash build.sh common/codec/wasm/shell_decoder.wasm
set -euo pipefail
out=$(realpath "$1")
cd "$(dirname "$0")/../../.."
${CLANG:-clang++} --target=wasm32 -std=c++20 -O2 -ffp-contract=off -nostdlib -fno-exceptions -fno-rtti \
  -fno-threadsafe-statics -mbulk-memory -I. -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Werror \
  -Wl,--no-entry -Wl,--strip-all -Wl,-z,stack-size=65536 -o "$out" common/codec/wasm/shell_wasm.cpp \
  common/codec/plain_box.cpp common/codec/shell_decoder.cpp common/codec/shell_format.cpp common/codec/detail/cell_cases.cpp \
  common/codec/detail/crossed_edges.cpp common/codec/detail/level_scale.cpp common/codec/detail/marching.cpp \
  common/codec/detail/shell_model.cpp
