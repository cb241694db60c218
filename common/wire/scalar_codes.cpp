#include "common/wire/scalar_codes.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace multitetra {
namespace {

std::vector<std::uint32_t> order_of(std::span<const LatticePoint> vertices) {
  std::vector<std::uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return vertices[a].key() < vertices[b].key();
  });
  return order;
}

}  // namespace

std::string encode_scalars(std::span<const LatticePoint> vertices, std::span<const double> values,
                           const ScalarRange& range) {
  assert(values.size() == vertices.size());
  std::string codes;
  codes.reserve(values.size() * static_cast<std::size_t>(range.bits) / 8);
  for (const std::uint32_t vertex : order_of(vertices)) {
    const std::uint32_t code = range.code_of(values[vertex]);
    codes.push_back(static_cast<char>(code & 0xFF));
    if (range.bits == 16) codes.push_back(static_cast<char>(code >> 8));
  }
  return codes;
}

Result<std::vector<float>> decode_scalars(std::string_view codes,
                                          std::span<const LatticePoint> vertices,
                                          const ScalarRange& range) {
  const std::size_t width = static_cast<std::size_t>(range.bits) / 8;
  if (codes.size() != width * vertices.size()) {
    return fail(ErrorCode::kDamagedData, "There are " + std::to_string(codes.size()) +
                                             " bytes of scalars; " +
                                             std::to_string(vertices.size()) + " vertices need " +
                                             std::to_string(width * vertices.size()) + ".");
  }
  std::vector<float> values(vertices.size());
  const auto byte = [&](std::size_t at) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(codes[at]));
  };
  std::size_t at = 0;
  for (const std::uint32_t vertex : order_of(vertices)) {
    values[vertex] = range.value_of(width == 1 ? byte(at) : byte(at) | byte(at + 1) << 8);
    at += width;
  }
  return values;
}

}  // namespace multitetra
