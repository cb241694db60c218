// Random messages with every field within its range, and their comparison.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <variant>

#include "common/wire/messages.hpp"

namespace multitetra::samples {

using Random = std::mt19937_64;

inline std::uint64_t up_to(std::uint64_t last, Random& random) {
  return std::uniform_int_distribution<std::uint64_t>(0, last)(random);
}
inline std::int32_t int_in(std::int32_t low, std::int32_t high, Random& random) {
  return std::uniform_int_distribution<std::int32_t>(low, high)(random);
}
inline std::uint32_t u32(Random& random) { return static_cast<std::uint32_t>(random()); }
inline double number(Random& random) {
  return std::ldexp(std::uniform_real_distribution<double>(-1, 1)(random), int_in(-60, 60, random));
}
inline std::string text(std::size_t length, Random& random) {
  std::string result;
  for (std::size_t i = 0; i < length; ++i) {
    result.push_back(static_cast<char>(int_in('0', '~', random)));
  }
  return result;
}
template <typename Enum>
Enum one_of(int first, int last, Random& random) {
  return static_cast<Enum>(int_in(first, last, random));
}

inline Vec3 place(Random& random) { return {number(random), number(random), number(random)}; }

inline ThresholdRegion threshold_region(Random& random) {
  ThresholdRegion region{.threshold = std::abs(number(random))};
  switch (up_to(2, random)) {
    case 0: {
      BoxShape box{.low = place(random)};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.high[axis] = box.low[axis] + std::abs(number(random));
      }
      region.shape = box;
      break;
    }
    case 1:
      region.shape = BallShape{.center = place(random), .radius = std::abs(number(random))};
      break;
    default:
      region.shape =
          HalfSpaceShape{.normal = {number(random), number(random), 1}, .offset = number(random)};
  }
  return region;
}

inline ThresholdGrid threshold_grid(Random& random) {
  ThresholdGrid grid;
  for (std::int32_t& side : grid.dims) side = int_in(1, 5, random);
  for (Vec3& column : grid.index_to_world.columns) column = place(random);
  for (int i = 0; i < grid.dims[0] * grid.dims[1] * grid.dims[2]; ++i) {
    grid.thresholds.push_back(up_to(4, random) == 0 ? std::nanf("")
                                                    : std::abs(static_cast<float>(number(random))));
  }
  grid.index_to_world.translation = place(random);
  return grid;
}

inline ThresholdView threshold_view(Random& random) {
  ThresholdView view{.eye = place(random),
                     .field_of_view = static_cast<double>(int_in(1, 179, random)),
                     .height_pixels = std::abs(number(random)) + 1,
                     .tolerance_pixels = std::abs(number(random))};
  if (random() % 2 == 0) {
    view.frustum = Frustum{.look_at = place(random),
                           .up = place(random),
                           .aspect = std::abs(number(random)) + 1e-3,
                           .outside = std::abs(number(random))};
  }
  return view;
}

inline LocalThresholds local_thresholds(Random& random) {
  LocalThresholds thresholds{.coordinates = one_of<CoordinateSystem>(0, 1, random),
                             .combination = one_of<Combination>(0, 1, random)};
  for (std::uint64_t i = up_to(4, random); i > 0; --i) {
    thresholds.regions.push_back(threshold_region(random));
  }
  if (random() % 2 == 0) {
    thresholds.grid = std::make_shared<const ThresholdGrid>(threshold_grid(random));
  }
  if (random() % 2 == 0) thresholds.view = threshold_view(random);
  if (random() % 2 == 0) thresholds.error_floor = std::abs(number(random));
  return thresholds;
}

inline OctreeNode surface_cell(Random& random) {
  const std::int32_t exponent = int_in(1, kMaxLatticeBits, random);
  return {.cube = {exponent, int_in(0, 1 << 20, random), int_in(0, 1 << 20, random),
                   int_in(0, 1 << 20, random)},
          .finest_spacing = 1 << int_in(0, exponent - 1, random)};
}

