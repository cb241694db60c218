// Preparation converts a volume into a dataset that can be served: one pass over the source (two
// for floating-point samples), then one over the samples in the unfinished dataset. For a source
// that streams, it takes less than 1 GiB of memory, regardless of the volume's size and content and
// the number of threads: slabs, columns of the spectrum (spectrum_builder.hpp) and 8 bytes per
// brick of samples. All other data that grow with the volume are buffered in unnamed temporary
// files.
//
//   const auto source = open_volume("CThead.nhdr");
//   prepare(*source, {.name = "head"}, "head.mtd", provenance("CThead.nhdr"));
//
// The errors take most of the time. A dataset can be served without them, and completed later:
//
//   prepare(*source, {.name = "head", .samples_only = true}, "head.mtd", provenance("CThead.nhdr"));
//   complete("head.mtd", {}, "head.mtd");
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/provenance.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

struct PrepareOptions {
  std::string name = {};
  std::optional<double> outside = std::nullopt;  // The value beyond the data; absent means void.
  std::int32_t margin = 0;                       // Grid steps around the data.
  // Number of bins of the error spectrum, 1 to kMaxCount.
  int bins = IsovalueBins::kDefaultCount;
  std::optional<SeriesMember> member = std::nullopt;
  std::optional<LabelVolume> label_volume = std::nullopt;
  // Override the isovalues suggested from the histogram, and the even bins. Edges must increase
  // strictly; those outside the range of values are dropped.
  std::vector<double> suggested_isovalues = {};
  std::vector<float> bin_edges = {};
  // Leaves out the errors.
  bool samples_only = false;
  // Runs the computation of the errors; null: on all threads.
  ForEach for_each = nullptr;
  // Ends that computation with Cancelled.
  std::stop_token stop = {};
  // Bound the memory; they do not affect the result.
  std::size_t slab_bytes = std::size_t{64} << 20;  // Bytes read at a time; a slice may exceed it.
  std::size_t column_bytes = kMaxColumnBytes;      // See spectrum_builder.hpp.
  // Called from time to time with the current pass ("range", "histogram", "errors") and the number
  // of samples of that pass that are done and in total.
  std::function<void(const char* pass, std::uint64_t done, std::uint64_t all)> progress = nullptr;
  // Called with the statistics of all samples before the file is written; may throw to refuse it.
  std::function<void(const DatasetInfo& info)> accept = nullptr;
};

// Statistics of all samples; the errors of any part depend on them.
struct VolumeSurvey {
  DatasetInfo info;
  IsovalueBins bins;
};

// Reads the volume once, or twice for floating-point samples. Throws as prepare() does.
[[nodiscard]] VolumeSurvey survey(VolumeSource& source, const PrepareOptions& options);

// Writes the dataset file atomically; its bytes do not depend on the number of threads. Throws
// std::invalid_argument if an option is out of range or the volume exceeds the largest grid,
// VolumeFileError if the source fails, DatasetFileError if the disk fails.
DatasetInfo prepare(VolumeSource& source, const PrepareOptions& options,
                    const std::filesystem::path& output, const Provenance& note);

// Computes the errors of a dataset prepared with samples_only: writes, atomically, the file that
// prepare() writes with them, also over `dataset`. Of the options it takes those that do not affect
// the result. Throws DatasetFileError if `dataset` cannot be read, is damaged or has errors, or the
// disk fails.
DatasetInfo complete(const std::string& dataset, const PrepareOptions& options,
                     const std::filesystem::path& output);

// Prepares a dataset without errors in the memory of this process: a copy of the samples, and the
// small sections. Throws as prepare() does.
[[nodiscard]] DatasetPtr prepare_in_memory(VolumeSource& source, const PrepareOptions& options);

// Writes such a dataset as a file without errors. Throws DatasetFileError if the disk fails.
void write_samples(const PreparedVolume& dataset, const std::filesystem::path& output,
                   const Provenance& note);

}  // namespace multitetra
