#include "server/dataset/prepare.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "server/core/cell_ranges.hpp"
#include "server/core/plane_sources.hpp"
#include "server/core/spectrum_builder.hpp"
#include "server/core/spectrum_layout.hpp"
#include "server/dataset/bricked_samples.hpp"
#include "server/dataset/dataset_writer.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/dataset/scratch_file.hpp"
#include "server/dataset/statistics.hpp"
#include "server/dataset/statistics_builder.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kLayerSlices = BrickLayout::kSampleSide;

void on_all_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
  in_parallel(count, body);
}

// ---- where a prepared volume goes

class Sink {
 public:
  virtual ~Sink() = default;
  // The next bricks, in order.
  virtual void add_samples(std::span<const std::byte> bytes) = 0;
  // What was added, brick by brick. From several threads at once.
  virtual void read_samples(std::size_t first, std::span<std::byte> bytes) const = 0;
  [[nodiscard]] virtual std::unique_ptr<Scratch> new_scratch() const = 0;
  virtual void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) = 0;
};

class FileSink : public Sink {
 public:
  FileSink(const std::filesystem::path& path, const DatasetInfo& info)
      : writer_(
            path,
            {.dims = info.dims, .type = info.type, .spectrum_bricks = SpectrumLayout(info).size()}),
        folder_(path.parent_path()) {}
  void add_samples(std::span<const std::byte> bytes) override { writer_.add_samples(bytes); }
  void read_samples(std::size_t first, std::span<std::byte> bytes) const override {
    writer_.read_samples(first, bytes);
  }
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override {
    return std::make_unique<ScratchFile>(folder_);
  }
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override {
    writer_.add_spectrum_brick(index, bytes);
  }
  [[nodiscard]] DatasetWriter& writer() { return writer_; }

