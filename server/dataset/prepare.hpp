// Preparing: a volume in, a dataset that can be served out. One pass over the source (two when its
// samples are floating-point), then one over the samples in the unfinished dataset. Into a file, of
// a source that streams, it takes less than 1 GiB of memory whatever the volume's size and content,
// and the number of threads: slabs, columns of the spectrum (spectrum_builder.hpp) and 8
// bytes for each brick of samples; what else grows with the volume waits in files without a name.
//
//   const auto source = open_volume("CThead.nhdr");
//   prepare(*source, {.name = "head"}, "head.mtd", provenance("CThead.nhdr"));
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/provenance.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Where a volume's samples differ: those outside of the box are all `elsewhere`.
struct VariedSamples {
  std::array<std::int32_t, 3> least = {};     // Indices of samples,
  std::array<std::int32_t, 3> greatest = {};  // and the last ones; none less than in `least`.
  float elsewhere = 0;
};

struct PrepareOptions {
  std::string name;
  std::optional<double> outside = std::nullopt;  // The value beyond the data; none means void.
  std::int32_t margin = 0;                       // Grid steps around the data.
  // Bins of the error spectrum, 1 to kMaxCount.
  int bins = IsovalueBins::kDefaultCount;
  std::optional<SeriesMember> member = std::nullopt;
  std::optional<LabelVolume> label_volume = std::nullopt;
  // Where these are given: instead of those that the histogram suggests, and of even bins. Edges
  // increase strictly; those beyond the values are left out.
  std::vector<double> suggested_isovalues = {};
  std::vector<float> bin_edges = {};
  // Saves time, where it is known; the result is the same.
  std::optional<VariedSamples> varied = std::nullopt;
  // Bounds of memory; the result is the same for any.
  std::size_t slab_bytes = std::size_t{64} << 20;  // Read at a time; a slice may be larger.
  std::size_t column_bytes = kMostColumnBytes;     // See spectrum_builder.hpp.
  // Called now and then with the current pass ("range", "errors") and how many of how many samples
  // of that pass are done.
  std::function<void(const char* pass, std::uint64_t done, std::uint64_t all)> progress = nullptr;
};

// Statistics of all samples, needed before the errors of any part are computed.
struct VolumeSurvey {
  DatasetInfo info;
  IsovalueBins bins;
};

// Reads the volume once (floating-point ones twice). Throws as prepare().
[[nodiscard]] VolumeSurvey survey(VolumeSource& source, const PrepareOptions& options);

// Writes the dataset file; it appears whole or not at all. The same bytes for any number of
// threads. Throws std::invalid_argument when an option is outside its range or the volume does not
// fit the largest grid, VolumeFileError when the source fails, DatasetFileError when the disk does.
DatasetInfo prepare(VolumeSource& source, const PrepareOptions& options,
                    const std::filesystem::path& output, const Provenance& note);

}  // namespace multitetra
