#include "server/dataset/partitioned/part_plan.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "common/base/json.hpp"
#include "common/mesh/checksum.hpp"
#include "server/core/framework/axes.hpp"
#include "server/dataset/brick_order.hpp"
#include "server/dataset/partitioned/detail/bucket_parts.hpp"
#include "server/dataset/partitioned/detail/part_files.hpp"
#include "server/store/http_options.hpp"

namespace multitetra {
namespace {

using PlanJson = nlohmann::json;

constexpr const char* kPlanFormat = "multitetra-plan";
constexpr std::int32_t kUnit = 8 * BrickLayout::kSampleSide;  // Samples along the side of a cube.
constexpr std::int32_t kHalo = BrickLayout::kSampleSide;
static_assert(kHalo >= 2 * kSpectrumReach);

// A box in units of cubes.
struct UnitBox {
  GridPoint begin;
  GridPoint end;
};

void halve(const UnitBox& box, std::size_t parts, std::vector<UnitBox>& boxes) {
  const GridPoint extent = box.end - box.begin;
  if (parts == 1) {
    boxes.push_back(box);
    return;
  }
  int axis = 2;
  for (const int other : {1, 0}) {
    const std::int32_t length = axis == 2 && extent.z > 1 ? 4 * extent.z : extent[axis];
    if (extent[other] > length) axis = other;
  }
  if (extent[axis] <= 1) {
    boxes.push_back(box);
    boxes.insert(boxes.end(), parts - 1, UnitBox{box.end, box.end});
    return;
  }
  const std::size_t lower_parts = parts / 2;
  const double share = static_cast<double>(lower_parts) / static_cast<double>(parts);
  const auto cut =
      std::clamp(static_cast<std::int32_t>(std::lround(share * extent[axis])), 1, extent[axis] - 1);
  const auto with_cut = [&](GridPoint corner) {
    return by_axis([&](int i) { return i == axis ? box.begin[i] + cut : corner[i]; });
  };
  const UnitBox lower = {box.begin, with_cut(box.end)};
  const UnitBox upper = {with_cut(box.begin), box.end};
  halve(lower, lower_parts, boxes);
  halve(upper, parts - lower_parts, boxes);
}

}  // namespace

std::uint64_t PartBox::samples() const {
  if (is_empty()) return 0;
  const GridPoint extent = end - begin;
  return static_cast<std::uint64_t>(extent.x) * static_cast<std::uint64_t>(extent.y) *
         static_cast<std::uint64_t>(extent.z);
}

std::vector<PartBox> part_boxes(const GridCounts& dims, std::size_t parts) {
  assert(parts >= 1 && parts <= kMaxParts);
  const BrickLayout units(dims, kUnit);
  std::vector<UnitBox> boxes;
  halve({{}, {units.counts()[0], units.counts()[1], units.counts()[2]}}, parts, boxes);
  std::vector<PartBox> found;
  for (const UnitBox& box : boxes) {
    const auto within = [&](GridPoint corner) {
      return by_axis([&](int axis) {
        return std::min(kUnit * corner[axis], dims[static_cast<std::size_t>(axis)]);
      });
    };
    found.push_back({.begin = within(box.begin), .end = within(box.end)});
  }
  return found;
}

CellBox cells_of_part(const DatasetInfo& info, const PartBox& part, const CellBox& all) {
  if (part.is_empty()) return {.begin = all.end, .end = all.end};
  // Returns the first cell whose lowest corner is at or beyond this sample.
  const auto first_from = [&](GridPoint samples) {
    return by_axis([&](int axis) {
      if (samples[axis] <= 0) return all.begin[axis];
      if (samples[axis] >= info.dims[static_cast<std::size_t>(axis)]) return all.end[axis];
      const std::int32_t in_grid = samples[axis] + info.margin;
      return std::clamp((in_grid + kSpectrumSpacing - 1) / kSpectrumSpacing, all.begin[axis],
                        all.end[axis]);
    });
  };
  return {.begin = first_from(part.begin), .end = first_from(part.end)};
}

CellBox box_of(const LevelExtent& extent) {
  return {.begin = extent.low, .end = extent.low + extent.extent};
}

std::vector<std::size_t> bricks_in(const BrickLayout& bricks, const PartBox& part) {
  std::vector<std::size_t> found;
  in_file_order(bricks, [&](std::size_t brick) {
    const GridCounts at = bricks.at(brick);
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t sample = bricks.side() * at[static_cast<std::size_t>(axis)];
      if (sample < part.begin[axis] || sample >= part.end[axis]) return;
    }
    found.push_back(brick);
  });
  return found;
}

