// The plan of a preparation in parts, which the independent machines that prepare them read.
//
// A part is a box of whole cubes of 128^3 samples; its bricks are contiguous in the dataset's file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/dataset/dataset_metadata.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxParts = 65536;

struct PartPlan {
  DatasetMetadata metadata;
  IsovalueBins bins{{}};
  std::size_t parts = 1;
};

// Samples begin to end - 1.
struct PartBox {
  GridPoint begin;
  GridPoint end;

  [[nodiscard]] bool is_empty() const {
    return begin.x >= end.x || begin.y >= end.y || begin.z >= end.z;
  }
  [[nodiscard]] std::uint64_t samples() const;

  friend bool operator==(const PartBox&, const PartBox&) = default;
};

// Divides the volume into boxes of about equal size by repeatedly halving the longest axis. The z
// axis counts four times its length, since slices are read as a whole. If there are more parts than
// cubes, some are empty. Requires 1 to kMaxParts parts.
[[nodiscard]] std::vector<PartBox> part_boxes(const GridCounts& dims, std::size_t parts);

// Returns the part's share of the cells `all`: those whose lowest corner is a sample of the part,
// or lies beyond the data next to it.
[[nodiscard]] CellBox cells_of_part(const DatasetInfo& info, const PartBox& part,
                                    const CellBox& all);

// Returns the box of all cells of a level.
[[nodiscard]] CellBox box_of(const LevelExtent& extent);

// Returns the bricks of samples of a part, in the order of the dataset's file.
[[nodiscard]] std::vector<std::size_t> bricks_in(const BrickLayout& bricks, const PartBox& part);

// Returns the samples that a part reads: its own, and neighbors that influence its errors.
[[nodiscard]] PartBox with_halo(const DatasetInfo& info, const PartBox& part);

// The estimated cost of a part.
struct PartCosts {
  std::uint64_t samples = 0;       // Samples to read, including neighbors.
  std::uint64_t memory_bytes = 0;  // Upper bound.
  std::uint64_t disk_bytes = 0;    // While it runs, and for the merge.
  double core_seconds = 0;         // A rough estimate: noise takes more, smooth fields less.
};
[[nodiscard]] PartCosts costs_of(const DatasetInfo& info, const PartBox& part);

// Convert a plan to JSON with a checksum and back, bit for bit. parse_plan() returns kDamagedData
// for any other text.
[[nodiscard]] std::string plan_text(const PartPlan& plan);
[[nodiscard]] Result<PartPlan> parse_plan(std::string_view text);

// Returns the folder of the plan and the parts: "head.mtd.parts" for "head.mtd".
[[nodiscard]] std::filesystem::path parts_folder(const std::filesystem::path& dataset);
[[nodiscard]] std::filesystem::path plan_file(const std::filesystem::path& dataset);

// The plan of a dataset, and the checksum of its text. plan_of() throws DatasetFileError, with a
// remedy, if there is none.
struct StoredPlan {
  PartPlan plan;
  std::uint64_t id = 0;
};
[[nodiscard]] StoredPlan plan_of(const std::filesystem::path& dataset);

// Writes the plan atomically. Throws DatasetFileError.
void write_plan(const std::filesystem::path& dataset, const PartPlan& plan);

}  // namespace multitetra
