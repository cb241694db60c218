#include "server/dataset/prepare.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/cell_ranges.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/brick_layers.hpp"
#include "server/dataset/bricked_samples.hpp"
#include "server/dataset/dataset_writer.hpp"
#include "server/dataset/detail/preferred_isovalues.hpp"
#include "server/dataset/detail/statistics.hpp"
#include "server/dataset/detail/statistics_builder.hpp"
#include "server/dataset/prepared_file.hpp"

namespace multitetra {
namespace {

void on_all_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
  in_parallel(count, body);
}

// Calls `visit(slab, slices)` for all slices in order; each slab lies in one layer of bricks.
template <typename Visit>
void for_each_slab(VolumeSource& source, const PrepareOptions& options, const char* pass,
                   const Visit& visit) {
  const VolumeHeader& header = source.header();
  const std::uint64_t slice = header.samples_per_slice();
  const auto all = slice * static_cast<std::uint64_t>(header.dims[2]);
  const std::uint64_t bytes = slice * static_cast<std::uint64_t>(bytes_per_sample(header.type));
  std::int32_t most = BrickLayers::kSlices;
  while (most > 1 && static_cast<std::uint64_t>(most) * bytes > options.slab_bytes) most /= 2;
  Samples slab;
  for (std::int32_t z = 0; z < header.dims[2]; z += most) {
    const std::int32_t slices = std::min(most, header.dims[2] - z);
    source.read(z, slices, slab);
    visit(std::as_const(slab), slices);
    if (options.progress) {
      options.progress(pass, slice * static_cast<std::uint64_t>(z + slices), all);
    }
  }
}

// Returns the dataset's geometry, checked, without its values.
DatasetInfo geometry_of(const VolumeHeader& header, const PrepareOptions& options) {
  const std::uint64_t samples =
      header.samples_per_slice() * static_cast<std::uint64_t>(header.dims[2]);
  SampleStatistics any;
  any.histogram = {.low = 0, .high = 1, .counts = {samples}};
  return describe(header, any, options.name, options.outside, options.margin);
}

// Keeps the samples in memory.
class MemorySink final : public BrickSink, public BrickSource {
 public:
  explicit MemorySink(const DatasetInfo& info)
      : layout_(info.dims), sample_bytes_(static_cast<std::size_t>(bytes_per_sample(info.type))) {
    samples_.reserve(offset_of(layout_.size() - 1) +
                     sample_bytes_ * layout_.volume(layout_.at(layout_.size() - 1)));
  }
  void add_samples(std::span<const std::byte> bytes) override {
    samples_.insert(samples_.end(), bytes.begin(), bytes.end());
  }
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override {
    return std::make_unique<ScratchMemory>();
  }
  [[nodiscard]] std::span<const std::byte> all() const { return samples_; }
  [[nodiscard]] RetainedBytes brick(std::size_t index) const override {
    return std::span(samples_).subspan(offset_of(index),
                                       sample_bytes_ * layout_.volume(layout_.at(index)));
  }

 private:
  [[nodiscard]] std::size_t offset_of(std::size_t brick) const {
    return sample_bytes_ * static_cast<std::size_t>(layout_.offset(layout_.at(brick)));
  }

  BrickLayout layout_;
  std::size_t sample_bytes_;
  std::vector<std::byte> samples_;
};

// The sections that do not go to the sink.
struct SmallParts {
  DatasetInfo info;
  std::unique_ptr<Scratch> coarse_scratch;
  std::unique_ptr<Scratch> ranges_scratch;
  CoarseVolume coarse;
  CellRanges ranges;
  std::optional<IsovalueBins> bins = std::nullopt;

  SmallParts(const DatasetInfo& geometry, const BrickSink& sink)
      : info(geometry),
        coarse_scratch(sink.new_scratch()),
        ranges_scratch(sink.new_scratch()),
        coarse(geometry, *coarse_scratch),
        ranges(geometry, *ranges_scratch) {}

