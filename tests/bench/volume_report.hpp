// What volume_bench found out about one volume, as a table for people and as JSON for scripts.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/cli/json_report.hpp"
#include "common/request/dataset_info.hpp"

namespace multitetra {

// How long the same work took, run after run.
struct Timing {
  // Empty where it was not measured.
  std::vector<double> seconds;

  [[nodiscard]] double median() const;
  [[nodiscard]] double least() const;
};

// One piece of work under several numbers of threads.
struct Measurement {
  std::string work;
  std::uint64_t triangles = 0;
  std::uint64_t encoded_bytes = 0;  // 0 where nothing is encoded.
  std::vector<Timing> timings;      // One per number of threads, in the report's order.
};

// The number of bricks read, and of all bricks.
struct BrickReads {
  std::uint64_t sample_reads = 0;
  std::uint64_t sample_bricks = 0;
  std::uint64_t spectrum_reads = 0;
  std::uint64_t spectrum_bricks = 0;
};

struct VolumeReport {
  DatasetInfo info;
  double isovalue = 0;
  std::uint64_t file_bytes = 0;  // The size of the prepared file.
  double open_seconds = 0;       // Median.
  int processors = 0;
  std::vector<int> threads;               // As requested.
  std::vector<std::string> flying_edges;  // How it ran, per number of threads; empty without VTK.
  // For the first preview; none where there is no preview.
  std::optional<BrickReads> preview;
  std::vector<Measurement> measurements;  // Flying edges first, where they are available.

  // What the prepared file has beyond the samples themselves.
  [[nodiscard]] double overhead_bytes_per_voxel() const;
  // The median of a measurement over that of flying edges with the same number of threads; `index`
  // is a place in `threads`. None without VTK.
  [[nodiscard]] std::optional<double> ratio(const Measurement& measurement,
                                            std::size_t index) const;
  // How much faster the last number of threads is than the first. None with one number only.
  [[nodiscard]] std::optional<double> speedup(const Measurement& measurement) const;
};

// Facts, a line each, then a table whose lines begin with '|'.
[[nodiscard]] std::string table_of(const VolumeReport& report);
[[nodiscard]] Json json_of(const VolumeReport& report);

}  // namespace multitetra