inline IsosurfaceRequest request(Random& random) {
  IsosurfaceRequest request = {
      .isovalue = number(random),
      .error = std::abs(number(random)),
      .unit = one_of<ErrorUnit>(0, 1, random),
      .error_measure = one_of<ErrorMeasure>(0, 1, random),
      .topology_rule = one_of<TopologyRule>(0, 1, random),
      .topology_tolerance = std::abs(number(random)),
      .lattice_resolution = int_in(kMinLatticeResolution, kMaxLatticeResolution, random),
      .thresholds = random() % 2 == 0 ? local_thresholds(random) : LocalThresholds{},
      .max_triangles = random() % 2 == 0 ? random() : 0,
      .max_bytes = random() % 2 == 0 ? random() : 0,
      .simplify = random() % 2 == 0,
      .intersection_free = random() % 2 == 0,
      .normal_bits = random() % 2 == 0 ? int_in(kMinNormalBits, kMaxNormalBits, random) : 0};
  if (request.max_triangles == 0 && request.max_bytes == 0) request.cell = surface_cell(random);
  return request;
}

inline TileSummary tile_summary(Random& random) {
  TileSummary tile;
  tile.cube.exponent = int_in(0, kMaxLatticeBits, random);
  const std::int32_t last = (1 << (kMaxLatticeBits - tile.cube.exponent)) - 1;
  tile.cube.x = int_in(0, last, random);
  tile.cube.y = int_in(0, last, random);
  tile.cube.z = int_in(0, last, random);
  tile.digest = {random(), random()};
  tile.triangles = static_cast<std::uint32_t>(1 + up_to(kMaxTileTriangles - 1, random));
  tile.vertices = static_cast<std::uint32_t>(3 + up_to(3 * tile.triangles - 3, random));
  tile.bytes = static_cast<std::uint32_t>(1 + up_to(1000000, random));
  tile.simplification_bound = std::abs(number(random));
  return tile;
}

inline std::optional<SeriesMember> series_member(Random& random) {
  if (random() % 2 == 0) return std::nullopt;
  SeriesMember member{.series = "series " + std::to_string(up_to(9, random)),
                      .field = text(up_to(kMaxMemberTextBytes, random), random),
                      .time_unit = text(up_to(64, random), random)};
  if (random() % 2 == 0) member.time = number(random);
  if (random() % 2 == 0) member.color = static_cast<std::uint32_t>(up_to(0xFFFFFF, random));
  if (random() % 2 == 0) {
    member.label = {.value = static_cast<double>(int_in(-1000, 1000, random)),
                    .name = text(up_to(kMaxMemberTextBytes, random), random)};
    if (random() % 2 == 0)
      member.label->color = static_cast<std::uint32_t>(up_to(0xFFFFFF, random));
  }
  return member;
}

inline LabelExtent label_extent(const std::array<std::int32_t, 3>& dims, Random& random) {
  LabelExtent extent{.samples = 1 + up_to(static_cast<std::uint64_t>(dims[0]) - 1, random)};
  if (random() % 2 == 0) return extent;
  LabelExtent::Place& place = extent.place.emplace(LabelExtent::Place{});
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place.least[axis] = int_in(0, dims[axis] - 1, random);
    place.greatest[axis] = int_in(place.least[axis], dims[axis] - 1, random);
    place.centroid[axis] = (place.least[axis] + place.greatest[axis]) / 2.0;
  }
  return extent;
}