PartBox with_halo(const DatasetInfo& info, const PartBox& part) {
  return {.begin = by_axis([&](int axis) { return std::max(0, part.begin[axis] - kHalo); }),
          .end = by_axis([&](int axis) {
            return std::min(info.dims[static_cast<std::size_t>(axis)], part.end[axis] + kHalo);
          })};
}

PartCosts costs_of(const DatasetInfo& info, const PartBox& part) {
  if (part.is_empty()) return {};
  constexpr double kSecondsPerSample = 1.5e-7;  // Measured on noise in a release build.
  constexpr std::uint64_t kSlabBytes = std::uint64_t{64} << 20;
  const auto width = static_cast<std::uint64_t>(bytes_per_sample(info.type));
  const std::uint64_t slice =
      static_cast<std::uint64_t>(info.dims[0]) * static_cast<std::uint64_t>(info.dims[1]) * width;
  const std::uint64_t samples = with_halo(info, part).samples();
  return {
      .samples = samples,
      .memory_bytes = kMaxColumnBytes + 3 * std::max(kSlabBytes, slice) + (std::uint64_t{64} << 20),
      .disk_bytes = samples * width + part.samples(),
      .core_seconds = kSecondsPerSample * static_cast<double>(samples)};
}

std::string plan_text(const PartPlan& plan) {
  PlanJson json = {{"format", kPlanFormat},
                   {"version", 1},
                   {"parts", plan.parts},
                   {"metadata", metadata_text(plan.metadata)},
                   {"bins", plan.bins.edges()}};
  return text_with_checksum(json);
}

Result<PartPlan> parse_plan(std::string_view text) {
  const auto json = json_with_checksum(text, kPlanFormat);
  if (!json) return tl::unexpected(json.error());
  const auto bad = [](const std::string& what) {
    return fail(ErrorCode::kDamagedData, "The plan " + what + " Plan again.");
  };
  try {
    const auto parts = json->at("parts").get<std::size_t>();
    if (parts < 1 || parts > kMaxParts) {
      return bad("must have a number of parts from 1 to " + std::to_string(kMaxParts) + ".");
    }
    auto metadata = parse_metadata(json->at("metadata").get_ref<const std::string&>());
    if (!metadata) return bad("has invalid metadata: " + metadata.error().text);
    auto edges = json->at("bins").get<std::vector<float>>();
    const bool is_increasing =
        std::adjacent_find(edges.begin(), edges.end(), std::greater_equal<>()) == edges.end() &&
        std::all_of(edges.begin(), edges.end(), [](float edge) { return std::isfinite(edge); });
    if (!is_increasing) return bad("has bins with edges that do not increase.");
    if (edges.size() == 1 || edges.size() > IsovalueBins::kMaxCount + 1) {
      return bad("has too many bins.");
    }
    return PartPlan{
        .metadata = *std::move(metadata), .bins = IsovalueBins(std::move(edges)), .parts = parts};
  } catch (const PlanJson::exception&) {
    return bad("lacks its parts, metadata or bins.");
  }
}

std::filesystem::path parts_folder(const std::filesystem::path& dataset) {
  return dataset.string() + ".parts";
}
std::filesystem::path plan_file(const std::filesystem::path& dataset) {
  return parts_folder(dataset) / "plan.json";
}

void fail_without_plan(const std::filesystem::path& dataset) {
  throw DatasetFileError(
      plan_file(dataset),
      "the plan does not exist. Create it with: multitetra-server prepare VOLUME -o " +
          dataset.string() + " --plan PARTS");
}

StoredPlan plan_of(const std::filesystem::path& dataset) {
  if (is_address(dataset.string())) {
    const BucketParts parts(dataset);
    parts.fetch_plan();
    return parts.run([](const std::filesystem::path& file) { return plan_of(file); });
  }
  const std::filesystem::path file = plan_file(dataset);
  const auto text = small_text(file);
  if (!text) fail_without_plan(dataset);
  auto plan = parse_plan(*text);
  if (!plan) throw DatasetFileError(file, plan.error().text);
  return {.plan = *std::move(plan), .id = checksum(std::as_bytes(std::span(*text)))};
}

void write_plan(const std::filesystem::path& dataset, const PartPlan& plan) {
  if (is_address(dataset.string())) {
    const BucketParts parts(dataset);
    parts.run([&](const std::filesystem::path& file) { write_plan(file, plan); });
    parts.send_plan();
    return;
  }
  write_whole(plan_file(dataset), plan_text(plan));
}

}  // namespace multitetra
