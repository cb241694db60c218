#include "common/wire/messages.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "common/net/frame.hpp"
#include "common/request/default_error.hpp"
#include "common/request/surface_query.hpp"
#include "tests/support/sample_messages.hpp"

namespace multitetra {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ---- round trips

TEST(Messages, RoundTripClientMessages) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 500; ++i) {
    for (std::size_t kind = 0; kind < std::variant_size_v<ClientMessage>; ++kind) {
      const ClientMessage message = samples::client_message(kind, random);
      const auto parsed = parse_client_message(serialize(message));
      ASSERT_TRUE(parsed) << parsed.error().error.text;
      EXPECT_TRUE(samples::same(*parsed, message)) << "kind " << kind;
    }
  }
}

TEST(Messages, RoundTripServerMessages) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    for (std::size_t kind = 0; kind < std::variant_size_v<ServerMessage>; ++kind) {
      const ServerMessage message = samples::server_message(kind, random);
      const auto parsed = parse_server_message(serialize(message));
      ASSERT_TRUE(parsed) << parsed.error().error.text;
      EXPECT_TRUE(samples::same(*parsed, message)) << "kind " << kind;
    }
  }
}

// A request with the maximum of everything.
IsosurfaceRequest largest_request() {
  std::mt19937_64 random(4);
  IsosurfaceRequest request = samples::request(random);
  request.thresholds.view = samples::threshold_view(random);
  const BoxShape longest{.low = {1.5, 2.5, 3.5}, .high = {4.5, 5.5, 6.5}};
  request.thresholds.regions.assign(kMaxThresholdRegions, {.shape = longest, .threshold = 1});
  ThresholdGrid grid{.dims = {64, 64, 32}};
  grid.thresholds.assign(kMaxGridThresholds, 1);
  request.thresholds.grid = std::make_shared<const ThresholdGrid>(grid);
  return request;
}

TEST(Messages, FitIntoAFrameAtTheirLargest) {
  OpenStream open{
      .request_id = ~0ULL, .dataset = std::string(255, 'x'), .request = largest_request()};
  open.cached_tile_digests.assign(kMaxHeldDigests, ContentDigest{1, 2});
  const std::string longest = serialize(ClientMessage(open));
  EXPECT_LE(longest.size(), kMaxClientFrameBytes);
  EXPECT_TRUE(parse_client_message(longest));
  StepBegin begin{.request_id = 1};
  begin.tiles.assign(200000, TileSummary{.cube = {5, 1000, 1000, 1000},
                                         .digest = {~0ULL, ~0ULL},
                                         .triangles = 20000,
                                         .vertices = 10000,
                                         .bytes = 30000});
  const std::string bytes = serialize(ServerMessage(begin));
  EXPECT_LE(bytes.size(), kMaxServerFrameBytes);
  EXPECT_TRUE(parse_server_message(bytes));
}

// ---- malformed messages are refused

template <typename Parse>
void expect_calm(const Parse& parse, std::string bytes, std::mt19937_64& random) {
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto parsed = parse(bytes.substr(0, length));
    if (!parsed) {
      EXPECT_FALSE(parsed.error().error.text.empty());
    }
  }
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(random());
    const auto parsed = parse(changed);
    if (!parsed) {
      EXPECT_FALSE(parsed.error().error.text.empty());
    }
  }
}

TEST(Messages, ReadOrRejectTruncatedAndChangedBytes) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 10; ++i) {
    for (std::size_t kind = 0; kind < std::variant_size_v<ClientMessage>; ++kind) {
      expect_calm(parse_client_message, serialize(samples::client_message(kind, random)), random);
    }
    for (std::size_t kind = 0; kind < std::variant_size_v<ServerMessage>; ++kind) {
      expect_calm(parse_server_message, serialize(samples::server_message(kind, random)), random);
    }
  }
}

TEST(Messages, RejectUnknownKinds) {
  for (const std::string_view bytes : {std::string_view(""), std::string_view("\x7A\1x"),
                                       std::string_view("\xFF"), std::string_view("hello")}) {
    const auto from_client = parse_client_message(bytes);
    ASSERT_FALSE(from_client);
    EXPECT_EQ(from_client.error().error.code, ErrorCode::kMalformedMessage);
    const auto from_server = parse_server_message(bytes);
    ASSERT_FALSE(from_server);
    EXPECT_EQ(from_server.error().error.code, ErrorCode::kMalformedMessage);
  }
}

// A field of wire type "length-delimited"; requires number < 16 and content.size() < 128.
std::string field(int number, const std::string& content) {
  return std::string{static_cast<char>(number << 3 | 2), static_cast<char>(content.size())} +
         content;
}

TEST(Messages, IgnoreUnknownFieldsOfNewerPeers) {
  const std::string bytes = serialize(ClientMessage(Ping{7}));
  const std::string unknown = "\x78\x05" + field(14, "regions");
  for (const std::string& newer : {bytes + unknown, unknown + bytes, bytes + field(5, unknown)}) {
    const auto parsed = parse_client_message(newer);
    ASSERT_TRUE(parsed) << parsed.error().error.text;
    EXPECT_EQ(std::get<Ping>(*parsed).value, 7U);
  }
}

TEST(Messages, GiveAbsentFieldsTheirDocumentedDefaults) {
  const auto hello = parse_client_message(field(1, ""));
  ASSERT_TRUE(hello);
  EXPECT_TRUE(samples::same(*hello, ClientMessage(Hello{})));
  const auto open = parse_client_message(field(3, "\x08\x01" + field(2, "fuel")));
  ASSERT_TRUE(open) << open.error().error.text;
  const OpenStream defaults{
      .request_id = 1, .dataset = "fuel", .request = {.error = kDefaultError, .simplify = true}};
  EXPECT_TRUE(samples::same(*open, ClientMessage(defaults)));
  EXPECT_EQ(defaults.request.lattice_resolution, 5);
}

TEST(Messages, RejectHelloWithoutDracoAndReadKnownCodecs) {
  for (const std::string codecs : {"\x09", "\x02"}) {
    const auto refused = parse_client_message(field(1, field(3, codecs)));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().error.code, ErrorCode::kInvalidArgument);
  }
  const auto mixed = parse_client_message(field(1, field(3, "\x09\x02\x01\x02")));
  ASSERT_TRUE(mixed);
  EXPECT_EQ(std::get<Hello>(*mixed).codecs,
            (std::vector{PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell}));
}

TEST(Messages, RejectTextThatIsNotUtf8) {
  const auto parsed = parse_client_message(field(3, "\x08\x01" + field(2, "fu\xFF")));
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().error.code, ErrorCode::kMalformedMessage);
}

