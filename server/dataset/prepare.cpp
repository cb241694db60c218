#include "server/dataset/prepare.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "server/core/cell_ranges.hpp"
#include "server/core/spectrum_builder.hpp"
#include "server/core/spectrum_layout.hpp"
#include "server/dataset/dataset_writer.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/dataset/statistics.hpp"
#include "server/dataset/statistics_builder.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kSlabSlices = BrickLayout::kSampleSide;  // A slab is a layer of bricks.

void on_all_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
  in_parallel(count, body);
}

// ---- where a prepared volume goes

class Sink {
 public:
  virtual ~Sink() = default;
  // The next layer of bricks.
  virtual void add_samples(std::span<const std::byte> bytes) = 0;
  virtual void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) = 0;
};

class FileSink : public Sink {
 public:
  FileSink(const std::filesystem::path& path, const DatasetInfo& info)
      : writer_(path, {.dims = info.dims,
                       .type = info.type,
                       .spectrum_bricks = SpectrumLayout(info).size()}) {}
  void add_samples(std::span<const std::byte> bytes) override { writer_.add_samples(bytes); }
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override {
    writer_.add_spectrum_brick(index, bytes);
  }
  [[nodiscard]] DatasetWriter& writer() { return writer_; }

 private:
  DatasetWriter writer_;
};

class BricksInMemory : public BrickSource {
 public:
  explicit BricksInMemory(std::size_t count) : bricks_(count) {}
  [[nodiscard]] std::span<const std::byte> brick(std::size_t index) const override {
    return bricks_[index];
  }
  void set(std::size_t index, std::span<const std::byte> bytes) {
    bricks_[index].assign(bytes.begin(), bytes.end());
  }

 private:
  std::vector<std::vector<std::byte>> bricks_;
};

class MemorySink : public Sink {
 public:
  explicit MemorySink(const DatasetInfo& info)
      : sample_bytes_(static_cast<std::size_t>(bytes_per_sample(info.type))),
        layout_(info.dims),
        samples_(std::make_shared<BricksInMemory>(layout_.size())),
        spectrum_(std::make_shared<BricksInMemory>(SpectrumLayout(info).size())) {}
  void add_samples(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const std::size_t size = sample_bytes_ * layout_.volume(layout_.at(next_));
      samples_->set(next_++, bytes.first(size));
      bytes = bytes.subspan(size);
    }
  }
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override {
    spectrum_->set(index, bytes);
  }
  [[nodiscard]] std::shared_ptr<const BrickSource> samples() const { return samples_; }
  [[nodiscard]] std::shared_ptr<const BrickSource> spectrum() const { return spectrum_; }

 private:
  std::size_t sample_bytes_;
  BrickLayout layout_;
  std::shared_ptr<BricksInMemory> samples_;
  std::shared_ptr<BricksInMemory> spectrum_;
  std::size_t next_ = 0;
};

// ---- the two passes

// Calls `visit(slab, slices)` for all slices in order.
template <typename Visit>
void for_each_slab(VolumeSource& source, const PrepareOptions& options, const char* pass,
                   const Visit& visit) {
  const VolumeHeader& header = source.header();
  const std::uint64_t slice = header.samples_per_slice();
  const auto all = slice * static_cast<std::uint64_t>(header.dims[2]);
  Samples slab;
  for (std::int32_t z = 0; z < header.dims[2]; z += kSlabSlices) {
    const std::int32_t slices = std::min(kSlabSlices, header.dims[2] - z);
    source.read(z, slices, slab);
    visit(std::as_const(slab), slices);
    if (options.progress) {
      options.progress(pass, slice * static_cast<std::uint64_t>(z + slices), all);
    }
  }
}

// The first pass.
struct Facts {
  SampleStatistics statistics;
  std::vector<float> distinct_values;
};
Facts facts_of(VolumeSource& source, const PrepareOptions& options) {
  SampleStatisticsBuilder builder(source.header().type);
  for_each_slab(source, options, "range",
                [&](const Samples& slab, std::int32_t) { builder.add(slab); });
  if (builder.needs_second_pass()) {
    for_each_slab(source, options, "histogram",
                  [&](const Samples& slab, std::int32_t) { builder.add_again(slab); });
  }
  return {builder.finish(), builder.distinct_values()};
}

// A slab in the order of its layer of bricks.
class Brickwork {
 public:
  explicit Brickwork(const DatasetInfo& info) : layout_(info.dims) {}

  [[nodiscard]] std::span<const std::byte> layer(const Samples& slab, std::int32_t slices) {
    std::visit([&](const auto& samples) { rearrange(samples, slices); }, slab);
    return bytes_;
  }