inline DatasetInfo dataset_info(Random& random) {
  DatasetInfo info;
  do {
    info.name = text(1 + up_to(254, random), random);
  } while (info.name.find('/') != std::string::npos);
  for (std::int32_t& samples : info.dims) samples = int_in(1, 2000, random);
  info.type = one_of<SampleType>(0, 4, random);
  for (double& length : info.spacing) length = std::abs(number(random)) + 1e-30;
  for (Vec3& column : info.index_to_world.columns) {
    for (double& entry : column) entry = number(random);
  }
  for (double& entry : info.index_to_world.translation) entry = number(random);
  info.min = number(random);
  info.max = info.min + std::abs(number(random));
  info.void_samples = up_to(static_cast<std::uint64_t>(info.dims[0]), random);
  if (random() % 2 == 0) info.outside = number(random);
  info.margin = int_in(0, 5, random);
  info.grid_exponent = grid_exponent_for(info.dims, info.margin) + int_in(0, 2, random);
  info.histogram.low = number(random);
  info.histogram.high = info.histogram.low + std::abs(number(random));
  for (std::uint64_t i = up_to(20, random); i > 0; --i) info.histogram.counts.push_back(random());
  for (std::uint64_t i = up_to(5, random); i > 0; --i) {
    info.suggested_isovalues.push_back(number(random));
  }
  info.content_id = random();
  info.meaning = {.space = one_of<WorldSpace>(0, 2, random),
                  .length_unit = text(up_to(64, random), random),
                  .value_unit = text(up_to(64, random), random),
                  .geometry = one_of<GeometryBasis>(0, 3, random),
                  .assumed = text(up_to(64, random), random),
                  .rounding = text(up_to(64, random), random)};
  info.member = series_member(random);
  if (info.member && info.member->label && random() % 2 == 0) {
    info.label_extent = label_extent(info.dims, random);
  }
  if (random() % 2 == 0) {
    const auto low = static_cast<double>(up_to(1000, random));
    info.display_window = {.low = low, .high = low + int_in(1, 1000, random)};
  }
  return info;
}

inline ShellStep shell_step(Random& random) {
  ShellStep step{.values = one_of<shell::ShellValues>(0, 2, random)};
  if (step.values == shell::ShellValues::kQuantized) {
    step.levels_per_octave = 1 << int_in(0, 3, random);
  }
  return step;
}

inline std::vector<PayloadCodec> codecs(Random& random) {
  if (random() % 2 == 0) return {PayloadCodec::kDracoLattice};
  return {PayloadCodec::kDracoLattice, PayloadCodec::kSampleShell};
}

// Makes it a request for one preview each of several datasets.
inline void request_several(OpenStream& open, Random& random) {
  open.steps = StepPolicy::kPreviewsOnly;
  open.cached_tile_digests.clear();
  open.scalars.reset();
  open.request.cell.reset();
  open.resumed_previews = {{.finest_spacing = 4}};
  for (std::uint64_t i = 1 + up_to(4, random); i > 0; --i) {
    open.further_datasets.push_back(dataset_info(random).name);
  }
}

