// Any bytes are refused or give a sound mesh, in bounded time and memory.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "common/mesh/merged_tiles.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/sample_shells.hpp"

namespace multitetra {
namespace {

using shell::ShellHeader;
using shell::ShellStatus;
using shell::ShellValues;
using testing::box_in;
using testing::decode_shell;
using testing::DecodedShell;
using testing::OwnedBox;
namespace fields = testing::fields;

// Checks the guarantee of TileInCube::marched for arbitrary bytes: counting edges on the faces of
// the box alone gives the same topology as comparing all edges.
void expect_manifold(const std::vector<std::uint8_t>& bytes, const LatticeMesh& mesh) {
  ShellHeader header;
  ASSERT_EQ(shell::read_shell_header(bytes.data(), bytes.size(), header), ShellStatus::kOk);
  if (header.has_void || mesh.vertices.size() > 100'000) return;
  const auto corner = [&header](bool high) {
    const auto at = [&](int axis) {
      return (header.origin[axis] + (high ? header.samples[axis] - 1 : 0)) * header.steps();
    };
    return LatticePoint{at(0), at(1), at(2)};
  };
  const MarchedBox box = {corner(false), corner(true)};
  const DataBorder border = {.low = box.low, .high = box.high};
  const TileInCube tile = {.mesh = &mesh, .cube = {.exponent = 15}, .marched = box};
  const auto for_each = [](std::size_t count, const std::function<void(std::size_t)>& body) {
    for (std::size_t i = 0; i < count; ++i) body(i);
  };
  const MeshTopology counted =
      merged_tiles({&tile, 1}, header.lattice_resolution, border, for_each).topology;
  EXPECT_EQ(counted, topology(mesh, border));
  EXPECT_TRUE(counted.is_sound());
}

void expect_refused_or_sound(const std::vector<std::uint8_t>& bytes) {
  const DecodedShell decoded = decode_shell(bytes);
  if (decoded.status != ShellStatus::kOk) return;
  for (const TriangleIndices& triangle : decoded.mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      ASSERT_LT(corner, decoded.mesh.vertices.size());
    }
  }
  for (const LatticePoint& vertex : decoded.mesh.vertices) ASSERT_TRUE(is_on_lattice(vertex));
  expect_manifold(bytes, decoded.mesh);
}

std::vector<std::vector<std::uint8_t>> small_shells() {
  std::vector<std::vector<std::uint8_t>> shells;
  const auto add = [&](const Volume& volume, std::optional<double> outside,
                       const shell::ShellOptions& options) {
    const OwnedBox box = *box_in(volume, outside, outside ? 1 : 0, 1, {0, 0, 0}, {8, 8, 8});
    shells.push_back(*shell::encode_shell(box.box(), options));
  };
  add(fields::integer_noise({9, 9, 9}, 200, 1), std::nullopt, {.isovalue = 100});
  add(fields::integer_noise({7, 7, 7}, 200, 2), 7.0, {.isovalue = 100.5});
  add(fields::masked_gyroid(9, 3), std::nullopt,
      {.isovalue = 0.1, .values = ShellValues::kLatticeExact});
  add(fields::masked_gyroid(7, 4), 3.0,
      {.isovalue = 0.1, .values = ShellValues::kQuantized, .levels_per_octave = 2});
  return shells;
}

TEST(ShellDecoderRobustness, RejectsPrefixes) {
  for (const auto& bytes : small_shells()) {
    ASSERT_EQ(decode_shell(bytes).status, ShellStatus::kOk);
    // The decoder appends up to four zeros, so prefixes without the last bytes may decode.
    constexpr std::size_t kSupplied = 4;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const std::vector<std::uint8_t> prefix(bytes.begin(),
                                             bytes.begin() + static_cast<std::ptrdiff_t>(size));
      if (size + kSupplied < bytes.size()) {
        EXPECT_NE(decode_shell(prefix).status, ShellStatus::kOk) << size;
      } else {
        expect_refused_or_sound(prefix);
      }
    }
    std::vector<std::uint8_t> longer = bytes;
    longer.insert(longer.end(), kSupplied + 1, 0);
    EXPECT_EQ(decode_shell(longer).status, ShellStatus::kBadContents);
  }
}

TEST(ShellDecoderRobustness, RejectsOrDecodesSoundlyEveryChangedByte) {
  for (const auto& bytes : small_shells()) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      for (const int change : {0x01, 0x80, 0xff}) {
        std::vector<std::uint8_t> changed = bytes;
        changed[i] = static_cast<std::uint8_t>(changed[i] ^ change);
        expect_refused_or_sound(changed);
      }
    }
  }
}

