// Streams of sample shells from a server with hand-made steps.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/codec/shell_encoder.hpp"
#include "common/wire/tile.hpp"
#include "tests/server/gateway/gateway_client.hpp"
#include "tests/support/fake_steps.hpp"

namespace multitetra::testing {

// A ball in one shell if shells are requested, octahedra otherwise.
inline EncodedStep ball_step(const StepRequest& step) {
  if (!step.shell) return octahedron_step(step);
  const std::vector<std::uint8_t> samples = {0, 0, 0, 0, 1, 0, 0, 0, 0,  //
                                             0, 1, 0, 1, 9, 1, 0, 1, 0,  //
                                             0, 0, 0, 0, 1, 0, 0, 0, 0};
  const auto bytes =
      shell::encode_shell({.samples = shell::SampleBlock<std::uint8_t>{samples.data(), 3, 9},
                           .data_samples = {3, 3, 3},
                           .origin = {0, 0, 0}},
                          {.isovalue = 4.5,
                           .values = step.shell->values,
                           .levels_per_octave = step.shell->levels_per_octave,
                           .lattice_resolution = step.request.lattice_resolution,
                           .spacing_exponent = exponent_of(step.finest_spacing)});
  shell::ShellHeader header;
  EXPECT_EQ(read_shell_header(bytes->data(), bytes->size(), header), shell::ShellStatus::kOk);
  const auto payload = std::make_shared<const std::string>(bytes->begin(), bytes->end());
  return {.tiles = {{.summary = {.cube = {.exponent = 6},
                                 .digest = digest_of_bytes(*payload),
                                 .triangles = header.triangles,
                                 .vertices = header.vertices,
                                 .bytes = static_cast<std::uint32_t>(payload->size())},
                     .payload = payload}},
          .is_in_shells = true};
}

// All messages of a stream that is only displayed, from Welcome on.
inline std::vector<ServerMessage> shown_stream(WebSocketClient& client,
                                               const std::vector<PayloadCodec>& codecs,
                                               const std::string& token = {}) {
  client.send(Hello{.codecs = codecs, .token = token});
  EXPECT_EQ(client.receive_a<Welcome>().codecs, codecs);
  client.send(OpenStream{.request_id = 1,
                         .dataset = "octahedron",
                         .request = {.isovalue = 1, .error = 0.5},
                         .use = MeshUse::kDisplay});
  auto messages = all_of_stream(client);
  EXPECT_TRUE(std::holds_alternative<StreamEnd>(messages.back()));
  return messages;
}

inline const std::vector<PayloadCodec> kBothCodecs = {PayloadCodec::kDracoLattice,
                                                      PayloadCodec::kSampleShell};

inline std::shared_ptr<FakeSteps> balls() {
  return std::make_shared<FakeSteps>(
      "octahedron", [](const StepRequest& step, std::stop_token) { return ball_step(step); });
}

}  // namespace multitetra::testing