// `kind` is the index of the alternative.
inline ClientMessage client_message(std::size_t kind, Random& random) {
  switch (kind) {
    case 0: {
      Hello hello;
      hello.min_version = static_cast<std::uint32_t>(1 + up_to(3, random));
      hello.max_version = hello.min_version + static_cast<std::uint32_t>(up_to(3, random));
      hello.codecs = codecs(random);
      hello.token = text(up_to(60, random), random);
      hello.agent = text(up_to(60, random), random);
      hello.on_behalf_of = text(up_to(60, random), random);
      hello.client_address = text(up_to(60, random), random);
      return hello;
    }
    case 1:
      return ListDatasets{.request_id = random(),
                          .in_pages = random() % 2 == 0,
                          .after = text(up_to(60, random), random)};
    case 2: {
      OpenStream open;
      open.request_id = random() | 1;
      open.dataset = dataset_info(random).name;
      open.request = request(random);
      open.steps = one_of<StepPolicy>(0, 2, random);
      for (std::uint64_t i = up_to(20, random); i > 0; --i) {
        open.cached_tile_digests.push_back({random(), random()});
      }
      for (int e = 19; e > 0; e -= int_in(1, 12, random)) {
        open.resumed_previews.push_back(
            {.finest_spacing = 1 << e, .is_unsimplified = (random() & 1) != 0});
        if (random() % 2 == 0) open.resumed_previews.back().shell = shell_step(random);
      }
      open.priority = one_of<Priority>(0, 1, random);
      open.use = one_of<MeshUse>(0, 1, random);
      if (random() % 2 == 0) {
        open.scalars =
            ScalarRequest{.dataset = dataset_info(random).name, .bits = random() % 2 == 0 ? 8 : 16};
        const double low = number(random);
        if (random() % 2 == 0) {
          open.scalars->limits = ScalarRequest::Limits{low, low + 1 + std::abs(low)};
        }
      }
      if (random() % 4 == 0) request_several(open, random);
      open.content_id = open.request_id / 2;
      return open;
    }
    case 3:
      return Cancel{random()};
    case 4:
      return Ping{random()};
    case 6: {
      Slice slice{.request_id = random(),
                  .dataset = dataset_info(random).name,
                  .priority = one_of<Priority>(0, 1, random)};
      slice.slice = {.coordinates = one_of<CoordinateSystem>(0, 1, random),
                     .origin = place(random),
                     .right = place(random),
                     .down = place(random),
                     .width = static_cast<std::uint32_t>(1 + up_to(1000, random)),
                     .height = static_cast<std::uint32_t>(1 + up_to(1000, random)),
                     .interpolation = one_of<Interpolation>(0, 1, random),
                     .detail = one_of<SliceDetail>(0, 2, random),
                     .accepts_packed = random() % 2 == 0};
      if (random() % 2 == 0) {
        slice.slice.inward = place(random);
        slice.slice.layers = 2;
      }
      slice.content_id = slice.request_id / 2;
      return slice;
    }
    case 7: {
      Probe probe{.request_id = random(), .dataset = dataset_info(random).name};
      probe.probe.coordinates = one_of<CoordinateSystem>(0, 1, random);
      for (std::uint64_t i = up_to(5, random) + 1; i > 0; --i) {
        probe.probe.places.push_back(place(random));
      }
      probe.content_id = probe.request_id / 2;
      return probe;
    }
    default:
      return Estimate{.request_id = random(),
                      .dataset = dataset_info(random).name,
                      .request = request(random),
                      .priority = one_of<Priority>(0, 1, random)};
  }
}

inline StepBegin step_begin(Random& random) {
  StepBegin begin;
  begin.request_id = random() | 1;
  begin.step = u32(random);
  begin.is_final = random() % 2 == 0;
  begin.request = request(random);
  begin.error_bound_world = std::abs(number(random));
  begin.finest_spacing = 1 << int_in(0, 19, random);
  if (random() % 2 == 0) begin.shell = shell_step(random);
  begin.is_unsimplified = !begin.is_final && !begin.shell && (random() & 1) != 0;
  begin.crossed_octants = static_cast<std::uint32_t>(up_to(0xFF, random));
  begin.tetrahedra = random();
  begin.active_tetrahedra = up_to(begin.tetrahedra, random);
  if (random() % 2 == 0) {
    const double low = number(random);
    begin.scalars =
        ScalarRange{.low = low, .high = low + std::abs(low), .bits = random() % 2 == 0 ? 8 : 16};
  }
  for (std::uint64_t i = up_to(20, random); i > 0; --i) begin.tiles.push_back(tile_summary(random));
  return begin;
}