  // Returns the ranges of all cells, after the first pass.
  [[nodiscard]] std::vector<std::byte> all_ranges() const {
    std::vector<std::byte> all(static_cast<std::size_t>(ranges.bytes()));
    ranges_scratch->get(0, all);
    return all;
  }
};

// Returns bins with these edges, limited to the range of values in `info`.
IsovalueBins bins_with_edges(const DatasetInfo& info, std::span<const float> inner) {
  const auto outside = static_cast<float>(info.outside.value_or(info.min));
  const float low = std::min(static_cast<float>(info.min), outside);
  const float high = std::max(static_cast<float>(info.max), outside);
  if (low == high) return IsovalueBins({});
  std::vector<float> edges = {low};
  for (const float edge : inner) {
    if (edge > edges.back() && edge < high) edges.push_back(edge);
  }
  edges.push_back(high);
  return IsovalueBins(std::move(edges));
}

// Adds all samples to the statistics for the second time, from the source.
void count_again(VolumeSource& source, const PrepareOptions& options,
                 SampleStatisticsBuilder& builder) {
  for_each_slab(source, options, "histogram", [&](const Samples& slab, std::int32_t) {
    builder.add_second_pass(std::get<std::vector<float>>(slab));
  });
}

// The same, from memory.
void count_again(std::span<const std::byte> samples, const PrepareOptions& options,
                 SampleStatisticsBuilder& builder) {
  const std::size_t all = samples.size() / sizeof(float);
  const std::span<const float> values(reinterpret_cast<const float*>(samples.data()), all);
  const std::size_t most = std::max(options.slab_bytes / sizeof(float), std::size_t{1});
  for (std::size_t done = 0; done < all;) {
    const std::size_t count = std::min(most, all - done);
    builder.add_second_pass(values.subspan(done, count));
    done += count;
    if (options.progress) options.progress("histogram", done, all);
  }
}

// Completes a survey. `builder` has counted every sample twice if it needs that.
VolumeSurvey surveyed(VolumeSource& source, const PrepareOptions& options,
                      const SampleStatisticsBuilder& builder) {
  DatasetInfo info =
      describe(source.header(), builder.finish(), options.name, options.outside, options.margin);
  info.meaning.rounding = source.rounding();
  info.member = options.member;
  if (options.label_volume) info.label_extent = options.label_volume->extent();
  info.display_window = source.contents().display_window;
  prefer_known_isovalues(source.contents().recommended_isovalue, info);
  if (!options.suggested_isovalues.empty()) info.suggested_isovalues = options.suggested_isovalues;
  IsovalueBins bins = options.bin_edges.empty()
                          ? IsovalueBins::for_values(info, builder.distinct_values(), options.bins)
                          : bins_with_edges(info, options.bin_edges);
  return {.info = std::move(info), .bins = std::move(bins)};
}

// Writes the samples to the sink, and collects their statistics and the small sections in `parts`.
// `count_again` adds all samples to the statistics for the second time.
template <typename CountAgain>
void first_pass(VolumeSource& source, const PrepareOptions& options, BrickSink& sink,
                SmallParts& parts, const CountAgain& count_again) {
  SampleStatisticsBuilder builder(source.header().type);
  BrickLayers bricks(source.header(), sink);
  for_each_slab(source, options, "range", [&](const Samples& slab, std::int32_t slices) {
    builder.add(slab);
    bricks.add(slab, slices);
    parts.ranges.add(slab, slices, on_all_threads);
    parts.coarse.add(slab, slices);
  });
  if (builder.needs_second_pass()) count_again(builder);
  VolumeSurvey found = surveyed(source, options, builder);
  parts.info = std::move(found.info);
  parts.bins = std::move(found.bins);
}

// The box in which samples vary: all samples outside of it are equal to `elsewhere`.
struct NonconstantBox {
  std::array<std::int32_t, 3> least = {};     // Least sample indices.
  std::array<std::int32_t, 3> greatest = {};  // Greatest sample indices, at least `least`.
  float elsewhere = 0;
};

// Returns that box of a volume whose first cell is constant.
template <typename Sample>
std::optional<NonconstantBox> nonconstant_box(const DatasetInfo& info,
                                              std::span<const std::byte> ranges) {
  const LevelExtent cells = cell_extent(info);
  std::array<Sample, 2> first;
  std::memcpy(first.data(), ranges.data(), sizeof(first));
  if (first[0] != first[1]) return std::nullopt;
  GridPoint low = cells.low + cells.extent;
  GridPoint high = cells.low - GridPoint{1, 1, 1};
  const std::byte* range = ranges.data();
  const GridPoint end = cells.low + cells.extent;
  for (std::int32_t z = cells.low.z; z < end.z; ++z) {
    for (std::int32_t y = cells.low.y; y < end.y; ++y) {
      for (std::int32_t x = cells.low.x; x < end.x; ++x, range += sizeof(first)) {
        if (std::memcmp(range, first.data(), sizeof(first)) == 0) continue;
        low = {std::min(low.x, x), std::min(low.y, y), std::min(low.z, z)};
        high = {std::max(high.x, x), std::max(high.y, y), std::max(high.z, z)};
      }
    }
  }
  if (low.x > high.x) return std::nullopt;
  NonconstantBox box{.elsewhere = static_cast<float>(first[0])};
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    box.least[i] = std::max(0, kSpectrumSpacing * low[axis] - info.margin);
    box.greatest[i] = std::min(info.dims[i] - 1, kSpectrumSpacing * (high[axis] + 1) - info.margin);
  }
  return box;
}

