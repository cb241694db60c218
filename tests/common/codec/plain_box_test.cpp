// Plain boxes of samples give what core's marching tetrahedra make of the same samples; arbitrary
// bytes are refused or give a mesh inside the box.
#include "common/codec/plain_box.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <variant>
#include <vector>

#include "tests/support/fields.hpp"
#include "tests/support/sample_shells.hpp"

namespace multitetra {
namespace {

using shell::kPlainHeaderBytes;
using shell::PlainBoxMarcher;
using shell::ShellHeader;
using shell::ShellStatus;
using shell::ShellTriangle;
using shell::ShellVertex;
using testing::boxes_of;
using testing::OwnedBox;
using testing::sorted_triangles;
namespace fields = testing::fields;

using Bytes = std::vector<std::uint8_t>;

constexpr int kResolution = 5;

template <typename Number>
void put(Bytes& bytes, std::size_t at, Number number) {
  std::memcpy(bytes.data() + at, &number, sizeof(number));
}

Bytes plain(const OwnedBox& box, double isovalue, int spacing_exponent) {
  Bytes bytes(kPlainHeaderBytes);
  bytes[0] = shell::kPlainVersion;
  bytes[1] = static_cast<std::uint8_t>(box.samples.index());
  bytes[2] = static_cast<std::uint8_t>(kResolution | spacing_exponent << 4);
  bytes[3] = static_cast<std::uint8_t>(box.layers);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    put(bytes, 4 + 4 * at, box.origin[at]);
    put(bytes, 16 + 4 * at, std::int32_t{box.size(axis)});
  }
  put(bytes, 36, box.layer_value);
  put(bytes, 40, isovalue);
  std::visit(
      [&](const auto& samples) {
        const auto* const first = reinterpret_cast<const std::uint8_t*>(samples.data());
        bytes.insert(bytes.end(), first, first + sizeof(samples[0]) * samples.size());
      },
      box.samples);
  return bytes;
}

struct Marched {
  ShellStatus status = ShellStatus::kOk;
  LatticeMesh mesh;
};

// Counts, then marches with these counts in the header.
Marched decoded(Bytes bytes) {
  static const auto marcher = std::make_unique<PlainBoxMarcher>();
  ShellHeader header;
  Marched result{.status = read_plain_header(bytes.data(), bytes.size(), header), .mesh = {}};
  if (result.status != ShellStatus::kOk) return result;
  std::vector<ShellVertex> vertices(header.has_void ? max_vertices(header) : 0);
  std::vector<ShellTriangle> triangles(header.has_void ? max_triangles(header) : 0);
  marcher->count(bytes.data(), header, vertices.data(), triangles.data());
  put(bytes, 28, header.vertices);
  put(bytes, 32, header.triangles);
  EXPECT_EQ(read_plain_header(bytes.data(), bytes.size(), header), ShellStatus::kOk);
  vertices.resize(header.vertices);
  triangles.resize(header.triangles);
  result.status = marcher->decode(bytes.data(), header, vertices.data(), triangles.data());
  result.mesh.resolution = header.lattice_resolution;
  for (const auto& v : vertices) result.mesh.vertices.push_back({v.x, v.y, v.z});
  for (const auto& t : triangles) {
    result.mesh.triangles.push_back({t.corners[0], t.corners[1], t.corners[2]});
  }
  return result;
}

void expect_marched(const Volume& volume, std::optional<double> outside, std::int32_t margin,
                    double isovalue, int spacing_exponent = 0) {
  std::size_t triangles = 0;
  for (const int cells : {16, 64}) {
    for (const OwnedBox& box : boxes_of(volume, outside, margin, 1 << spacing_exponent, cells)) {
      const Marched found = decoded(plain(box, isovalue, spacing_exponent));
      EXPECT_EQ(found.status, ShellStatus::kOk);
      const auto value = [&box](int x, int y, int z) {
        return static_cast<double>(box.value(x, y, z));
      };
      EXPECT_EQ(sorted_triangles(found.mesh),
                sorted_triangles(
                    testing::marched(box, isovalue, kResolution, 1 << spacing_exponent, value)));
      triangles += found.mesh.triangles.size();
    }
  }
  EXPECT_GT(triangles, 1000U);
}

TEST(PlainBox, HasTheSurfaceOfMarchingTetrahedra) {
  const auto wave = [](double low, double high) {
    return [low, high](int x, int y, int z) {
      return low + (high - low) * (0.5 + 0.3 * std::sin(0.4 * x) * std::cos(0.5 * z + 0.3 * y));
    };
  };
  const std::array<std::int32_t, 3> dims = {37, 30, 21};
  expect_marched(fields::sampled<std::uint8_t>(dims, wave(0, 255)), std::nullopt, 0, 100);
  expect_marched(fields::sampled<std::int8_t>(dims, wave(-128, 127)), 120.5, 1, -12.5);
  expect_marched(fields::sampled<std::uint16_t>(dims, wave(0, 65535)), 0.0, 1, 30000);
  expect_marched(fields::sampled<std::int16_t>(dims, wave(-32768, 32767)), std::nullopt, 0, 99.5);
  expect_marched(fields::gyroid(25, 0.3, 6), std::nullopt, 0, 0.1);
  expect_marched(fields::noise({19, 24, 17}, 7), 0.0, 1, 0.5, 1);
}

TEST(PlainBox, OmitsTetrahedraWithVoidSamples) {
  expect_marched(fields::masked_gyroid(33, 8), std::nullopt, 0, 0.1);
  expect_marched(fields::masked_gyroid(33, 8), 0.5, 1, 0.1);
}

TEST(PlainBox, RejectsOtherCounts) {
  const OwnedBox box = boxes_of(fields::gyroid(17, 0.3, 6), std::nullopt, 0, 1, 16).front();
  Bytes bytes = plain(box, 0.1, 0);
  ShellHeader header;
  ASSERT_EQ(read_plain_header(bytes.data(), bytes.size(), header), ShellStatus::kOk);
  EXPECT_EQ(std::make_unique<PlainBoxMarcher>()->decode(bytes.data(), header, nullptr, nullptr),
            ShellStatus::kBadContents);
}

TEST(PlainBox, RejectsInfiniteSamples) {
  const OwnedBox box = boxes_of(fields::gyroid(17, 0.3, 6), std::nullopt, 0, 1, 16).front();
  Bytes bytes = plain(box, 0.1, 0);
  put(bytes, kPlainHeaderBytes + 40, std::numeric_limits<float>::infinity());
  EXPECT_EQ(decoded(bytes).status, ShellStatus::kBadContents);
}

TEST(PlainBox, RefusesArbitraryBytesOrStaysInTheBox) {
  std::mt19937 random(1);
  const OwnedBox box = boxes_of(fields::masked_gyroid(17, 8), 0.5, 1, 1, 16).front();
  const Bytes whole = plain(box, 0.1, 0);
  EXPECT_EQ(decoded(Bytes(whole.begin(), whole.end() - 1)).status, ShellStatus::kBadHeader);
  EXPECT_EQ(decoded({}).status, ShellStatus::kUnknownVersion);
  int accepted = 0;
  for (int round = 0; round < 600; ++round) {
    Bytes bytes = whole;
    const bool is_header = round % 3 != 0;
    const std::size_t end = is_header ? kPlainHeaderBytes : bytes.size();
    for (int i = 0; i < 2; ++i)
      bytes[1 + random() % (end - 1)] = static_cast<std::uint8_t>(random());
    const Marched found = decoded(bytes);
    if (found.status != ShellStatus::kOk) continue;
    ++accepted;
    for (const LatticePoint& vertex : found.mesh.vertices) ASSERT_TRUE(is_on_lattice(vertex));
  }
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace multitetra