 private:
  template <typename Sample>
  void rearrange(const std::vector<Sample>& samples, std::int32_t slices) {
    bytes_.resize(samples.size() * sizeof(Sample));
    const GridCounts dims = {layout_.dims()[0], layout_.dims()[1], slices};
    const BrickLayout slab(dims);
    in_parallel(static_cast<std::size_t>(slab.counts()[1]), [&](std::size_t by) {
      for (std::int32_t bx = 0; bx < slab.counts()[0]; ++bx) {
        const GridCounts brick = {bx, static_cast<std::int32_t>(by), 0};
        copy_brick(samples, slab, brick, bytes_.data() + slab.offset(brick) * sizeof(Sample));
      }
    });
  }
  template <typename Sample>
  static void copy_brick(const std::vector<Sample>& samples, const BrickLayout& slab,
                         const GridCounts& brick, std::byte* into) {
    const GridCounts extent = slab.extent(brick);
    const std::size_t row_bytes = static_cast<std::size_t>(extent[0]) * sizeof(Sample);
    for (std::int32_t z = 0; z < extent[2]; ++z) {
      for (std::int32_t y = 0; y < extent[1]; ++y, into += row_bytes) {
        const std::ptrdiff_t from =
            slab.side() * brick[0] +
            std::ptrdiff_t{slab.dims()[0]} *
                (slab.side() * brick[1] + y + std::ptrdiff_t{slab.dims()[1]} * z);
        std::memcpy(into, samples.data() + from, row_bytes);
      }
    }
  }

  BrickLayout layout_;
  std::vector<std::byte> bytes_;
};

// What the second pass leaves, beside what went to the sink.
struct SmallParts {
  Samples coarse;
  CellRanges ranges;
  IsovalueBins bins;

  [[nodiscard]] std::span<const std::byte> coarse_bytes() const {
    return std::visit([](const auto& samples) { return std::as_bytes(std::span(samples)); },
                      coarse);
  }
};

SmallParts second_pass(VolumeSource& source, const PrepareOptions& options, const DatasetInfo& info,
                       const IsovalueBins& bins, Sink& sink) {
  SmallParts parts{.coarse = {}, .ranges = CellRanges(info), .bins = bins};
  Brickwork brickwork(info);
  SpectrumBuilder spectrum(
      info, bins,
      [&](std::size_t brick, std::span<const std::byte> bytes) {
        sink.add_spectrum_brick(brick, bytes);
      },
      on_all_threads, parallel_threads() == 1 ? 1 : 2 * parallel_threads());
  for_each_slab(source, options, "errors", [&](const Samples& slab, std::int32_t slices) {
    sink.add_samples(brickwork.layer(slab, slices));
    parts.ranges.add(slab, slices, on_all_threads);
    spectrum.add(slab, slices);
  });
  spectrum.finish();
  parts.coarse = spectrum.coarse_samples();
  return parts;
}

struct Described {
  DatasetInfo info;
  IsovalueBins bins;
};
Described first_pass(VolumeSource& source, const PrepareOptions& options) {
  if (options.bins < 1 || options.bins > IsovalueBins::kMaxCount) {
    throw std::invalid_argument("The number of bins is " + std::to_string(options.bins) +
                                "; it must be 1 to " + std::to_string(IsovalueBins::kMaxCount) +
                                ".");
  }
  const Facts facts = facts_of(source, options);
  DatasetInfo info =
      describe(source.header(), facts.statistics, options.name, options.outside, options.margin);
  IsovalueBins bins = IsovalueBins::for_values(info, facts.distinct_values, options.bins);
  return {std::move(info), std::move(bins)};
}

}  // namespace

DatasetInfo prepare(VolumeSource& source, const PrepareOptions& options,
                    const std::filesystem::path& output, const SourceNote& note) {
  const auto [info, bins] = first_pass(source, options);
  FileSink sink(output, info);
  const SmallParts parts = second_pass(source, options, info, bins, sink);
  sink.writer().finish({.info = info, .source = note, .program_version = MULTITETRA_VERSION},
                       {.coarse = parts.coarse_bytes(),
                        .ranges = parts.ranges.bytes(),
                        .bins = std::as_bytes(std::span(bins.edges()))});
  return info;
}

DatasetPtr prepare_in_memory(VolumeSource& source, const PrepareOptions& options) {
  const auto [info, bins] = first_pass(source, options);
  MemorySink sink(info);
  const auto parts =
      std::make_shared<const SmallParts>(second_pass(source, options, info, bins, sink));
  return std::make_shared<const PreparedVolume>(
      PreparedVolume{.info = info,
                     .samples = sink.samples(),
                     .coarse = parts->coarse_bytes(),
                     .ranges = parts->ranges.bytes(),
                     .spectrum = {.layout = SpectrumLayout(info),
                                  .bins = bins,
                                  .voxel = static_cast<float>(voxel_length(info)),
                                  .bricks = sink.spectrum()},
                     .owner = parts});
}

DatasetPtr make_dataset(Volume volume, std::string name, std::optional<double> outside,
                        std::int32_t margin) {
  return prepare_in_memory(*source_of(std::move(volume)),
                           {.name = std::move(name), .outside = outside, .margin = margin});
}

}  // namespace multitetra