inline ServerMessage server_message(std::size_t kind, Random& random) {
  switch (kind) {
    case 0:
      return Welcome{.version = static_cast<std::uint32_t>(1 + up_to(9, random)),
                     .codecs = codecs(random),
                     .agent = text(up_to(60, random), random),
                     .max_message_bytes = u32(random)};
    case 1: {
      DatasetList list{.request_id = random(), .next = text(up_to(60, random), random)};
      for (std::uint64_t i = up_to(3, random); i > 0; --i) {
        list.datasets.push_back(dataset_info(random));
      }
      return list;
    }
    case 2:
      return step_begin(random);
    case 3:
      return Tile{.request_id = random() | 1,
                  .step = u32(random),
                  .index = u32(random),
                  .payload = std::make_shared<const std::string>(
                      text(1 + up_to(300, random), random) + std::string("\0\xFF", 2))};
    case 4:
      return StepEnd{.request_id = random() | 1,
                     .step = u32(random),
                     .tiles_sent = u32(random),
                     .payload_bytes = random(),
                     .digest = {random(), random()},
                     .seconds = std::abs(number(random))};
    case 5:
      return StreamEnd{.request_id = random() | 1,
                       .outcome = one_of<StreamOutcome>(1, 3, random),
                       .steps = u32(random)};
    case 6:
      return ErrorReply{.request_id = random(),
                        .error = {.code = one_of<ErrorCode>(0, 12, random),
                                  .text = text(80, random),
                                  .retry_after = std::abs(number(random))}};
    case 7:
      return Pong{.value = random(),
                  .requires_token = random() % 2 == 0,
                  .has_new_list = random() % 2 == 0};
    case 9: {
      const auto width = static_cast<std::uint32_t>(1 + up_to(9, random));
      const auto height = static_cast<std::uint32_t>(1 + up_to(9, random));
      return SliceReply{
          .request_id = random(),
          .width = width,
          .height = height,
          .layers = 2,
          .sample_spacing = random() % 2 == 0 ? 1U : 8U,
          .values = std::make_shared<const std::string>(8 * width * height, '\xC0'),
          .packed_type = random() % 2 == 0 ? std::optional(SampleType::kI16) : std::nullopt};
    }
    case 11:
      return TileScalars{
          .request_id = random() | 1,
          .step = u32(random),
          .index = u32(random),
          .codes = std::make_shared<const std::string>(1 + up_to(99, random), '\xA1'),
          .largest_deviation = std::abs(number(random))};
    case 10: {
      ProbeReply reply{.request_id = random(), .places = {}};
      for (std::uint64_t i = up_to(5, random); i > 0; --i) {
        ProbedPlace probed{.world = place(random), .index = place(random)};
        if (random() % 2 == 0) {
          probed.value = number(random);
          probed.gradient = place(random);
        }
        reply.places.push_back(probed);
      }
      return reply;
    }
    default:
      return EstimateReply{.request_id = random(),
                           .triangles = random(),
                           .bytes = random(),
                           .error_bound_world = std::abs(number(random))};
  }
}

// ---- equality of every field

