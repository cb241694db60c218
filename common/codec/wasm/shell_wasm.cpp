// The decoder of sample shells as a WebAssembly module, compiled by build.sh.
//
// Usage, per tile (all numbers have 32 bits; pointers are offsets into `memory`):
//
//   const at = shell_payload(bytes.length)   // where the payload goes; memory may have grown
//   new Uint8Array(memory.buffer, at, bytes.length).set(bytes)
//   shell_open() === 0                       // ShellStatus; then the header's fields are known
//   shell_decode() === 0                     // memory may have grown again
//   new Int32Array(memory.buffer, shell_vertices(), 3 * shell_vertex_count())
//   new Uint32Array(memory.buffer, shell_triangles(), 3 * shell_triangle_count())
//
// The payload may also be a plain box of samples (plain_box.hpp), whose counts shell_count() finds
// instead of shell_decode().
//
// The arrays are valid until the next shell_payload. Memory keeps the size the largest tile needed,
// at most about 65 MB; a host with less must check the counts before shell_decode.
#include <stddef.h>
#include <stdint.h>

#include "common/codec/plain_box.hpp"
#include "common/codec/shell_decoder.hpp"

extern "C" unsigned char __heap_base;  // Set by the linker: the start of free memory.

namespace {

using multitetra::shell::kPlainVersion;
using multitetra::shell::PlainBoxMarcher;
using multitetra::shell::ShellDecoder;
using multitetra::shell::ShellHeader;
using multitetra::shell::ShellStatus;
using multitetra::shell::ShellTriangle;
using multitetra::shell::ShellVertex;

constexpr size_t kPage = 65536;

ShellDecoder decoder;
PlainBoxMarcher marcher;
ShellHeader header;
size_t payload_size = 0;

uint8_t* payload() {
  return reinterpret_cast<uint8_t*>((reinterpret_cast<size_t>(&__heap_base) + 15) & ~size_t{15});
}
ShellVertex* vertices() {
  return reinterpret_cast<ShellVertex*>(payload() + ((payload_size + 15) & ~size_t{15}));
}
ShellTriangle* triangles() {
  return reinterpret_cast<ShellTriangle*>(vertices() + header.vertices);
}

bool is_plain() { return payload_size > 0 && payload()[0] == kPlainVersion; }

// Returns false if the host provides no more memory.
bool grow_to(const void* end) {
  const size_t needed = (reinterpret_cast<size_t>(end) + kPage - 1) / kPage;
  const size_t now = __builtin_wasm_memory_size(0);
  return needed <= now || __builtin_wasm_memory_grow(0, needed - now) != static_cast<size_t>(-1);
}

}  // namespace

#define MULTITETRA_EXPORT(name) extern "C" __attribute__((export_name(#name)))

// Returns 0 if there is no memory.
MULTITETRA_EXPORT(shell_payload) uint8_t* shell_payload(size_t size) {
  header = {};
  payload_size = 0;
  if (size > (size_t{1} << 30) || !grow_to(payload() + size)) return nullptr;
  payload_size = size;
  return payload();
}
MULTITETRA_EXPORT(shell_open) int32_t shell_open() {
  const ShellStatus status =
      is_plain() ? multitetra::shell::read_plain_header(payload(), payload_size, header)
                 : multitetra::shell::read_shell_header(payload(), payload_size, header);
  if (status != ShellStatus::kOk) header = {};
  return static_cast<int32_t>(status);
}
// Returns -1 if there is no memory.
MULTITETRA_EXPORT(shell_decode) int32_t shell_decode() {
  if (!grow_to(triangles() + header.triangles)) return -1;
  return static_cast<int32_t>(
      is_plain() ? marcher.decode(payload(), header, vertices(), triangles())
                 : decoder.decode(payload(), payload_size, vertices(), triangles()));
}
// Sets the counts of a plain box that is open. Returns -1 if there is no memory.
MULTITETRA_EXPORT(shell_count) int32_t shell_count() {
  header.vertices = max_vertices(header);
  header.triangles = max_triangles(header);
  if (header.has_void && !grow_to(triangles() + header.triangles)) return -1;
  marcher.count(payload(), header, vertices(), triangles());
  return 0;
}
MULTITETRA_EXPORT(shell_vertex_count) uint32_t shell_vertex_count() { return header.vertices; }
MULTITETRA_EXPORT(shell_triangle_count) uint32_t shell_triangle_count() { return header.triangles; }
MULTITETRA_EXPORT(shell_lattice_resolution) int32_t shell_lattice_resolution() {
  return header.lattice_resolution;
}
MULTITETRA_EXPORT(shell_spacing_exponent) int32_t shell_spacing_exponent() {
  return header.spacing_exponent;
}
MULTITETRA_EXPORT(shell_values) int32_t shell_values() {
  return static_cast<int32_t>(header.values);
}
// L of quantized and lattice-exact shells, otherwise 0.
MULTITETRA_EXPORT(shell_levels_per_octave) int32_t shell_levels_per_octave() {
  return header.levels_per_octave;
}
MULTITETRA_EXPORT(shell_has_void) int32_t shell_has_void() { return header.has_void ? 1 : 0; }
// The box's ends along axis 0, 1 or 2, in lattice coordinates, which are below 2^21.
MULTITETRA_EXPORT(shell_low) int32_t shell_low(int32_t axis) {
  return header.origin[axis] * header.steps();
}
MULTITETRA_EXPORT(shell_high) int32_t shell_high(int32_t axis) {
  return (header.origin[axis] + header.samples[axis] - 1) * header.steps();
}
MULTITETRA_EXPORT(shell_vertices) const ShellVertex* shell_vertices() { return vertices(); }
MULTITETRA_EXPORT(shell_triangles) const ShellTriangle* shell_triangles() { return triangles(); }
