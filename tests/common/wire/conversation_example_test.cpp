// The example conversation in tests/golden/conversation.txt equals the encoder's bytes.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "common/net/frame.hpp"
#include "common/wire/messages.hpp"
#include "common/wire/shell_tile.hpp"

namespace multitetra {
namespace {

struct Spoken {
  std::string title;  // "client: Hello"
  std::string frame;  // Header and content.
};

// The file has titles at the start of a line, each followed by indented lines of hexadecimal bytes.
std::vector<Spoken> example() {
  const auto path = std::filesystem::path(MULTITETRA_TEST_DATA) / "conversation.txt";
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::vector<Spoken> spoken;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(' ')) {
      spoken.push_back({line, ""});
    } else {
      EXPECT_FALSE(spoken.empty()) << "bytes before the first title";
      if (spoken.empty()) return spoken;
      std::istringstream bytes(line);
      for (std::string byte; bytes >> byte;) {
        spoken.back().frame.push_back(static_cast<char>(std::stoi(byte, nullptr, 16)));
      }
    }
  }
  return spoken;
}

std::string hex(const std::string& bytes) {
  std::ostringstream text;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    constexpr const char* kDigits = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(bytes[at]);
    text << (at % 32 == 0 ? "\n    " : " ") << kDigits[byte >> 4] << kDigits[byte & 15];
  }
  return text.str();
}

template <typename Message>
std::string framed_message(const Message& message) {
  const std::string content = serialize(message);
  return frame_header(static_cast<std::uint32_t>(content.size())) + content;
}

// One triangle around a corner of the grid, at lattice resolution 5.
LatticeMesh triangle() {
  return index_triangles(
      std::vector<LatticeTriangle>{{LatticePoint{16, 0, 0}, {0, 16, 0}, {0, 0, 16}}}, 5);
}