TEST(Messages, ReplaceInvalidUtf8InErrorTexts) {
  const auto text_of = [](const std::string& text) {
    const ErrorReply reply{.request_id = 4, .error = {ErrorCode::kInternal, text}};
    const auto parsed = parse_server_message(serialize(ServerMessage(reply)));
    return parsed ? std::get<ErrorReply>(*parsed).error.text : parsed.error().error.text;
  };
  EXPECT_EQ(text_of("caf\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x90\x9F"),
            "caf\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x90\x9F");
  EXPECT_EQ(text_of("a\xFFz\xC3"), "a?z?");
  EXPECT_EQ(text_of("\xE0\x80\x80"), "???") << "overlong";
  EXPECT_EQ(text_of("\xED\xA0\x80"), "???") << "surrogate";
  EXPECT_EQ(text_of("\xF4\x90\x80\x80"), "????") << "beyond U+10FFFF";
}

TEST(Messages, ReadUnknownErrorCodesAsUnknown) {
  const auto parsed = parse_server_message(field(7, "\x10\x63"));
  ASSERT_TRUE(parsed);
  EXPECT_EQ(std::get<ErrorReply>(*parsed).error.code, ErrorCode::kUnknown);
}

// ---- values out of range are refused by name, and the conversation can continue

template <typename Message>
void expect_refused(Message message, const std::function<void(Message&)>& spoil,
                    const std::string& text, ErrorCode code = ErrorCode::kInvalidArgument) {
  spoil(message);
  const auto refusal = [&message] {
    if constexpr (std::is_constructible_v<ClientMessage, Message>) {
      const auto parsed = parse_client_message(serialize(ClientMessage(message)));
      return parsed ? ParseError{} : parsed.error();
    } else {
      const auto parsed = parse_server_message(serialize(ServerMessage(message)));
      return parsed ? ParseError{} : parsed.error();
    }
  }();
  EXPECT_EQ(refusal.error.code, code) << text << " | " << refusal.error.text;
  EXPECT_NE(refusal.error.text.find(text), std::string::npos) << refusal.error.text;
  if constexpr (requires { message.request_id; }) {
    EXPECT_EQ(refusal.request_id, message.request_id) << text;
  }
}

TEST(Hello, RejectsValuesOutOfRange) {
  const auto refuse = [](auto spoil, const char* text, ErrorCode code) {
    expect_refused<Hello>(Hello{}, spoil, text, code);
  };
  refuse([](Hello& h) { h.min_version = 3, h.max_version = 2; }, "Hello.max_version",
         ErrorCode::kInvalidArgument);
  refuse([](Hello& h) { h.token.assign(4097, 't'); }, "Hello.token", ErrorCode::kLimitExceeded);
  refuse([](Hello& h) { h.agent.assign(256, 'a'); }, "Hello.agent", ErrorCode::kLimitExceeded);
}

TEST(OpenStream, RejectsValuesOutOfRange) {
  const auto refuse = [](auto spoil, const char* text,
                         ErrorCode code = ErrorCode::kInvalidArgument) {
    expect_refused<OpenStream>({.request_id = 9, .dataset = "fuel", .request = {}}, spoil, text,
                               code);
  };
  refuse([](OpenStream& o) { o.request_id = 0; }, "OpenStream.request_id");
  refuse([](OpenStream& o) { o.dataset = ""; }, "OpenStream.dataset");
  refuse([](OpenStream& o) { o.dataset = "../passwd"; }, "OpenStream.dataset");
  refuse([](OpenStream& o) { o.dataset = "."; }, "OpenStream.dataset");
  refuse([](OpenStream& o) { o.dataset = ".."; }, "OpenStream.dataset");
  refuse([](OpenStream& o) { o.dataset = "a\nb"; }, "OpenStream.dataset");
  refuse([](OpenStream& o) { o.dataset.assign(256, 'd'); }, "OpenStream.dataset");
  refuse([](OpenStream& o) { o.request.isovalue = kNaN; }, "isovalue");
  refuse([](OpenStream& o) { o.request.isovalue = kInfinity; }, "isovalue");
  refuse([](OpenStream& o) { o.request.error = -1; }, "threshold");
  refuse([](OpenStream& o) { o.request.error = kNaN; }, "threshold");
  refuse([](OpenStream& o) { o.request.error = kInfinity; }, "threshold");
  refuse([](OpenStream& o) { o.request.topology_tolerance = -0.5; }, "topology tolerance");
  refuse([](OpenStream& o) { o.request.topology_tolerance = kNaN; }, "topology tolerance");
  refuse([](OpenStream& o) { o.request.lattice_resolution = 9; }, "lattice resolution");
  refuse([](OpenStream& o) { o.request.lattice_resolution = -1; }, "lattice resolution");
  refuse([](OpenStream& o) { o.request.unit = static_cast<ErrorUnit>(2); }, "threshold.unit");
  refuse([](OpenStream& o) { o.request.error_measure = static_cast<ErrorMeasure>(2); }, "bound");
  refuse([](OpenStream& o) { o.request.topology_rule = static_cast<TopologyRule>(-3); },
         "topology_rule");
  refuse([](OpenStream& o) { o.request.normal_bits = 7; }, "normals have 7 bits");
  refuse([](OpenStream& o) { o.request.normal_bits = 11; }, "normals have 11 bits");
  refuse([](OpenStream& o) { o.request.normal_bits = -1; }, "normals have");
  const auto refuse_cell = [&](const OctreeNode& cell, const char* text) {
    refuse([&](OpenStream& o) { o.request.cell = cell; }, text);
  };
  refuse_cell({.cube = {0, 0, 0, 0}}, "exponent is 0");
  refuse_cell({.cube = {21, 0, 0, 0}}, "exponent is 21");
  refuse_cell({.cube = {5, 0, 0, 0}, .finest_spacing = 3}, "finest spacing of the cell is 3");
  refuse_cell({.cube = {5, 0, 0, 0}, .finest_spacing = 32}, "half the cell's side, 16");
  refuse(
      [](OpenStream& o) {
        o.request.cell = OctreeNode{.cube = {5, 0, 0, 0}};
        o.request.max_triangles = 5;
      },
      "cell has a budget");
  refuse([](OpenStream& o) { o.steps = static_cast<StepPolicy>(3); }, "OpenStream.steps");
  const auto scalars = [&](auto spoil, const char* text) {
    refuse(
        [=](OpenStream& o) {
          o.scalars = ScalarRequest{.dataset = "heat", .in_any_world = true};
          spoil(*o.scalars);
        },
        text);
  };
  scalars([](ScalarRequest& s) { s.dataset = ""; }, "ScalarRequest.dataset");
  scalars([](ScalarRequest& s) { s.bits = 12; }, "8 or 16");
  scalars([](ScalarRequest& s) { s.limits = {1, 1}; }, "range of scalars");
  scalars([](ScalarRequest& s) { s.limits = {0, kInfinity}; }, "range of scalars");
  refuse([](OpenStream& o) { o.cached_tile_digests.resize(kMaxHeldDigests + 1); },
         "OpenStream.cached_tile_digests", ErrorCode::kLimitExceeded);
}

