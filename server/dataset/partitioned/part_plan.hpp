// Prepares a volume in parts, on independent machines: the plan that all
// of them read.
//
// A part is a box of whole cubes of 128^3 samples, whose bricks follow each other in the dataset's
// file.
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

inline constexpr std::size_t kMostParts = 65536;

struct PartPlan {
  DatasetMetadata metadata;
  IsovalueBins bins{{}};
  std::size_t parts = 1;
};

// Samples begin ... end - 1.
struct PartBox {
  GridPoint begin;
  GridPoint end;

  [[nodiscard]] bool is_empty() const {
    return begin.x >= end.x || begin.y >= end.y || begin.z >= end.z;
  }
  [[nodiscard]] std::uint64_t samples() const;

  friend bool operator==(const PartBox&, const PartBox&) = default;
};

// The boxes of all parts, about equally large, which together are the volume. Halved along the
// longest axis, again and again; along z four times as long as it is, since slices are read as a
// whole. Where there are more parts than cubes some are empty. Requires 1 to kMostParts parts.
[[nodiscard]] std::vector<PartBox> part_boxes(const GridCounts& dims, std::size_t parts);

// The part's cells, of all that there are: those whose lowest corner is a sample of the part, or
// lies beyond the data next to it.
[[nodiscard]] CellBox cells_of_part(const DatasetInfo& info, const PartBox& part,
                                    const CellBox& all);

// All that there are of a level.
[[nodiscard]] CellBox box_of(const LevelExtent& extent);

// The bricks of samples that lie in a part, in the order of the dataset's file.
[[nodiscard]] std::vector<std::size_t> bricks_in(const BrickLayout& bricks, const PartBox& part);

// The samples that a part reads: its own and those around it that count for its errors.
[[nodiscard]] PartBox with_halo(const DatasetInfo& info, const PartBox& part);

// The expected cost of a part.
struct PartCosts {
  std::uint64_t samples = 0;       // Read, those around it included.
  std::uint64_t memory_bytes = 0;  // At most.
  std::uint64_t disk_bytes = 0;    // While it runs, and for the merge.
  double core_seconds = 0;         // About: noise takes more, smooth fields less.
};
[[nodiscard]] PartCosts costs_of(const DatasetInfo& info, const PartBox& part);

// JSON with a checksum, and back: the same plan, bit for bit. kDamagedData otherwise.
[[nodiscard]] std::string plan_text(const PartPlan& plan);
[[nodiscard]] Result<PartPlan> parse_plan(std::string_view text);

// The folder of plan and parts while a dataset is prepared: "head.mtd.parts" beside "head.mtd".
[[nodiscard]] std::filesystem::path parts_folder(const std::filesystem::path& dataset);
[[nodiscard]] std::filesystem::path plan_file(const std::filesystem::path& dataset);

// The plan of that dataset, and its text's checksum. Throws DatasetFileError with what to do where
// there is none.
struct KnownPlan {
  PartPlan plan;
  std::uint64_t id = 0;
};
[[nodiscard]] KnownPlan plan_of(const std::filesystem::path& dataset);

// Writes the plan there, whole or not at all. Throws DatasetFileError.
void write_plan(const std::filesystem::path& dataset, const PartPlan& plan);

}  // namespace multitetra