TEST(ShellDecoderRobustness, RejectsOrDecodesSoundlyNoiseAfterAHeader) {
  std::mt19937_64 random(5);
  const auto shells = small_shells();
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<std::uint8_t> bytes = shells[static_cast<std::size_t>(trial) % shells.size()];
    ShellHeader header;
    ASSERT_EQ(shell::read_shell_header(bytes.data(), bytes.size(), header), ShellStatus::kOk);
    for (std::size_t i = header.raw_begin; i < bytes.size(); ++i) {
      bytes[i] = static_cast<std::uint8_t>(random());
    }
    expect_refused_or_sound(bytes);
  }
}

TEST(ShellDecoderRobustness, RejectsFewerVerticesThanTheSurfaceHas) {
  constexpr std::ptrdiff_t kVertices = 10;  // Where the header has their number.
  for (const auto& bytes : small_shells()) {
    std::ptrdiff_t end = kVertices + 1;
    while (bytes[static_cast<std::size_t>(end) - 1] >= 0x80) ++end;
    for (const int vertices : {0, 1, 2, 40}) {
      std::vector<std::uint8_t> changed(bytes.begin(), bytes.begin() + kVertices);
      changed.push_back(static_cast<std::uint8_t>(vertices));
      changed.insert(changed.end(), bytes.begin() + end, bytes.end());
      EXPECT_EQ(decode_shell(changed).status, ShellStatus::kBadContents) << vertices;
    }
  }
}

// A header of the largest box and of the largest sizes, followed by streams that repeat one byte.
TEST(ShellDecoderRobustness, DecodesTheLargestBoxInBoundedTime) {
  for (const int modes : {0x00, 0x10, 0x01, 0x11, 0x02, 0x1e}) {
    for (const int filler : {0x00, 0x55, 0xaa, 0xff}) {
      std::vector<std::uint8_t> bytes = {1, static_cast<std::uint8_t>(modes), 5, 0, 0, 0, 0, 63, 63,
                                         63};
      ShellHeader header;
      bytes.insert(bytes.end(), {0x80, 0x80, 0x74, 0x80, 0x80, 0x80, 0x01});
      if ((modes & 3) == 0) {
        bytes.insert(bytes.end(), {0, 0, 0, 0, 0, 0, 0x59, 0x40});  // 100
      } else {
        bytes.insert(bytes.end(), {0, 0x80, 0x14, 0});
      }
      bytes.push_back(0);
      bytes.resize(bytes.size() + 500000, static_cast<std::uint8_t>(filler));
      ASSERT_EQ(shell::read_shell_header(bytes.data(), bytes.size(), header), ShellStatus::kOk)
          << modes;
      EXPECT_LE(header.vertices, shell::max_vertices(header));
      EXPECT_LE(header.triangles, shell::max_triangles(header));
      const auto start = std::chrono::steady_clock::now();
      expect_refused_or_sound(bytes);
      EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
    }
  }
}

TEST(ReadShellHeader, RejectsFieldsOutOfTheirRange) {
  const std::vector<std::uint8_t> good = small_shells()[0];
  const auto status = [&](std::size_t at, std::uint8_t byte) {
    std::vector<std::uint8_t> bytes = good;
    bytes[at] = byte;
    ShellHeader header;
    return shell::read_shell_header(bytes.data(), bytes.size(), header);
  };
  EXPECT_EQ(status(0, 1), ShellStatus::kOk);
  EXPECT_EQ(status(0, 2), ShellStatus::kUnknownVersion);
  EXPECT_EQ(status(1, 3), ShellStatus::kBadHeader);     // No such values.
  EXPECT_EQ(status(1, 4), ShellStatus::kBadHeader);     // Exact shells have no levels.
  EXPECT_EQ(status(1, 0x20), ShellStatus::kBadHeader);  // An undefined bit.
  EXPECT_EQ(status(2, 0), ShellStatus::kBadHeader);     // No lattice.
  EXPECT_EQ(status(2, 9), ShellStatus::kBadHeader);     // The lattice is too fine.
  EXPECT_EQ(status(3, 64), ShellStatus::kBadHeader);    // A seventh side.
  EXPECT_EQ(status(7, 64), ShellStatus::kBadHeader);    // 66 samples.
  ShellHeader header;
  for (std::size_t size = 0; size < 20; ++size) {
    EXPECT_NE(shell::read_shell_header(good.data(), size, header), ShellStatus::kOk);
  }
  EXPECT_EQ(shell::read_shell_header(nullptr, 0, header), ShellStatus::kUnknownVersion);
}

}  // namespace
}  // namespace multitetra