TEST(OpenStream, AcceptsSeveralDatasetsOnlyForOnePreviewEach) {
  const OpenStream good{.request_id = 9,
                        .dataset = "cells.label1",
                        .request = {},
                        .steps = StepPolicy::kPreviewsOnly,
                        .resumed_previews = {{.finest_spacing = 4}},
                        .further_datasets = {"cells.label2", "cells.label3"}};
  const auto parsed = parse_client_message(serialize(good));
  ASSERT_TRUE(parsed) << parsed.error().error.text;
  EXPECT_EQ(std::get<OpenStream>(*parsed).further_datasets, good.further_datasets);
  const auto refuse = [&](auto spoil, ErrorCode code = ErrorCode::kInvalidArgument) {
    expect_refused<OpenStream>(good, spoil, "OpenStream.further_datasets", code);
  };
  refuse([](OpenStream& o) { o.steps = StepPolicy::kProgressive; });
  refuse([](OpenStream& o) { o.resumed_previews = {}; });
  refuse([](OpenStream& o) { o.resumed_previews.push_back({.finest_spacing = 2}); });
  refuse([](OpenStream& o) { o.cached_tile_digests = {{1, 2}}; });
  refuse([](OpenStream& o) { o.scalars = ScalarRequest{.dataset = "heat"}; });
  refuse([](OpenStream& o) { o.request.cell = OctreeNode{.cube = {5, 0, 0, 0}}; });
  refuse([](OpenStream& o) { o.further_datasets[1] = "../passwd"; });
  refuse([](OpenStream& o) { o.further_datasets.assign(kMaxFurtherDatasets + 1, "a"); },
         ErrorCode::kLimitExceeded);
}

// A request with one threshold map part of each kind.
IsosurfaceRequest request_with_a_map() {
  IsosurfaceRequest request;
  request.thresholds.regions = {
      {.shape = BoxShape{.low = {0, 0, 0}, .high = {1, 1, 1}}, .threshold = 1},
      {.shape = BallShape{.center = {0, 0, 0}, .radius = 1}, .threshold = 1},
      {.shape = HalfSpaceShape{.normal = {0, 0, 1}, .offset = 1}, .threshold = 1}};
  request.thresholds.grid = std::make_shared<const ThresholdGrid>(
      ThresholdGrid{.dims = {2, 1, 1}, .index_to_world = {}, .thresholds = {1, std::nanf("")}});
  request.thresholds.view = ThresholdView{.eye = {0, 0, 0},
                                          .field_of_view = 45,
                                          .height_pixels = 600,
                                          .tolerance_pixels = 1,
                                          .frustum = Frustum{.look_at = {1, 0, 0}}};
  return request;
}

// Expects refusal both in an OpenStream and in an Estimate.
void expect_map_refused(const std::function<void(LocalThresholds&)>& spoil, const char* text,
                        ErrorCode code = ErrorCode::kInvalidArgument) {
  expect_refused<OpenStream>(
      {.request_id = 9, .dataset = "fuel", .request = request_with_a_map()},
      [&](OpenStream& o) { spoil(o.request.thresholds); }, text, code);
  expect_refused<Estimate>(
      {.request_id = 9, .dataset = "fuel", .request = request_with_a_map()},
      [&](Estimate& e) { spoil(e.request.thresholds); }, text, code);
}

TEST(ThresholdMaps, AcceptEveryKindOfPart) {
  const OpenStream open{.request_id = 9, .dataset = "fuel", .request = request_with_a_map()};
  const auto parsed = parse_client_message(serialize(ClientMessage(open)));
  ASSERT_TRUE(parsed) << parsed.error().error.text;
  EXPECT_TRUE(samples::same(*parsed, ClientMessage(open)));
}

TEST(ThresholdMaps, RejectRegionsOutOfRangeByIndexAndField) {
  using Map = LocalThresholds;
  for (const double wrong : {-1.0, kNaN, kInfinity}) {
    expect_map_refused([=](Map& m) { m.regions[2].threshold = wrong; }, "regions[2].threshold");
    expect_map_refused([=](Map& m) { m.error_floor = wrong; }, "at_least");
    expect_map_refused([=](Map& m) { std::get<BallShape>(m.regions[1].shape).radius = wrong; },
                       "regions[1].ball.radius");
  }
  for (const double wrong : {1e101, -kInfinity, kNaN}) {
    expect_map_refused([=](Map& m) { std::get<BoxShape>(m.regions[0].shape).low[2] = wrong; },
                       "regions[0].box.low");
    expect_map_refused([=](Map& m) { std::get<BoxShape>(m.regions[0].shape).high[0] = wrong; },
                       "regions[0].box.high");
    expect_map_refused([=](Map& m) { std::get<BallShape>(m.regions[1].shape).center[1] = wrong; },
                       "regions[1].ball.center");
    expect_map_refused(
        [=](Map& m) { std::get<HalfSpaceShape>(m.regions[2].shape).normal[0] = wrong; },
        "regions[2].half_space.normal");
    expect_map_refused([=](Map& m) { std::get<HalfSpaceShape>(m.regions[2].shape).offset = wrong; },
                       "regions[2].half_space.offset");
  }
  expect_map_refused([](Map& m) { std::get<BoxShape>(m.regions[0].shape).low[1] = 2; },
                     "regions[0].box");
  expect_map_refused([](Map& m) { std::get<HalfSpaceShape>(m.regions[2].shape).normal = {}; },
                     "regions[2].half_space.normal");
  expect_map_refused([](Map& m) { m.coordinates = static_cast<CoordinateSystem>(2); },
                     "threshold.region_coordinates");
  expect_map_refused([](Map& m) { m.combination = static_cast<Combination>(-2); },
                     "threshold.combine");
}