// Returns the cells whose errors depend on samples in the box; nullopt means all of them, when the
// value beyond the data differs from `elsewhere`.
std::optional<CellBox> nonconstant_cells(const DatasetInfo& info,
                                         std::span<const std::byte> ranges) {
  const auto box = visit_type(info.type, [&]<typename Sample>(const Sample*) {
    return nonconstant_box<Sample>(info, ranges);
  });
  if (!box) return std::nullopt;
  if (info.outside && *info.outside != static_cast<double>(box->elsewhere)) return std::nullopt;
  const CellBox all = spectrum_cells(info);
  const auto begin = [&](std::size_t axis, std::int32_t first_cell) {
    // The last grid step of a cell is the first one of the next cell.
    const std::int32_t step = std::max(0, box->least[axis] + info.margin - kSpectrumReach - 1);
    return std::max(first_cell, step / kSpectrumSpacing);
  };
  const auto end = [&](std::size_t axis, std::int32_t last_cell) {
    const std::int32_t step = box->greatest[axis] + info.margin + kSpectrumReach;
    return std::min(last_cell, step / kSpectrumSpacing + 1);
  };
  return CellBox{.begin = {begin(0, all.begin.x), begin(1, all.begin.y), begin(2, all.begin.z)},
                 .end = {end(0, all.end.x), end(1, all.end.y), end(2, all.end.z)}};
}

// Computes the errors.
void second_pass(const DatasetInfo& info, const IsovalueBins& bins, const CoarseVolume& coarse,
                 std::span<const std::byte> ranges, const BrickedSamples::ReadBricks& read,
                 const PrepareOptions& options, DatasetWriter& sink) {
  const BrickedSamples samples(info.dims, info.type,
                               [&](std::size_t first, std::span<std::byte> bytes) {
                                 throw_if_stopped(options.stop);
                                 read(first, bytes);
                               });
  const std::uint64_t all = static_cast<std::uint64_t>(info.dims[0]) *
                            static_cast<std::uint64_t>(info.dims[1]) *
                            static_cast<std::uint64_t>(info.dims[2]);
  const std::unique_ptr<Scratch> scratch = sink.new_scratch();
  std::mutex mutex;  // Guards `done` and the progress.
  std::uint64_t done = 0;
  const auto progress = [&](std::uint64_t more) {
    if (!options.progress || more == 0) return;
    const std::lock_guard lock(mutex);
    options.progress("errors", done += more, all);
  };
  build_spectrum(
      info, bins,
      {.samples = samples,
       .coarse = coarse,
       .scratch = *scratch,
       .for_each = options.for_each ? options.for_each : on_all_threads,
       .threads = parallel_threads(),
       .column_bytes = options.column_bytes,
       .sink = [&](std::size_t brick,
                   std::span<const std::byte> bytes) { sink.add_spectrum_brick(brick, bytes); },
       .progress = progress,
       .nonconstant_cells = nonconstant_cells(info, ranges)});
  progress(all - done);  // Counts the samples of skipped cells as done.
}

DatasetInfo checked_geometry(const VolumeSource& source, const PrepareOptions& options) {
  if (options.bins < 1 || options.bins > IsovalueBins::kMaxCount) {
    throw std::invalid_argument("The number of bins is " + std::to_string(options.bins) +
                                "; it must be 1 to " + std::to_string(IsovalueBins::kMaxCount) +
                                ".");
  }
  return geometry_of(source.header(), options);
}

}  // namespace

VolumeSurvey survey(VolumeSource& source, const PrepareOptions& options) {
  (void)checked_geometry(source, options);
  SampleStatisticsBuilder builder(source.header().type);
  for_each_slab(source, options, "range",
                [&](const Samples& slab, std::int32_t) { builder.add(slab); });
  if (builder.needs_second_pass()) count_again(source, options, builder);
  return surveyed(source, options, builder);
}

