// Assembling steps of sample shells, from correct and from faulty servers.
#include <functional>

#include <gtest/gtest.h>

#include "client/library/assembler.hpp"
#include "common/codec/shell_encoder.hpp"
#include "common/wire/shell_tile.hpp"
#include "tests/support/octahedra.hpp"

namespace multitetra {
namespace {

using testing::octahedra_info;

constexpr std::uint64_t kShellStreamId = 5;
constexpr ShellStep kShell = quantized_shells(1);

// A ball in 33^3 samples.
const std::vector<std::uint8_t>& ball() {
  static const std::vector<std::uint8_t> samples = [] {
    std::vector<std::uint8_t> all;
    for (int z = -16; z <= 16; ++z) {
      for (int y = -16; y <= 16; ++y) {
        for (int x = -16; x <= 16; ++x) {
          all.push_back(static_cast<std::uint8_t>(255 - (x * x + y * y + z * z) / 4));
        }
      }
    }
    return all;
  }();
  return samples;
}

EncodedTile shell_in(const OctreeCube& cube, const ShellStep& shell = kShell,
                     double isovalue = 230.5) {
  const std::ptrdiff_t low = 16 * (cube.x + 33 * (cube.y + 33 * std::ptrdiff_t{cube.z}));
  const auto bytes = shell::encode_shell(
      {.samples =
           shell::SampleBlock<std::uint8_t>{
               .first = ball().data() + low, .row = 33, .slice = 33 * 33},
       .data_samples = {17, 17, 17},
       .origin = {16 * cube.x, 16 * cube.y, 16 * cube.z}},
      {.isovalue = isovalue, .values = shell.values, .levels_per_octave = shell.levels_per_octave});
  shell::ShellHeader header;
  EXPECT_EQ(read_shell_header(bytes->data(), bytes->size(), header), shell::ShellStatus::kOk);
  const auto payload = std::make_shared<const std::string>(bytes->begin(), bytes->end());
  return {.summary = {.cube = cube,
                      .digest = digest_of_bytes(*payload),
                      .triangles = header.triangles,
                      .vertices = header.vertices,
                      .bytes = static_cast<std::uint32_t>(payload->size())},
          .payload = payload};
}

OpenStream to_display() {
  return {.request_id = kShellStreamId,
          .dataset = "octahedra",
          .request = {.isovalue = 230.5, .error = 0.5},
          .use = MeshUse::kDisplay};
}

struct ShellStream {
  StepBegin begin;
  std::vector<EncodedTile> tiles;
};

ShellStream honest_stream() {
  ShellStream stream;
  for (int i = 0; i < 8; ++i) {
    stream.tiles.push_back(shell_in(OctreeCube{.exponent = 5}.child(i)));
  }
  stream.begin = {.request_id = kShellStreamId,
                  .is_final = true,
                  .request = to_display().request,
                  .error_bound_world = error_bound(kShell, DatasetInfo{}, 1),
                  .shell = kShell};
  return stream;
}

// Returns the committed step, or the check that failed.
Result<CommittedStepPtr> assembled_step(ShellStream stream, const OpenStream& open = to_display()) {
  StepEnd end{.request_id = kShellStreamId};
  for (const EncodedTile& tile : stream.tiles) {
    stream.begin.tiles.push_back(tile.summary);
    end.digest += tile.summary.digest;
    ++end.tiles_sent;
    end.payload_bytes += tile.payload->size();
  }
  Assembler assembler(octahedra_info(), open);
  std::vector<ServerMessage> messages = {stream.begin};
  for (std::uint32_t i = 0; i < stream.tiles.size(); ++i) {
    messages.push_back(Tile{kShellStreamId, 0, i, stream.tiles[i].payload});
  }
  messages.push_back(end);
  for (const ServerMessage& message : messages) {
    const auto progress = assembler.receive(message);
    if (!progress) return tl::unexpected(progress.error());
  }
  return assembler.shown();
}

void expect_refused_shells(const std::function<void(ShellStream&)>& spoil, const std::string& words,
                           const OpenStream& open = to_display()) {
  ShellStream stream = honest_stream();
  spoil(stream);
  const auto step = assembled_step(std::move(stream), open);
  ASSERT_FALSE(step) << "expected: " << words;
  EXPECT_EQ(step.error().code, ErrorCode::kDamagedData);
  EXPECT_NE(step.error().text.find(words), std::string::npos) << step.error().text;
}

// Replaces a tile's payload and announces it in the manifest.
void put_payload(EncodedTile& tile, std::string payload) {
  tile.summary.digest = digest_of_bytes(payload);
  tile.summary.bytes = static_cast<std::uint32_t>(payload.size());
  tile.payload = std::make_shared<const std::string>(std::move(payload));
}

TEST(AssembledShells, FormAClosedSurface) {
  const auto step = assembled_step(honest_stream());
  ASSERT_TRUE(step) << step.error().text;
  EXPECT_TRUE((*step)->topology.is_sound());
  EXPECT_EQ((*step)->topology.euler_characteristic, 2);
  EXPECT_EQ((*step)->topology.components, 1);
  EXPECT_EQ((*step)->topology.border_edges, 0);
}

TEST(AssembledShells, DecodeWhenRequested) {
  ShellStream stream = honest_stream();
  for (const EncodedTile& tile : stream.tiles) stream.begin.tiles.push_back(tile.summary);
  Assembler assembler(octahedra_info(), to_display());
  ASSERT_TRUE(assembler.receive(stream.begin));
  ASSERT_TRUE(assembler.receive(Tile{kShellStreamId, 0, 3, stream.tiles[3].payload}));
  ASSERT_TRUE(assembler.decode_waiting());
  const auto held = assembler.held().find(stream.tiles[3].summary.digest);
  ASSERT_NE(held, assembler.held().end());
  EXPECT_EQ(held->second->triangles.size(), stream.tiles[3].summary.triangles);
}

TEST(AssembledShells, RejectsOtherBytesThanPromisedAndNamesTheTile) {
  for (const std::size_t at : {0U, 5U, 40U}) {
    expect_refused_shells(
        [at](ShellStream& stream) {
          std::string changed = *stream.tiles[3].payload;
          changed[at] = static_cast<char>(changed[at] ^ 4);
          stream.tiles[3].payload = std::make_shared<const std::string>(changed);
        },
        "tile 3 (cube 4:1/1/0)");
  }
}

TEST(AssembledShells, RejectsUndecodableShellsAndNamesTheTile) {
  expect_refused_shells(
      [](ShellStream& stream) {
        const std::string& whole = *stream.tiles[6].payload;
        put_payload(stream.tiles[6], whole.substr(0, whole.size() / 2));
      },
      "tile 6 (cube 4:0/1/1)");
  expect_refused_shells([](ShellStream& stream) { put_payload(stream.tiles[6], "x"); },
                        "tile 6 (cube 4:0/1/1)");
}

TEST(AssembledShells, RejectsShellsThatDifferFromTheManifest) {
  expect_refused_shells([](ShellStream& s) { ++s.tiles[1].summary.triangles; }, "tile 1");
  expect_refused_shells([](ShellStream& s) { --s.tiles[1].summary.vertices; }, "tile 1");
  expect_refused_shells(
      [](ShellStream& s) { s.tiles[1] = shell_in(s.tiles[1].summary.cube, quantized_shells(2)); },
      "tile 1");
  expect_refused_shells(
      [](ShellStream& s) {
        s.tiles[1] = shell_in(s.tiles[1].summary.cube, {.values = shell::ShellValues::kExact});
      },
      "tile 1");
  expect_refused_shells(
      [](ShellStream& s) {
        s.begin.finest_spacing = 2;
        s.begin.is_final = false;
        s.begin.error_bound_world *= 2;
      },
      "spacing");
  expect_refused_shells([](ShellStream& s) { s.tiles[1].summary.cube = {3, 7, 7, 7}; }, "tile 1");
}

TEST(AssembledShells, RejectsShellsThatLeaveAHole) {
  expect_refused_shells([](ShellStream& stream) { stream.tiles.pop_back(); }, "open edges");
}

// Each shell is a valid tile, but vertices at their common border do not match.
TEST(AssembledShells, RejectsShellsThatDoNotMeetTheirNeighbors) {
  for (const double isovalue : {229.5, 240.5}) {
    expect_refused_shells(
        [isovalue](ShellStream& stream) {
          stream.tiles[2] = shell_in(stream.tiles[2].summary.cube, kShell, isovalue);
        },
        "open edges");
  }
}

TEST(AssembledShells, RejectsOverlappingShells) {
  expect_refused_shells(
      [](ShellStream& stream) { stream.tiles[0].summary.cube = OctreeCube{.exponent = 5}; },
      "overlap");
}

TEST(AssembledShells, AreRejectedByClientsThatKeepTheMesh) {
  OpenStream to_keep = to_display();
  to_keep.use = MeshUse::kKeep;
  expect_refused_shells([](ShellStream&) {}, "client keeps its mesh", to_keep);
}

TEST(AssembledShells, HaveTheBoundOfTheirValues) {
  expect_refused_shells([](ShellStream& s) { s.begin.error_bound_world /= 2; }, "error bound");
  expect_refused_shells([](ShellStream& s) { s.begin.error_bound_world = 0; }, "error bound");
}

}  // namespace
}  // namespace multitetra
