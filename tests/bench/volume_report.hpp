// The results of volume_bench for one volume, as a table and as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/json/json_report.hpp"

namespace multitetra {

// The seconds of repeated runs of the same work.
struct Timing {
  // Empty if not measured.
  std::vector<double> seconds;

  [[nodiscard]] double median() const;
  [[nodiscard]] double least() const;
};

// One piece of work with several numbers of threads.
struct Measurement {
  std::string work;
  std::uint64_t triangles = 0;
  std::uint64_t encoded_bytes = 0;  // 0 if nothing is encoded.
  std::vector<Timing> timings;      // One per number of threads, in the report's order.
};

// The numbers of bricks read, and of all bricks.
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
  std::vector<int> threads;               // The requested numbers.
  std::vector<std::string> flying_edges;  // The backend per number of threads; empty without VTK.
  // For the first preview; nullopt if there is none.
  std::optional<BrickReads> preview;
  std::vector<Measurement> measurements;  // Flying edges first, if available.

  // Returns the file's size beyond the samples.
  [[nodiscard]] double overhead_bytes_per_voxel() const;
  // Returns the median of a measurement divided by that of flying edges with the same number of
  // threads; `index` is an index in `threads`. nullopt without VTK.
  [[nodiscard]] std::optional<double> ratio(const Measurement& measurement,
                                            std::size_t index) const;
  // Returns the speedup of the last number of threads over the first; nullopt with only one.
  [[nodiscard]] std::optional<double> speedup(const Measurement& measurement) const;
};

// Returns one property per line, then a table whose lines begin with '|'.
[[nodiscard]] std::string table_of(const VolumeReport& report);
[[nodiscard]] Json json_of(const VolumeReport& report);

}  // namespace multitetra