DatasetInfo prepare(VolumeSource& source, const PrepareOptions& options,
                    const std::filesystem::path& output, const Provenance& note) {
  const DatasetInfo geometry = checked_geometry(source, options);
  DatasetWriter sink(output, geometry);
  SmallParts parts(geometry, sink);
  first_pass(source, options, sink, parts,
             [&](SampleStatisticsBuilder& builder) { count_again(source, options, builder); });
  if (options.accept) options.accept(parts.info);
  if (options.samples_only) {
    parts.info.missing = kMissingErrors;
  } else {
    second_pass(
        parts.info, *parts.bins, parts.coarse, parts.all_ranges(),
        [&](std::size_t first, std::span<std::byte> bytes) { sink.read_samples(first, bytes); },
        options, sink);
  }
  sink.finish({.info = parts.info,
               .label_volume = options.label_volume,
               .source = note,
               .program_version = MULTITETRA_VERSION},
              {.coarse = SectionBytes(parts.coarse.bytes(), *parts.coarse_scratch),
               .ranges = SectionBytes(parts.ranges.bytes(), *parts.ranges_scratch),
               .bins = std::as_bytes(std::span(parts.bins->edges()))});
  return parts.info;
}

DatasetPtr prepare_in_memory(VolumeSource& source, const PrepareOptions& options) {
  struct Content {
    explicit Content(const DatasetInfo& geometry) : samples(geometry) {}
    MemorySink samples;
    std::vector<std::byte> coarse;
    std::vector<std::byte> ranges;
  };
  const DatasetInfo geometry = checked_geometry(source, options);
  const auto content = std::make_shared<Content>(geometry);
  SmallParts parts(geometry, content->samples);
  first_pass(source, options, content->samples, parts, [&](SampleStatisticsBuilder& builder) {
    count_again(content->samples.all(), options, builder);
  });
  parts.info.missing = kMissingErrors;
  content->coarse.resize(static_cast<std::size_t>(parts.coarse.bytes()));
  parts.coarse_scratch->get(0, content->coarse);
  content->ranges = parts.all_ranges();
  return std::make_shared<const PreparedVolume>(
      PreparedVolume{.info = parts.info,
                     .samples = std::shared_ptr<const BrickSource>(content, &content->samples),
                     .coarse = std::span<const std::byte>(content->coarse),
                     .ranges = std::span<const std::byte>(content->ranges),
                     .spectrum = {.layout = SpectrumLayout(parts.info),
                                  .bins = *std::move(parts.bins),
                                  .voxel = static_cast<float>(voxel_length(parts.info)),
                                  .bricks = nullptr},
                     .owner = content});
}

DatasetInfo complete(const std::string& dataset, const PrepareOptions& options,
                     const std::filesystem::path& output) {
  const PreparedFile file(dataset);
  if (file.info().missing.empty()) throw DatasetFileError(dataset, "it has all its errors.");
  DatasetMetadata metadata = file.metadata();
  DatasetInfo& info = metadata.info;
  info.missing.clear();
  DatasetWriter sink(output, info);
  const std::unique_ptr<Scratch> coarse = sink.new_scratch();
  (void)coarse->put(file.coarse());
  const auto samples = file.samples();
  const auto read = [&](std::size_t first, std::span<std::byte> bytes) {
    for (; !bytes.empty(); ++first) {
      const RetainedBytes brick = samples->brick(first);
      std::copy(brick.begin(), brick.end(), bytes.begin());
      bytes = bytes.subspan(brick.size());
    }
  };
  second_pass(info, open_dataset(dataset)->spectrum.bins, CoarseVolume(info, *coarse),
              file.ranges(), read, options, sink);
  sink.finish(metadata, {.coarse = file.coarse(), .ranges = file.ranges(), .bins = file.bins()},
              [&](std::size_t brick) { return samples->packed(brick); });
  return info;
}

void write_samples(const PreparedVolume& dataset, const std::filesystem::path& output,
                   const Provenance& note) {
  const DatasetInfo& info = dataset.info;
  DatasetWriter sink(output, info);
  for (std::size_t i = 0; i < BrickLayout(info.dims).size(); ++i) {
    const RetainedBytes brick = dataset.samples->brick(i);
    sink.add_samples({brick.data(), brick.size()});
  }
  sink.finish({.info = info, .source = note, .program_version = MULTITETRA_VERSION},
              {.coarse = SectionBytes(dataset.coarse.bytes()),
               .ranges = SectionBytes(dataset.ranges.bytes()),
               .bins = std::as_bytes(std::span(dataset.spectrum.bins.edges()))});
}

}  // namespace multitetra