TEST(ThresholdMaps, RejectGridsOutOfRange) {
  const auto refuse = [](const std::function<void(ThresholdGrid&)>& spoil, const char* text,
                         ErrorCode code = ErrorCode::kInvalidArgument) {
    expect_map_refused(
        [&](LocalThresholds& m) {
          ThresholdGrid grid = *m.grid;
          spoil(grid);
          m.grid = std::make_shared<const ThresholdGrid>(grid);
        },
        text, code);
  };
  for (const float wrong : {-1.0F, std::numeric_limits<float>::infinity()}) {
    refuse([=](ThresholdGrid& g) { g.thresholds[1] = wrong; }, "grid.thresholds[1]");
  }
  refuse([](ThresholdGrid& g) { g.thresholds.push_back(1); }, "grid.thresholds");
  refuse([](ThresholdGrid& g) { g.dims[2] = 0; }, "ThresholdGrid.dims");
  refuse([](ThresholdGrid& g) { g.dims[2] = -1; }, "ThresholdGrid.dims");
  refuse(
      [](ThresholdGrid& g) {
        g.dims = {131072, 131072, 131072};
      },
      "grid", ErrorCode::kLimitExceeded);
  refuse([](ThresholdGrid& g) { g.thresholds.resize(kMaxGridThresholds + 1); }, "thresholds",
         ErrorCode::kLimitExceeded);
  refuse([](ThresholdGrid& g) { g.index_to_world.translation[0] = kNaN; }, "grid.index_to_world");
  refuse([](ThresholdGrid& g) { g.index_to_world.columns[1] = {2, 0, 0}; }, "grid.index_to_world");
}

TEST(ThresholdMaps, RejectViewsOutOfRange) {
  const auto refuse = [](const std::function<void(ThresholdView&)>& spoil, const char* text) {
    expect_map_refused([&](LocalThresholds& m) { spoil(*m.view); }, text);
  };
  for (const double wrong : {0.0, -1.0, 180.0, kNaN, kInfinity}) {
    refuse([=](ThresholdView& v) { v.field_of_view = wrong; }, "view.field_of_view");
  }
  for (const double wrong : {0.0, -1.0, kNaN, kInfinity}) {
    refuse([=](ThresholdView& v) { v.height_pixels = wrong; }, "view.height_pixels");
  }
  for (const double wrong : {-1.0, kNaN, kInfinity}) {
    refuse([=](ThresholdView& v) { v.tolerance_pixels = wrong; }, "view.tolerance_pixels");
    refuse([=](ThresholdView& v) { v.frustum->aspect = wrong; }, "view.frustum.aspect");
    refuse([=](ThresholdView& v) { v.frustum->outside = wrong; }, "view.frustum.outside");
  }
  refuse([](ThresholdView& v) { v.eye[2] = kNaN; }, "view.eye");
  refuse([](ThresholdView& v) { v.frustum->look_at[2] = kInfinity; }, "view.frustum.look_at");
  refuse([](ThresholdView& v) { v.frustum->look_at = v.eye; }, "view.frustum.look_at");
  refuse([](ThresholdView& v) { v.frustum->up = {0, 0, 0}; }, "view.frustum.up");
  refuse([](ThresholdView& v) { v.frustum->up = {-3, 0, 0}; }, "view.frustum.up");
}

TEST(ThresholdMaps, RejectMoreThanTenThousandRegions) {
  for (const std::size_t count : {kMaxThresholdRegions + 1, 3 * kMaxThresholdRegions}) {
    expect_map_refused([=](LocalThresholds& m) { m.regions.resize(count); }, "regions",
                       ErrorCode::kLimitExceeded);
  }
}

// An OpenStream with request id 9 whose threshold map has the bytes `map`.
std::string open_stream_with_map(const std::string& map) {
  return field(3, "\x08\x09" + field(2, "fuel") + field(3, field(2, map)));
}