inline bool same(const Hello& a, const Hello& b) {
  return std::tie(a.min_version, a.max_version, a.codecs, a.token, a.agent, a.on_behalf_of,
                  a.client_address) == std::tie(b.min_version, b.max_version, b.codecs, b.token,
                                                b.agent, b.on_behalf_of, b.client_address);
}
inline bool same(const ListDatasets& a, const ListDatasets& b) {
  return std::tie(a.request_id, a.in_pages, a.after) == std::tie(b.request_id, b.in_pages, b.after);
}
inline bool same(const OpenStream& a, const OpenStream& b) {
  return std::tie(a.request_id, a.dataset, a.request, a.steps, a.cached_tile_digests,
                  a.resumed_previews, a.priority, a.scalars, a.use, a.further_datasets,
                  a.content_id) == std::tie(b.request_id, b.dataset, b.request, b.steps,
                                            b.cached_tile_digests, b.resumed_previews, b.priority,
                                            b.scalars, b.use, b.further_datasets, b.content_id);
}
inline bool same(const Cancel& a, const Cancel& b) { return a.request_id == b.request_id; }
inline bool same(const Ping& a, const Ping& b) { return a.value == b.value; }
inline bool same(const Welcome& a, const Welcome& b) {
  return std::tie(a.version, a.codecs, a.agent, a.max_message_bytes) ==
         std::tie(b.version, b.codecs, b.agent, b.max_message_bytes);
}
inline bool same(const DatasetList& a, const DatasetList& b) {
  return std::tie(a.request_id, a.datasets, a.next) == std::tie(b.request_id, b.datasets, b.next);
}
inline bool same(const StepBegin& a, const StepBegin& b) {
  return std::tie(a.request_id, a.step, a.is_final, a.request, a.error_bound_world,
                  a.finest_spacing, a.shell, a.tetrahedra, a.active_tetrahedra, a.tiles,
                  a.is_unsimplified, a.scalars, a.crossed_octants) ==
         std::tie(b.request_id, b.step, b.is_final, b.request, b.error_bound_world,
                  b.finest_spacing, b.shell, b.tetrahedra, b.active_tetrahedra, b.tiles,
                  b.is_unsimplified, b.scalars, b.crossed_octants);
}
inline bool same(const TileScalars& a, const TileScalars& b) {
  return std::tie(a.request_id, a.step, a.index, *a.codes, a.largest_deviation) ==
         std::tie(b.request_id, b.step, b.index, *b.codes, b.largest_deviation);
}
inline bool same(const Tile& a, const Tile& b) {
  return std::tie(a.request_id, a.step, a.index, *a.payload) ==
         std::tie(b.request_id, b.step, b.index, *b.payload);
}
inline bool same(const StepEnd& a, const StepEnd& b) {
  return std::tie(a.request_id, a.step, a.tiles_sent, a.payload_bytes, a.digest, a.seconds) ==
         std::tie(b.request_id, b.step, b.tiles_sent, b.payload_bytes, b.digest, b.seconds);
}
inline bool same(const StreamEnd& a, const StreamEnd& b) {
  return std::tie(a.request_id, a.outcome, a.steps) == std::tie(b.request_id, b.outcome, b.steps);
}
inline bool same(const ErrorReply& a, const ErrorReply& b) {
  return std::tie(a.request_id, a.error) == std::tie(b.request_id, b.error);
}
inline bool same(const Pong& a, const Pong& b) {
  return a.value == b.value && a.requires_token == b.requires_token &&
         a.has_new_list == b.has_new_list;
}
inline bool same(const Estimate& a, const Estimate& b) {
  return std::tie(a.request_id, a.dataset, a.request, a.priority, a.content_id) ==
         std::tie(b.request_id, b.dataset, b.request, b.priority, b.content_id);
}
inline bool same(const Slice& a, const Slice& b) {
  return std::tie(a.request_id, a.dataset, a.slice, a.priority, a.content_id) ==
         std::tie(b.request_id, b.dataset, b.slice, b.priority, b.content_id);
}
inline bool same(const Probe& a, const Probe& b) {
  return std::tie(a.request_id, a.dataset, a.probe, a.content_id) ==
         std::tie(b.request_id, b.dataset, b.probe, b.content_id);
}
inline bool same(const SliceReply& a, const SliceReply& b) {
  return std::tie(a.request_id, a.width, a.height, a.layers, a.sample_spacing, *a.values,
                  a.packed_type) == std::tie(b.request_id, b.width, b.height, b.layers,
                                             b.sample_spacing, *b.values, b.packed_type);
}
inline bool same(const ProbeReply& a, const ProbeReply& b) {
  return std::tie(a.request_id, a.places) == std::tie(b.request_id, b.places);
}
inline bool same(const EstimateReply& a, const EstimateReply& b) {
  return std::tie(a.request_id, a.triangles, a.bytes, a.error_bound_world) ==
         std::tie(b.request_id, b.triangles, b.bytes, b.error_bound_world);
}

template <typename... Alternatives>
bool same(const std::variant<Alternatives...>& a, const std::variant<Alternatives...>& b) {
  if (a.index() != b.index()) return false;
  return std::visit(
      [&b](const auto& value) { return same(value, std::get<std::decay_t<decltype(value)>>(b)); },
      a);
}

}  // namespace multitetra::samples