std::string shell_example() {
  std::ifstream file(std::filesystem::path(MULTITETRA_TEST_DATA) / "shell_example.bin",
                     std::ios::binary);
  EXPECT_TRUE(file);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The expected content of the file. The payload of the tile is an argument, as Draco's bytes may
// differ between versions.
std::vector<Spoken> expected(const std::string& payload) {
  const IsosurfaceRequest request{.isovalue = 60.5};
  const LatticeMesh mesh = triangle();
  StepBegin begin{.request_id = 1, .is_final = true, .request = request, .error_bound_world = 1};
  begin.tetrahedra = 24;
  begin.active_tetrahedra = 1;
  begin.tiles = {{.cube = {1, 0, 0, 0},
                  .digest = digest(mesh),
                  .triangles = 1,
                  .vertices = 3,
                  .bytes = static_cast<std::uint32_t>(payload.size())}};
  // The example of the codec: the surface around one sample.
  const auto shell = std::make_shared<const std::string>(shell_example());
  StepBegin in_shells{.request_id = 2,
                      .is_final = true,
                      .request = {.isovalue = 34.5, .error = 0},
                      .shell = ShellStep{}};
  in_shells.tiles = {{.cube = {1, 0, 0, 0},
                      .digest = digest_of_bytes(*shell),
                      .triangles = 48,
                      .vertices = 26,
                      .bytes = static_cast<std::uint32_t>(shell->size())}};
  const std::vector kBoth = {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
  const Tile tile{.request_id = 1, .payload = std::make_shared<const std::string>(payload)};
  const StepEnd end{.request_id = 1,
                    .tiles_sent = 1,
                    .payload_bytes = payload.size(),
                    .digest = digest(mesh),
                    .seconds = 0.25};
  return {
      {"client: Hello", framed_message(ClientMessage(Hello{.codecs = kBoth, .agent = "demo"}))},
      {"server: Welcome",
       framed_message(ServerMessage(
           Welcome{.codecs = kBoth, .agent = "demo", .max_message_bytes = kMaxClientFrameBytes}))},
      {"client: OpenStream",
       framed_message(ClientMessage(OpenStream{.request_id = 1,
                                               .dataset = "corner",
                                               .request = request,
                                               .steps = StepPolicy::kFinalOnly}))},
      {"server: StepBegin", framed_message(ServerMessage(begin))},
      {"server: Tile", framed_message(ServerMessage(tile))},
      {"server: StepEnd", framed_message(ServerMessage(end))},
      {"server: StreamEnd", framed_message(ServerMessage(StreamEnd{.request_id = 1, .steps = 1}))},
      {"client: Cancel", framed_message(ClientMessage(Cancel{.request_id = 1}))},
      {"client: OpenStream",
       framed_message(ClientMessage(OpenStream{.request_id = 2,
                                               .dataset = "drop",
                                               .request = in_shells.request,
                                               .steps = StepPolicy::kFinalOnly,
                                               .use = MeshUse::kDisplay}))},
      {"server: StepBegin", framed_message(ServerMessage(in_shells))},
      {"server: Tile", framed_message(ServerMessage(Tile{.request_id = 2, .payload = shell}))},
      {"server: StepEnd", framed_message(ServerMessage(StepEnd{.request_id = 2,
                                                               .tiles_sent = 1,
                                                               .payload_bytes = shell->size(),
                                                               .digest = digest_of_bytes(*shell),
                                                               .seconds = 0.25}))},
      {"server: StreamEnd", framed_message(ServerMessage(StreamEnd{.request_id = 2, .steps = 1}))},
      {"client: OpenStream",
       framed_message(ClientMessage(OpenStream{.request_id = 3, .dataset = "coroner"}))},
      {"server: ErrorReply",
       framed_message(ServerMessage(ErrorReply{
           .request_id = 3,
           .error = {ErrorCode::kUnknownDataset,
                     "No dataset is named \"coroner\"; ListDatasets lists the datasets."}}))},
  };
}

std::string golden_payload(const std::vector<Spoken>& spoken) {
  for (const Spoken& s : spoken) {
    if (s.title != "server: Tile" || s.frame.size() <= kFrameHeaderBytes) continue;
    const auto message = parse_server_message(s.frame.substr(kFrameHeaderBytes));
    if (message && std::holds_alternative<Tile>(*message)) return *std::get<Tile>(*message).payload;
  }
  ADD_FAILURE() << "The file has no tile. One would be:"
                << hex(*encode_tile(triangle(), {1, 0, 0, 0}).payload);
  return *encode_tile(triangle(), {1, 0, 0, 0}).payload;
}

TEST(ConversationExample, MatchesTheGoldenBytes) {
  const std::vector<Spoken> golden = example();
  const std::vector<Spoken> computed = expected(golden_payload(golden));
  std::string all;
  for (const Spoken& s : computed) all += s.title + hex(s.frame) + "\n";
  ASSERT_EQ(golden.size(), computed.size()) << "Expected in the file:\n" << all;
  for (std::size_t i = 0; i < computed.size(); ++i) {
    EXPECT_EQ(golden[i].title, computed[i].title);
    EXPECT_EQ(hex(golden[i].frame), hex(computed[i].frame)) << computed[i].title;
  }
}

TEST(ConversationExample, DecodesToTheDocumentedTriangle) {
  FrameReader reader(kMaxServerFrameBytes);
  for (const Spoken& spoken : example()) {
    if (spoken.title.starts_with("server")) reader.feed(spoken.frame);
  }
  std::optional<TileSummary> promised;
  std::optional<ShellStep> shell;
  std::size_t triangles_of_shell = 0;
  std::optional<LatticeMesh> mesh;
  while (true) {
    const auto frame = reader.next();
    ASSERT_TRUE(frame) << frame.error().text;
    if (!*frame) break;
    const auto message = parse_server_message(**frame);
    ASSERT_TRUE(message) << message.error().error.text;
    if (const auto* begin = std::get_if<StepBegin>(&*message)) {
      promised = begin->tiles.at(0);
      shell = begin->shell;
    }
    if (const auto* tile = std::get_if<Tile>(&*message)) {
      ASSERT_TRUE(promised);
      if (shell) {
        const auto marched = decode_shell_tile(*tile->payload, *promised, {.shell = *shell});
        ASSERT_TRUE(marched) << marched.error().text;
        triangles_of_shell = marched->triangles.size();
        continue;
      }
      const auto decoded = decode_tile(*tile->payload, *promised, 5);
      ASSERT_TRUE(decoded) << decoded.error().text;
      mesh = *decoded;
    }
  }
  ASSERT_TRUE(mesh);
  EXPECT_EQ(digest(*mesh), digest(triangle()));
  EXPECT_EQ(triangles_of_shell, 48U);
}

}  // namespace
}  // namespace multitetra