TEST(ThresholdMaps, RejectIncompletePieces) {
  const auto refusal = [](const std::string& map) {
    const auto parsed = parse_client_message(open_stream_with_map(map));
    if (parsed) return std::string("accepted");
    EXPECT_EQ(parsed.error().error.code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(parsed.error().request_id, 9U);
    return parsed.error().error.text;
  };
  const std::string one(8, '\0');  // A double.
  EXPECT_NE(refusal(field(4, "")).find("shape"), std::string::npos);
  EXPECT_NE(refusal(field(4, field(9, "cone"))).find("shape"), std::string::npos);
  EXPECT_NE(refusal(field(4, field(2, ""))).find("box.low has 0 numbers"), std::string::npos);
  EXPECT_NE(refusal(field(4, field(3, field(1, one)))).find("ball.center has 1 numbers"),
            std::string::npos);
  EXPECT_NE(refusal(field(4, field(4, field(1, one + one)))).find("normal has 2 numbers"),
            std::string::npos);
  EXPECT_NE(refusal(field(5, "")).find("ThresholdGrid.dims"), std::string::npos);
  EXPECT_NE(refusal(field(5, field(1, "\1\1\1"))).find("index_to_world"), std::string::npos);
  EXPECT_NE(refusal(field(6, "")).find("ThresholdView.eye"), std::string::npos);
  EXPECT_NE(refusal(field(6, field(1, one + one + one) + field(5, ""))).find("Frustum.look_at"),
            std::string::npos);
}

TEST(ThresholdMaps, GiveAbsentFieldsTheirDocumentedDefaults) {
  const std::string zero(8, '\0');
  std::string one_point(8, '\0');
  one_point[6] = '\xF0';
  one_point[7] = '\x3F';  // 1.0
  const std::string place = zero + zero + zero;
  const std::string number = "\x11" + one_point + "\x19" + one_point;  // Fields 2 and 3.
  const auto parsed = parse_client_message(open_stream_with_map(
      field(6, field(1, place) + number + field(5, field(1, one_point + zero + zero)))));
  ASSERT_TRUE(parsed) << parsed.error().error.text;
  const ThresholdView& view = *std::get<OpenStream>(*parsed).request.thresholds.view;
  EXPECT_EQ(view.frustum, (Frustum{.look_at = {1, 0, 0}, .up = {0, 0, 1}, .aspect = 1}));
  EXPECT_EQ(view.tolerance_pixels, 0);
  const IsosurfaceRequest& request = std::get<OpenStream>(*parsed).request;
  EXPECT_EQ(request.error, kDefaultError);
  EXPECT_TRUE(request.simplify);
  EXPECT_EQ(request, (IsosurfaceRequest{.error = SurfaceQuery().request.error,
                                        .thresholds = request.thresholds,
                                        .simplify = SurfaceQuery().request.simplify}))
      << "as over HTTP and in commands";
}

TEST(OpenStream, RejectsAPartialDigest) {
  const std::string bytes = "\x08\x09" + field(2, "fuel") + field(5, std::string(17, 'h'));
  const auto parsed = parse_client_message(field(3, bytes));
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().error.code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(parsed.error().request_id, 9U);
}

TEST(StepBegin, RejectsValuesOutOfRange) {
  const auto refuse = [](auto spoil, const char* text) {
    StepBegin begin{.request_id = 9, .request = {}};
    begin.tetrahedra = begin.active_tetrahedra = 5;
    begin.tiles = {
        {.cube = {18, 3, 3, 3}, .digest = {}, .triangles = 1, .vertices = 3, .bytes = 9}};
    ASSERT_TRUE(parse_server_message(serialize(ServerMessage(begin))));
    expect_refused<StepBegin>(begin, spoil, text);
  };
  refuse([](StepBegin& b) { b.request_id = 0; }, "StepBegin.request_id");
  refuse([](StepBegin& b) { b.request.isovalue = kNaN; }, "isovalue");
  refuse([](StepBegin& b) { b.error_bound_world = -1; }, "error_bound_world");
  refuse([](StepBegin& b) { b.error_bound_world = kInfinity; }, "error_bound_world");
  refuse([](StepBegin& b) { b.finest_spacing = 3; }, "finest_spacing");
  refuse([](StepBegin& b) { b.finest_spacing = 1 << 20; }, "finest_spacing");
  refuse([](StepBegin& b) { b.finest_spacing = -1; }, "finest_spacing");
  refuse([](StepBegin& b) { b.active_tetrahedra = 6; }, "active_tetrahedra");
  refuse([](StepBegin& b) { b.tiles[0].simplification_bound = -1; }, "simplification_bound");
  refuse([](StepBegin& b) { b.tiles[0].simplification_bound = kNaN; }, "simplification_bound");
  refuse([](StepBegin& b) { b.tiles[0].cube.exponent = 21; }, "cube_exponent");
  refuse([](StepBegin& b) { b.tiles[0].cube.exponent = -1; }, "cube_exponent");
  refuse([](StepBegin& b) { b.tiles[0].cube.x = 4; }, "cube_x");
  refuse([](StepBegin& b) { b.tiles[0].cube.y = -1; }, "cube_y");
  refuse([](StepBegin& b) { b.tiles[0].cube.z = 1 << 30; }, "cube_z");
  refuse([](StepBegin& b) { b.tiles[0].triangles = 0; }, "triangles");
  refuse([](StepBegin& b) { b.tiles[0].triangles = kMaxTileTriangles + 1; }, "triangles");
  refuse([](StepBegin& b) { b.tiles[0].vertices = 2; }, "vertices");
  refuse([](StepBegin& b) { b.tiles[0].vertices = 4; }, "vertices");
  refuse([](StepBegin& b) { b.tiles[0].bytes = 0; }, "bytes");
  refuse([](StepBegin& b) { b.tiles[0].bytes = kMaxServerFrameBytes + 1; }, "bytes");
}

TEST(DatasetList, RejectsValuesOutOfRange) {
  const auto refuse = [](std::function<void(DatasetInfo&)> spoil, const char* text,
                         ErrorCode code = ErrorCode::kInvalidArgument) {
    std::mt19937_64 random(5);
    const DatasetList list{.request_id = 9, .datasets = {samples::dataset_info(random)}};
    ASSERT_TRUE(parse_server_message(serialize(ServerMessage(list))));
    expect_refused<DatasetList>(
        list, [&spoil](DatasetList& l) { spoil(l.datasets[0]); }, text, code);
  };
  refuse([](DatasetInfo& d) { d.name = ""; }, "DatasetInfo.name");
  refuse([](DatasetInfo& d) { d.dims[1] = 0; }, "DatasetInfo.dims");
  refuse([](DatasetInfo& d) { d.dims[2] = -4; }, "DatasetInfo.dims");
  refuse([](DatasetInfo& d) { d.dims[0] = (1 << 19) + 2; }, "DatasetInfo.dims");
  refuse([](DatasetInfo& d) { d.type = static_cast<SampleType>(5); }, "DatasetInfo.type");
  refuse([](DatasetInfo& d) { d.type = static_cast<SampleType>(-1); }, "DatasetInfo.type");
  refuse([](DatasetInfo& d) { d.spacing[2] = 0; }, "DatasetInfo.spacing");
  refuse([](DatasetInfo& d) { d.spacing[0] = kInfinity; }, "DatasetInfo.spacing");
  refuse([](DatasetInfo& d) { d.index_to_world.columns[1][2] = kNaN; }, "index_to_world");
  refuse([](DatasetInfo& d) { d.index_to_world.translation[0] = kInfinity; }, "index_to_world");
  refuse([](DatasetInfo& d) { d.min = kNaN; }, "DatasetInfo.min");
  refuse([](DatasetInfo& d) { d.max = d.min - 1; }, "DatasetInfo.max");
  refuse([](DatasetInfo& d) { d.void_samples = 1ULL << 60; }, "void_samples");
  refuse([](DatasetInfo& d) { d.outside = kNaN; }, "DatasetInfo.outside");
  refuse([](DatasetInfo& d) { d.margin = -1; }, "DatasetInfo.margin");
  refuse([](DatasetInfo& d) { d.grid_exponent = 0; }, "grid_exponent");
  refuse([](DatasetInfo& d) { d.grid_exponent = 20; }, "grid_exponent");
  refuse(
      [](DatasetInfo& d) {
        d.dims = {100, 1, 1}, d.margin = 15, d.grid_exponent = 7;
      },
      "grid_exponent");
  refuse([](DatasetInfo& d) { d.histogram.low = kNaN; }, "histogram.low");
  refuse([](DatasetInfo& d) { d.histogram.high = d.histogram.low - 1; }, "histogram.high");
  refuse([](DatasetInfo& d) { d.histogram.counts.resize(65537); }, "histogram.counts",
         ErrorCode::kLimitExceeded);
  refuse([](DatasetInfo& d) { d.suggested_isovalues = {kNaN}; }, "suggested_isovalues");
  refuse([](DatasetInfo& d) { d.suggested_isovalues.resize(257); }, "suggested_isovalues",
         ErrorCode::kLimitExceeded);
  const auto refuse_window = [&](const DisplayWindow& window) {
    refuse([&](DatasetInfo& d) { d.display_window = window; }, "DatasetInfo.display_window");
  };
  refuse_window({5, 5});
  refuse_window({5, 4});
  refuse_window({kNaN, 4});
  refuse_window({0, kInfinity});
  const auto refuse_member = [&](std::function<void(SeriesMember&)> spoil, const char* field) {
    refuse(
        [&](DatasetInfo& d) {
          d.member = {.series = "f", .label = Label{}};
          spoil(*d.member);
        },
        field);
  };
  refuse_member([](SeriesMember& m) { m.series = ""; }, "DatasetInfo.member.series");
  refuse_member([](SeriesMember& m) { m.series = "a/b"; }, "DatasetInfo.member.series");
  refuse_member([](SeriesMember& m) { m.field = "a\nb"; }, "DatasetInfo.member.field");
  refuse_member([](SeriesMember& m) { m.field.assign(256, 'x'); }, "DatasetInfo.member.field");
  refuse_member([](SeriesMember& m) { m.time = kInfinity; }, "DatasetInfo.member.time");
  refuse_member([](SeriesMember& m) { m.time_unit.assign(65, 's'); },
                "DatasetInfo.member.time_unit");
  refuse_member([](SeriesMember& m) { m.color = 0x1000000; }, "DatasetInfo.member.color");
  const auto refuse_extent = [&](const LabelExtent& extent, const char* field) {
    refuse(
        [&](DatasetInfo& d) {
          d.dims = {4, 4, 4}, d.margin = 0, d.grid_exponent = 2;
          d.void_samples = 0;
          d.member = SeriesMember{.series = "f", .label = Label{}};
          d.label_extent = extent;
        },
        field);
  };
  refuse_extent({.samples = 65}, "DatasetInfo.member.label.samples");
  refuse_extent({.samples = 1, .place = LabelExtent::Place{.greatest = {0, 4, 0}}},
                "DatasetInfo.member.label.box");
  refuse_extent({.samples = 1, .place = LabelExtent::Place{.centroid = {0, kNaN, 0}}},
                "DatasetInfo.member.label.centroid");
  refuse_member([](SeriesMember& m) { m.label->value = 0.5; }, "DatasetInfo.member.label.value");
  refuse_member([](SeriesMember& m) { m.label->value = kNaN; }, "DatasetInfo.member.label.value");
  refuse_member([](SeriesMember& m) { m.label->name = "\x7F"; }, "DatasetInfo.member.label.name");
  refuse_member([](SeriesMember& m) { m.label->color = 0x1000000; },
                "DatasetInfo.member.label.color");
}

TEST(ServerMessages, RejectValuesOutOfRange) {
  const auto payload = std::make_shared<const std::string>("x");
  expect_refused<Welcome>(
      {}, [](Welcome& w) { w.version = 0; }, "Welcome.version");
  expect_refused<Welcome>(
      {}, [](Welcome& w) { w.codecs = {PayloadCodec::kSampleShell}; }, "Welcome.codecs");
  expect_refused<Tile>(
      {9, 0, 0, payload}, [](Tile& t) { t.request_id = 0; }, "Tile.request_id");
  expect_refused<Tile>(
      {9, 0, 0, payload}, [](Tile& t) { t.payload = nullptr; }, "Tile.payload");
  expect_refused<StepEnd>(
      {.request_id = 9}, [](StepEnd& e) { e.seconds = -1; }, "seconds");
  expect_refused<StepEnd>(
      {.request_id = 9}, [](StepEnd& e) { e.seconds = kNaN; }, "seconds");
  expect_refused<StreamEnd>(
      {.request_id = 9}, [](StreamEnd& e) { e.request_id = 0; }, "StreamEnd.request_id");
  for (const int outcome : {0, 4}) {
    expect_refused<StreamEnd>(
        {.request_id = 9},
        [outcome](StreamEnd& e) { e.outcome = static_cast<StreamOutcome>(outcome); }, "outcome");
  }
}

TEST(Slice, RejectsValuesOutOfRange) {
  const auto refuse = [](auto spoil, const char* text,
                         ErrorCode code = ErrorCode::kInvalidArgument) {
    expect_refused<Slice>({.request_id = 9, .dataset = "fuel"}, spoil, text, code);
  };
  refuse([](Slice& s) { s.dataset = "a/b"; }, "Slice.dataset");
  refuse([](Slice& s) { s.slice.origin[1] = kNaN; }, "Slice.origin");
  refuse([](Slice& s) { s.slice.right[2] = 1e101; }, "Slice.right");
  refuse([](Slice& s) { s.slice.down[0] = -kInfinity; }, "Slice.down");
  refuse([](Slice& s) { s.slice.layers = 2, s.slice.inward[0] = kNaN; }, "Slice.inward");
  refuse([](Slice& s) { s.slice.width = 0; }, "Slice.width");
  refuse([](Slice& s) { s.slice.width = s.slice.height = 0xFFFFFFFF; }, "pixels",
         ErrorCode::kLimitExceeded);
  refuse([](Slice& s) { s.slice.layers = kMaxSlicePixels + 1; }, "pixels",
         ErrorCode::kLimitExceeded);
  refuse([](Slice& s) { s.slice.width = s.slice.layers = 0x80000000, s.slice.height = 4; },
         "pixels", ErrorCode::kLimitExceeded);
  refuse([](Slice& s) { s.slice.width = kMaxSlicePixels, s.slice.height = 2; }, "pixels",
         ErrorCode::kLimitExceeded);
  refuse([](Slice& s) { s.slice.interpolation = static_cast<Interpolation>(2); },
         "Slice.interpolation");
  refuse([](Slice& s) { s.slice.detail = static_cast<SliceDetail>(3); }, "Slice.detail");
  refuse([](Slice& s) { s.slice.coordinates = static_cast<CoordinateSystem>(2); },
         "Slice.coordinates");
}

TEST(Probe, RejectsValuesOutOfRange) {
  const auto refuse = [](auto spoil, const char* text,
                         ErrorCode code = ErrorCode::kInvalidArgument) {
    expect_refused<Probe>({.request_id = 9, .dataset = "fuel", .probe = {.places = {{1, 2, 3}}}},
                          spoil, text, code);
  };
  refuse([](Probe& p) { p.dataset = ""; }, "Probe.dataset");
  refuse([](Probe& p) { p.probe.places.clear(); }, "Probe.places");
  refuse([](Probe& p) { p.probe.places[0][2] = kNaN; }, "Place 0");
  refuse(
      [](Probe& p) {
        p.probe.places.resize(1025, {0, 0, 0});
      },
      "1025 places", ErrorCode::kLimitExceeded);
}

TEST(SliceReply, RejectsBytesThatDoNotMatchItsPixels) {
  const auto bytes = [](std::size_t count) {
    return std::make_shared<const std::string>(count, '\0');
  };
  const SliceReply good{.request_id = 9, .width = 2, .height = 3, .values = bytes(24)};
  expect_refused<SliceReply>(
      good, [&](SliceReply& r) { r.values = bytes(23); }, "values");
  expect_refused<SliceReply>(
      good, [](SliceReply& r) { r.layers = 2; }, "values");
  expect_refused<SliceReply>(
      good, [](SliceReply& r) { r.layers = 1U << 31; }, "layers");
  expect_refused<SliceReply>(
      good, [](SliceReply& r) { r.packed_type = static_cast<SampleType>(5); }, "packed_type");
  expect_refused<SliceReply>(
      good, [](SliceReply& r) { r.width = 0; }, "width");
  expect_refused<SliceReply>(
      good, [](SliceReply& r) { r.width = r.height = 1U << 31; }, "width");
  expect_refused<SliceReply>(
      good, [](SliceReply& r) { r.sample_spacing = 0; }, "sample_spacing");
}

TEST(ProbeReply, RejectsNonfiniteNumbers) {
  const ProbedPlace place{.world = {1, 2, 3}, .index = {4, 5, 6}, .value = 7, .gradient = Vec3{}};
  const auto refuse = [&](auto spoil, const char* text) {
    expect_refused<ProbeReply>(
        {.request_id = 9, .places = {place, place}}, [&](ProbeReply& r) { spoil(r.places[1]); },
        text);
  };
  for (const double wrong : {kNaN, -kInfinity}) {
    refuse([=](ProbedPlace& p) { p.world[0] = wrong; }, "ProbedPlace.world");
    refuse([=](ProbedPlace& p) { p.index[2] = wrong; }, "ProbedPlace.index");
    refuse([=](ProbedPlace& p) { p.value = wrong; }, "ProbedPlace.value");
    refuse([=](ProbedPlace& p) { (*p.gradient)[1] = wrong; }, "ProbedPlace.gradient");
  }
}

TEST(EstimateReply, RejectsValuesOutOfRange) {
  for (const double wrong : {-1.0, kNaN, kInfinity}) {
    expect_refused<EstimateReply>(
        {.request_id = 9}, [=](EstimateReply& e) { e.error_bound_world = wrong; },
        "error_bound_world");
  }
}

// ---- hostile sizes

// A length-delimited field with a content of any length.
std::string long_field(int number, const std::string& content) {
  std::string bytes(1, static_cast<char>(number << 3 | 2));
  for (std::size_t length = content.size();; length >>= 7) {
    bytes.push_back(static_cast<char>((length & 0x7F) | (length >= 0x80 ? 0x80U : 0U)));
    if (length < 0x80) return bytes + content;
  }
}

// A field `outer` that contains `entries` empty entries of field `inner`, two bytes each.
std::string many_entries(int outer, int inner, std::size_t entries) {
  std::string content;
  for (std::size_t i = 0; i < entries; ++i) content += field(inner, "");
  return long_field(outer, content);
}

TEST(ServerMessages, RejectMillionsOfEmptyEntriesBeforeParsing) {
  const auto code = [](const std::string& bytes) {
    const auto parsed = parse_server_message(bytes);
    return parsed ? ErrorCode::kUnknown : parsed.error().error.code;
  };
  EXPECT_EQ(code(many_entries(3, 10, 4000000)), ErrorCode::kLimitExceeded) << "tiles";
  EXPECT_EQ(code(many_entries(11, 2, 1025)), ErrorCode::kLimitExceeded) << "places";
  EXPECT_EQ(code(many_entries(2, 2, 4097)), ErrorCode::kLimitExceeded) << "datasets";
  EXPECT_EQ(code(many_entries(2, 2, 4096)), ErrorCode::kInvalidArgument) << "nameless datasets";
  // In many portions, which protobuf merges.
  std::string portions;
  for (int i = 0; i < 100; ++i) portions += many_entries(3, 10, 3000);
  EXPECT_EQ(code(portions), ErrorCode::kLimitExceeded) << "tiles in portions";
}

TEST(ThresholdMaps, RejectMillionsOfEmptyRegionsBeforeParsing) {
  const std::string map = many_entries(2, 4, 1000000);  // A field of the request.
  const std::string id = "\x08\x09";
  for (const int kind : {3, 6}) {  // OpenStream and Estimate.
    const auto parsed = parse_client_message(long_field(kind, id + long_field(3, map)));
    ASSERT_FALSE(parsed);
    EXPECT_EQ(parsed.error().error.code, ErrorCode::kLimitExceeded);
    EXPECT_EQ(parsed.error().request_id, 9U);
  }
  // In many portions, which protobuf merges.
  std::string portions;
  for (int i = 0; i < 40; ++i) portions += long_field(3, many_entries(2, 4, 300));
  const auto parsed = parse_client_message(long_field(3, portions + id));
  ASSERT_FALSE(parsed);
  EXPECT_EQ(parsed.error().error.code, ErrorCode::kLimitExceeded);
  EXPECT_EQ(parsed.error().request_id, 9U);
  const auto begin = parse_server_message(long_field(3, id + long_field(4, map)));
  ASSERT_FALSE(begin);
  EXPECT_EQ(begin.error().error.code, ErrorCode::kLimitExceeded);
}

TEST(Messages, CarryTheClientsSpeed) {
  for (const double speed : {0.0, 1e6}) {
    const auto parsed = parse_client_message(
        serialize(OpenStream{.request_id = 1, .dataset = "head", .triangles_per_second = speed}));
    ASSERT_TRUE(parsed) << parsed.error().error.text;
    EXPECT_EQ(std::get<OpenStream>(*parsed).triangles_per_second, speed);
  }
  for (const double speed :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    expect_refused<OpenStream>(
        {.request_id = 1, .dataset = "head"},
        [&](OpenStream& open) { open.triangles_per_second = speed; }, "triangles_per_second");
  }
}

TEST(Messages, CarryWhatTheClientCanDraw) {
  for (const std::uint64_t triangles : {std::uint64_t{0}, ~std::uint64_t{0}}) {
    const auto parsed = parse_client_message(
        serialize(OpenStream{.request_id = 1, .dataset = "head", .drawable_triangles = triangles}));
    ASSERT_TRUE(parsed) << parsed.error().error.text;
    EXPECT_EQ(std::get<OpenStream>(*parsed).drawable_triangles, triangles);
  }
}

TEST(Messages, RejectImpossiblePreviews) {
  const auto expect_bad = [](std::vector<Preview> begun, const std::string& text,
                             ErrorCode code = ErrorCode::kInvalidArgument) {
    expect_refused<OpenStream>(
        {.request_id = 1, .dataset = "head"},
        [&](OpenStream& open) { open.resumed_previews = std::move(begun); }, text, code);
  };
  for (const std::int32_t spacing : {-1, 0, 1, 3, 1 << 20}) {
    expect_bad({{.finest_spacing = spacing}}, "power of two");
  }
  expect_bad({{.finest_spacing = 1, .shell = ShellStep{.levels_per_octave = 1}}},
             "OpenStream.resumed_previews.shell.levels_per_octave");
  expect_bad({{.finest_spacing = 4}, {.finest_spacing = 4}}, "less than the previous one");
  expect_bad({{.finest_spacing = 4}, {.finest_spacing = 8}}, "less than the previous one");
  expect_bad(std::vector<Preview>(21), "21 previews", ErrorCode::kLimitExceeded);
}

TEST(Messages, RejectFinalStepsThatDifferFromTheRequest) {
  expect_refused<StepBegin>(
      {.request_id = 1, .is_final = true}, [](StepBegin& begin) { begin.is_unsimplified = true; },
      "is_unsimplified");
}

TEST(StepBegin, RequiresAShellStepExactlyForShellCodecs) {
  const std::string id = "\x08\x01";
  const std::string shells = field(14, "\x08\x01");  // Exact shells.
  EXPECT_TRUE(parse_server_message(field(3, id)));
  EXPECT_TRUE(parse_server_message(field(3, id + "\x38\x02" + shells)));
  for (const std::string& bad :
       {std::string("\x38\x02"), "\x38\x01" + shells, shells, "\x38\x03" + shells}) {
    const auto parsed = parse_server_message(field(3, id + bad));
    ASSERT_FALSE(parsed);
    EXPECT_NE(parsed.error().error.text.find("StepBegin."), std::string::npos);
  }
}

TEST(StepBegin, RejectsImpossibleShells) {
  const StepBegin good{.request_id = 1, .shell = quantized_shells(2)};
  expect_refused<StepBegin>(
      good, [](StepBegin& begin) { begin.shell->levels_per_octave = 3; },
      "StepBegin.shell.levels_per_octave");
  expect_refused<StepBegin>(
      good, [](StepBegin& begin) { begin.shell->levels_per_octave = 0; },
      "StepBegin.shell.levels_per_octave");
  expect_refused<StepBegin>(
      good, [](StepBegin& begin) { begin.shell->values = static_cast<shell::ShellValues>(3); },
      "StepBegin.shell.values");
  expect_refused<StepBegin>(
      good, [](StepBegin& begin) { begin.is_unsimplified = true; }, "StepBegin.is_unsimplified");
}

TEST(RecordStartedStep, NamesAFinalStepOfShellsAsTheLastPreview) {
  OpenStream open = {.request_id = 1, .dataset = "head", .use = MeshUse::kDisplay};
  EXPECT_TRUE(
      record_started_step({.step = 0, .finest_spacing = 8, .shell = quantized_shells(1)}, open));
  EXPECT_TRUE(record_started_step(
      {.step = 1, .is_final = true, .finest_spacing = 1, .shell = quantized_shells(2)}, open));
  const std::vector<Preview> both = {{.finest_spacing = 8, .shell = quantized_shells(1)},
                                     {.finest_spacing = 1, .shell = quantized_shells(2)}};
  EXPECT_EQ(open.resumed_previews, both);
  EXPECT_EQ(open.steps, StepPolicy::kProgressive);
  const auto parsed = parse_client_message(serialize(open));
  ASSERT_TRUE(parsed) << parsed.error().error.text;
  EXPECT_EQ(std::get<OpenStream>(*parsed).resumed_previews, both);
}

TEST(RecordStartedStep, ResumesTheStreamAtItsPosition) {
  OpenStream open = {.request_id = 1, .dataset = "head", .request = {.simplify = true}};
  const auto begins = [&open](std::uint32_t step, std::int32_t finest, bool is_unsimplified) {
    EXPECT_TRUE(record_started_step({.step = step,
                                     .is_final = finest == 1,
                                     .finest_spacing = finest,
                                     .is_unsimplified = is_unsimplified},
                                    open));
  };
  begins(0, 8, true);
  begins(1, 4, false);
  begins(0, 8, true);  // Repeated.
  begins(1, 4, false);
  const std::vector<Preview> both = {{.finest_spacing = 8, .is_unsimplified = true},
                                     {.finest_spacing = 4}};
  EXPECT_EQ(open.resumed_previews, both);
  EXPECT_EQ(open.steps, StepPolicy::kProgressive);
  begins(2, 1, false);
  EXPECT_EQ(open.resumed_previews, both);
  EXPECT_EQ(open.steps, StepPolicy::kFinalOnly);
}

TEST(RecordStartedStep, RefusesAPreviewThatIsNotFiner) {
  OpenStream open = {.request_id = 1, .dataset = "head"};
  EXPECT_TRUE(record_started_step({.step = 0, .finest_spacing = 8}, open));
  for (const std::int32_t finest : {8, 16, 3, 1, 0, -4}) {
    EXPECT_FALSE(record_started_step({.step = 1, .finest_spacing = finest}, open)) << finest;
  }
  EXPECT_TRUE(parse_client_message(serialize(open)));
  EXPECT_TRUE(record_started_step({.step = 1, .finest_spacing = 4}, open));
}

TEST(RecordStartedStep, DistinguishesTheRequestsModelFromTheFinalStep) {
  OpenStream open = {.request_id = 1, .dataset = "head", .request = {.simplify = true}};
  EXPECT_TRUE(record_started_step({.step = 0, .finest_spacing = 8, .is_unsimplified = true}, open));
  EXPECT_TRUE(record_started_step({.step = 1, .finest_spacing = 1, .is_unsimplified = true}, open));
  const std::vector<Preview> both = {{.finest_spacing = 8, .is_unsimplified = true},
                                     {.finest_spacing = 1, .is_unsimplified = true}};
  EXPECT_EQ(open.resumed_previews, both);
  EXPECT_EQ(open.steps, StepPolicy::kProgressive);
  const auto parsed = parse_client_message(serialize(open));
  ASSERT_TRUE(parsed) << parsed.error().error.text;
  EXPECT_EQ(std::get<OpenStream>(*parsed).resumed_previews, both);
}

}  // namespace
}  // namespace multitetra
