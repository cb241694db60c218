// Any samples that the encoder accepts decode to the surface of their signs; lattice-exact shells
// agree with exact ones.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "common/codec/shell_decoder.hpp"
#include "common/codec/shell_encoder.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace multitetra::shell;

struct Surface {
  std::vector<ShellVertex> vertices;
  std::vector<ShellTriangle> triangles;
};

Surface through_bytes(const ShellBox& box, const ShellOptions& options) {
  static const auto decoder = std::make_unique<ShellDecoder>();
  static ShellEncoder encoder;
  const auto bytes = encoder.encode(box, options);
  Surface surface;
  if (!bytes) return surface;
  ShellHeader header;
  require(read_shell_header(bytes->data(), bytes->size(), header) == ShellStatus::kOk);
  surface.vertices.resize(header.vertices);
  surface.triangles.resize(header.triangles);
  require(decoder->decode(bytes->data(), bytes->size(), surface.vertices.data(),
                          surface.triangles.data()) == ShellStatus::kOk);
  return surface;
}

bool equal(const Surface& a, const Surface& b) {
  const auto same = [](const auto& left, const auto& right) {
    return left.size() == right.size() &&
           (left.empty() ||
            std::memcmp(left.data(), right.data(), left.size() * sizeof(left[0])) == 0);
  };
  return same(a.vertices, b.vertices) && same(a.triangles, b.triangles);
}

}  // namespace

// 8 bytes of parameters, then the samples.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 8;
  if (size < kHead) return 0;
  ShellBox box{.samples = {},
               .data_samples = {1 + data[0] % 40, 1 + data[1] % 10, 1 + data[2] % 10},
               .origin = {data[3] & 1, data[3] >> 1 & 1, data[3] >> 2 & 1},
               .layers = data[4] & 63U,
               .layer_value = static_cast<float>(data[5])};
  const auto count =
      static_cast<std::size_t>(box.data_samples[0] * box.data_samples[1] * box.data_samples[2]);
  // Repeats the samples given if there are too few.
  std::vector<std::uint8_t> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    samples[i] = size > kHead ? data[kHead + i % (size - kHead)] : 0;
  }
  const std::ptrdiff_t row = box.data_samples[0];
  const std::ptrdiff_t slice = row * box.data_samples[1];
  const double isovalue = data[6] + data[7] / 16.0;
  const int levels = 1 << (data[4] >> 6);
  box.samples = SampleBlock<std::uint8_t>{.first = samples.data(), .row = row, .slice = slice};
  const Surface exact = through_bytes(box, {.isovalue = isovalue});
  require(equal(exact,
                through_bytes(box, {.isovalue = isovalue, .values = ShellValues::kLatticeExact})));
  const Surface quantized = through_bytes(
      box, {.isovalue = isovalue, .values = ShellValues::kQuantized, .levels_per_octave = levels});
  require(quantized.vertices.size() == exact.vertices.size());
  require(quantized.triangles.size() == exact.triangles.size());

  // The same bytes as floats, including special values.
  box.data_samples[0] /= 4;
  if (box.data_samples[0] == 0) return 0;
  std::vector<float> floats(count / 4);
  std::memcpy(floats.data(), samples.data(), floats.size() * sizeof(float));
  box.samples =
      SampleBlock<float>{.first = floats.data(),
                         .row = box.data_samples[0],
                         .slice = std::ptrdiff_t{box.data_samples[0]} * box.data_samples[1]};
  (void)through_bytes(box, {.isovalue = isovalue, .values = ShellValues::kLatticeExact});
  return 0;
}