 private:
  DatasetWriter writer_;
  std::filesystem::path folder_;
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
  void read_samples(std::size_t first, std::span<std::byte> bytes) const override {
    while (!bytes.empty()) {
      const std::span<const std::byte> brick = samples_->brick(first++);
      std::copy(brick.begin(), brick.end(), bytes.begin());
      bytes = bytes.subspan(brick.size());
    }
  }
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override {
    return std::make_unique<ScratchMemory>();
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

// ---- samples into bricks

// Boxes of samples, each a number of whole bricks, in the order of their bricks.
class Brickwork {
 public:
  [[nodiscard]] std::span<const std::byte> bricks(const Samples& box, const GridCounts& dims) {
    std::visit([&](const auto& samples) { rearrange(samples, BrickLayout(dims)); }, box);
    return bytes_;
  }

 private:
  template <typename Sample>
  void rearrange(const std::vector<Sample>& samples, const BrickLayout& box) {
    bytes_.resize(samples.size() * sizeof(Sample));
    in_parallel(static_cast<std::size_t>(box.counts()[1]), [&](std::size_t by) {
      for (std::int32_t bx = 0; bx < box.counts()[0]; ++bx) {
        const GridCounts brick = {bx, static_cast<std::int32_t>(by), 0};
        copy_brick(samples, box, brick, bytes_.data() + box.offset(brick) * sizeof(Sample));
      }
    });
  }
  template <typename Sample>
  static void copy_brick(const std::vector<Sample>& samples, const BrickLayout& box,
                         const GridCounts& brick, std::byte* into) {
    const GridCounts extent = box.extent(brick);
    const std::size_t row_bytes = static_cast<std::size_t>(extent[0]) * sizeof(Sample);
    for (std::int32_t z = 0; z < extent[2]; ++z) {
      for (std::int32_t y = 0; y < extent[1]; ++y, into += row_bytes) {
        const std::ptrdiff_t from = box.side() * brick[0] + std::ptrdiff_t{box.dims()[0]} *
                                                                (box.side() * brick[1] + y +
                                                                 std::ptrdiff_t{box.dims()[1]} * z);
        std::memcpy(into, samples.data() + from, row_bytes);
      }
    }
  }

  std::vector<std::byte> bytes_;
};

// Slices that come a few at a time, in the order of their bricks. Where a layer of bricks is too
// large for one slab it is put aside, and then read in rows of bricks.
class BrickLayers {
 public:
  BrickLayers(const VolumeHeader& header, Sink& sink)
      : dims_(header.dims),
        type_(header.type),
        slice_bytes_(header.samples_per_slice() *
                     static_cast<std::size_t>(bytes_per_sample(type_))),
        sink_(sink) {}

  // The next slices, all of one layer of bricks.
  void add(const Samples& slab, std::int32_t slices) {
    const std::int32_t layer_slices = std::min(kLayerSlices, dims_[2] - layer_begin_);
    if (slices == layer_slices) {
      sink_.add_samples(brickwork_.bricks(slab, {dims_[0], dims_[1], slices}));
      layer_begin_ += slices;
      return;
    }
    if (!scratch_) scratch_ = sink_.new_scratch();
    std::visit(
        [&](const auto& samples) {
          aside_.push_back(scratch_->put(std::as_bytes(std::span(samples))));
        },
        slab);
    slices_aside_.push_back(slices);
    slices_in_layer_ += slices;
    if (slices_in_layer_ == layer_slices) flush();
  }

 private:
  void flush() {
    for (std::int32_t y = 0; y < dims_[1]; y += kLayerSlices) {
      const GridCounts box = {dims_[0], std::min(kLayerSlices, dims_[1] - y), slices_in_layer_};
      visit_type(type_, [&]<typename Sample>(const Sample*) { add_row<Sample>(y, box); });
    }
    layer_begin_ += slices_in_layer_;
    slices_in_layer_ = 0;
    aside_.clear();
    slices_aside_.clear();
    scratch_.reset();
  }
  template <typename Sample>
  void add_row(std::int32_t y, const GridCounts& box) {
    const std::size_t row = static_cast<std::size_t>(box[0]);
    const std::size_t rows = row * static_cast<std::size_t>(box[1]);
    std::vector<Sample> samples(rows * static_cast<std::size_t>(box[2]));
    std::span<Sample> left(samples);
    for (std::size_t i = 0; i < aside_.size(); ++i) {
      for (std::int32_t z = 0; z < slices_aside_[i]; ++z, left = left.subspan(rows)) {
        scratch_->get(aside_[i] + static_cast<std::uint64_t>(z) * slice_bytes_ +
                          static_cast<std::uint64_t>(y) * row * sizeof(Sample),
                      std::as_writable_bytes(left.first(rows)));
      }
    }
    row_ = std::move(samples);
    sink_.add_samples(brickwork_.bricks(row_, box));
  }

  GridCounts dims_;
  SampleType type_;
  std::size_t slice_bytes_;
  Sink& sink_;
  Brickwork brickwork_;
  std::int32_t layer_begin_ = 0;
  std::unique_ptr<Scratch> scratch_;
  std::int32_t slices_in_layer_ = 0;        // Put aside.
  std::vector<std::uint64_t> aside_;        // Where in the scratch.
  std::vector<std::int32_t> slices_aside_;  // How many each time.
  Samples row_;
};

// ---- the two passes

// Calls `visit(slab, slices)` for all slices in order; a slab lies in one layer of bricks.
template <typename Visit>
void for_each_slab(VolumeSource& source, const PrepareOptions& options, const char* pass,
                   const Visit& visit) {
  const VolumeHeader& header = source.header();
  const std::uint64_t slice = header.samples_per_slice();
  const auto all = slice * static_cast<std::uint64_t>(header.dims[2]);
  const std::uint64_t bytes = slice * static_cast<std::uint64_t>(bytes_per_sample(header.type));
  std::int32_t most = kLayerSlices;
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

// The dataset's place in the grid, checked, before anything is known of its values.
DatasetInfo geometry_of(const VolumeHeader& header, const PrepareOptions& options) {
  const std::uint64_t samples =
      header.samples_per_slice() * static_cast<std::uint64_t>(header.dims[2]);
  SampleStatistics any;
  any.histogram = {.low = 0, .high = 1, .counts = {samples}};
  return describe(header, any, options.name, options.outside, options.margin);
}

// What is small, beside what goes to the sink.
struct SmallParts {
  DatasetInfo info;
  std::unique_ptr<Scratch> coarse_scratch;
  std::unique_ptr<Scratch> ranges_scratch;
  CoarseVolume coarse;
  CellRanges ranges;
  std::optional<IsovalueBins> bins = std::nullopt;

  SmallParts(const DatasetInfo& geometry, const Sink& sink)
      : info(geometry),
        coarse_scratch(sink.new_scratch()),
        ranges_scratch(sink.new_scratch()),
        coarse(geometry, *coarse_scratch),
        ranges(geometry, *ranges_scratch) {}
};

SectionBytes section_of(std::uint64_t size, const Scratch& scratch) {
  return {size, [&scratch](std::uint64_t offset, std::span<std::byte> into) {
            scratch.get(offset, into);
          }};
}
std::vector<std::byte> bytes_of(std::uint64_t size, const Scratch& scratch) {
  std::vector<std::byte> bytes(size);
  scratch.get(0, bytes);
  return bytes;
}

// The samples: into the sink, their facts and what is small of them into `parts`.
void first_pass(VolumeSource& source, const PrepareOptions& options, Sink& sink,
                SmallParts& parts) {
  SampleStatisticsBuilder builder(source.header().type);
  BrickLayers bricks(source.header(), sink);
  for_each_slab(source, options, "range", [&](const Samples& slab, std::int32_t slices) {
    builder.add(slab);
    bricks.add(slab, slices);
    parts.ranges.add(slab, slices, on_all_threads);
    parts.coarse.add(slab, slices);
  });
  if (builder.needs_second_pass()) {
    for_each_slab(source, options, "histogram",
                  [&](const Samples& slab, std::int32_t) { builder.add_again(slab); });
  }
  parts.info =
      describe(source.header(), builder.finish(), options.name, options.outside, options.margin);
  parts.bins = IsovalueBins::for_values(parts.info, builder.distinct_values(), options.bins);
}

// The errors, from the samples in the sink.
void second_pass(const PrepareOptions& options, Sink& sink, const SmallParts& parts) {
  const DatasetInfo& info = parts.info;
  const BrickedSamples samples(
      info.dims, info.type,
      [&](std::size_t first, std::span<std::byte> bytes) { sink.read_samples(first, bytes); });
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
      info, *parts.bins,
      {.samples = samples,
       .coarse = parts.coarse,
       .scratch = *scratch,
       .for_each = on_all_threads,
       .threads = parallel_threads(),
       .column_bytes = options.column_bytes,
       .sink = [&](std::size_t brick,
                   std::span<const std::byte> bytes) { sink.add_spectrum_brick(brick, bytes); },
       .progress = progress});
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

DatasetInfo prepare(VolumeSource& source, const PrepareOptions& options,
                    const std::filesystem::path& output, const SourceNote& note) {
  const DatasetInfo geometry = checked_geometry(source, options);
  FileSink sink(output, geometry);
  SmallParts parts(geometry, sink);
  first_pass(source, options, sink, parts);
  second_pass(options, sink, parts);
  sink.writer().finish({.info = parts.info, .source = note, .program_version = MULTITETRA_VERSION},
                       {.coarse = section_of(parts.coarse.bytes(), *parts.coarse_scratch),
                        .ranges = section_of(parts.ranges.bytes(), *parts.ranges_scratch),
                        .bins = std::as_bytes(std::span(parts.bins->edges()))});
  return parts.info;
}

DatasetPtr prepare_in_memory(VolumeSource& source, const PrepareOptions& options) {
  const DatasetInfo geometry = checked_geometry(source, options);
  MemorySink sink(geometry);
  SmallParts parts(geometry, sink);
  first_pass(source, options, sink, parts);
  second_pass(options, sink, parts);
  struct Kept {
    std::vector<std::byte> coarse;
    std::vector<std::byte> ranges;
  };
  const auto kept = std::make_shared<const Kept>(
      Kept{.coarse = bytes_of(parts.coarse.bytes(), *parts.coarse_scratch),
           .ranges = bytes_of(parts.ranges.bytes(), *parts.ranges_scratch)});
  return std::make_shared<const PreparedVolume>(
      PreparedVolume{.info = parts.info,
                     .samples = sink.samples(),
                     .coarse = kept->coarse,
                     .ranges = kept->ranges,
                     .spectrum = {.layout = SpectrumLayout(parts.info),
                                  .bins = *parts.bins,
                                  .voxel = static_cast<float>(voxel_length(parts.info)),
                                  .bricks = sink.spectrum()},
                     .owner = kept});
}

DatasetPtr make_dataset(Volume volume, std::string name, std::optional<double> outside,
                        std::int32_t margin) {
  return prepare_in_memory(*source_of(std::move(volume)),
                           {.name = std::move(name), .outside = outside, .margin = margin});
}

}  // namespace multitetra
