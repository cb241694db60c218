#include <algorithm>
#include <cassert>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <variant>

#include "common/base/in_parallel.hpp"
#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/cell_ranges.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"
#include "server/dataset/brick_layers.hpp"
#include "server/dataset/bricked_samples.hpp"
#include "server/dataset/partitioned/detail/bucket_parts.hpp"
#include "server/dataset/partitioned/detail/part_files.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/partitioned/prepare_parts.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/store/http_options.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

GridCounts counts_of(GridPoint extent) { return {extent.x, extent.y, extent.z}; }

// Copies the columns from `begin` to `end` of `slices` slices.
void crop(const Samples& slab, const VolumeHeader& header, std::int32_t slices, GridPoint begin,
          GridPoint end, Samples& into) {
  std::visit(
      [&](const auto& from) {
        using Values = std::decay_t<decltype(from)>;
        if (!std::holds_alternative<Values>(into)) into = Values();
        auto& cropped = std::get<Values>(into);
        cropped.clear();
        for (std::int32_t z = 0; z < slices; ++z) {
          for (std::int32_t y = begin.y; y < end.y; ++y) {
            const auto row = from.begin() + std::ptrdiff_t{header.dims[0]} *
                                                (y + std::ptrdiff_t{header.dims[1]} * z);
            cropped.insert(cropped.end(), row + begin.x, row + end.x);
          }
        }
      },
      slab);
}

void in_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
  in_parallel(count, body);
}

// A box of samples, read once from a volume's source and stored in an unnamed temporary file, its
// bricks one after another; with the ranges of its cells and its coarse samples.
class BoxOfVolume : public SampleBoxes, private BrickSink {
 public:
  // Reads the samples from `begin` to `end` (exclusive), at most `slab_bytes` or a slice at a time.
  // Requires a non-empty box within the volume whose lower corner has coordinates that are
  // multiples of 16. Calls `progress` with the samples done and in all. Throws VolumeFileError if
  // the source fails, DatasetFileError if the disk fails.
  BoxOfVolume(VolumeSource& source, const DatasetInfo& info, GridPoint begin, GridPoint end,
              const fs::path& folder, std::size_t slab_bytes,
              const std::function<void(std::uint64_t done, std::uint64_t all)>& progress)
      : begin_(begin),
        folder_(folder),
        file_(folder),
        layout_(counts_of(end - begin)),
        width_(static_cast<std::uint64_t>(bytes_per_sample(info.type))),
        box_info_(with_dims(info, layout_.dims())),
        ranges_file_(folder),
        coarse_file_(folder),
        samples_(layout_.dims(), source.header().type,
                 [this](std::size_t first, std::span<std::byte> bytes) {
                   file_.get(width_ * layout_.offset(layout_.at(first)), bytes);
                 }) {
    const VolumeHeader& whole = source.header();
    VolumeHeader box = whole;
    box.dims = layout_.dims();
    BrickLayers layers(box, *this);
    CellRanges ranges(box_info_, ranges_file_);
    CoarseVolume coarse(box_info_, coarse_file_);
    const std::uint64_t slice_bytes = whole.samples_per_slice() * width_;
    std::int32_t most = BrickLayers::kSlices;
    while (most > 1 && static_cast<std::uint64_t>(most) * slice_bytes > slab_bytes) most /= 2;
    Samples slab;
    Samples cropped;
    for (std::int32_t z = begin.z; z < end.z; z += most) {
      const std::int32_t slices = std::min(most, end.z - z);
      source.read(z, slices, slab);
      crop(slab, whole, slices, begin, end, cropped);
      layers.add(cropped, slices);
      ranges.add(cropped, slices, in_threads);
      coarse.add(cropped, slices);
      progress(box.samples_per_slice() * static_cast<std::uint64_t>(z + slices - begin.z),
               box.samples_per_slice() * static_cast<std::uint64_t>(end.z - begin.z));
    }
  }

  // Reads a box within this one, in the coordinates of the volume.
  void read(GridPoint first, GridPoint extent, Samples& into) const override {
    samples_.read(first - begin_, extent, into);
  }
  // Write the ranges of these cells, or the coarse samples at these points, in the coordinates of
  // the volume. All their samples must be in this box.
  void put_ranges(const CellBox& cells, ArrayWriter& into) const {
    put(ranges_file_, cell_extent(box_info_), cells, 2 * width_, into);
  }
  void put_coarse(const CellBox& points, ArrayWriter& into) const {
    put(coarse_file_, coarse_extent(box_info_), points, width_, into);
  }

 private:
  static DatasetInfo with_dims(DatasetInfo info, const GridCounts& dims) {
    info.dims = dims;
    return info;
  }
  void put(const Scratch& from, const LevelExtent& all, const CellBox& part, std::uint64_t width,
           ArrayWriter& into) const {
    if (part.begin.x >= part.end.x) return;
    std::vector<std::byte> row(width * static_cast<std::size_t>(part.end.x - part.begin.x));
    for (std::int32_t z = part.begin.z; z < part.end.z; ++z) {
      for (std::int32_t y = part.begin.y; y < part.end.y; ++y) {
        const GridPoint here = GridPoint{part.begin.x, y, z} - all.unit_point(begin_);
        from.get(width * all.index(here), row);
        into.add(row);
      }
    }
  }
  void add_samples(std::span<const std::byte> bytes) override { (void)file_.put(bytes); }
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override {
    return std::make_unique<ScratchFile>(folder_);
  }

  GridPoint begin_;
  fs::path folder_;
  ScratchFile file_;
  BrickLayout layout_;
  std::uint64_t width_;
  DatasetInfo box_info_;  // As if the box were the volume.
  ScratchFile ranges_file_;
  ScratchFile coarse_file_;
  BrickedSamples samples_;
};

class PartMaker {
 public:
  PartMaker(VolumeSource& source, const fs::path& dataset, std::size_t part,
            const PartOptions& options)
      : dataset_(dataset),
        options_(options),
        plan_(plan_of(dataset)),
        info_(plan_.plan.metadata.info),
        number_(checked_number(part)),
        box_(part_boxes(info_.dims, plan_.plan.parts)[part]),
        record_() {
    record_.plan = plan_.id;
    record_.part = part;
    check_volume(source.header());
    if (box_.is_empty()) return;
    const PartBox read = with_halo(info_, box_);
    samples_ = std::make_unique<BoxOfVolume>(
        source, info_, read.begin, read.end, parts_folder(dataset), options.slab_bytes,
        [&](std::uint64_t done, std::uint64_t all) { report("samples", done, all); });
  }

  void make() {
    put_bricks();
    put_layers();
    put_curves();
    write_whole(part_file(dataset_, number_, ".json"), record_text(record_));
  }

 private:
  std::size_t checked_number(std::size_t part) const {
    if (part < plan_.plan.parts) return part;
    throw std::invalid_argument("The plan has " + std::to_string(plan_.plan.parts) +
                                " parts, but part " + std::to_string(part + 1) + " was requested.");
  }
  void check_volume(const VolumeHeader& header) const {
    if (header.dims == info_.dims && header.type == info_.type && header.spacing == info_.spacing &&
        header.index_to_world == info_.index_to_world) {
      return;
    }
    throw VolumeFileError("This is not the planned volume: its size, type or position differs.");
  }
  void report(const char* pass, std::uint64_t done, std::uint64_t all) const {
    if (options_.progress) options_.progress(pass, done, all);
  }

  void put_bricks() {
    constexpr std::size_t kBatch = 512;  // Bricks packed at a time.
    ArrayWriter bricks(part_file(dataset_, number_, ".bricks"));
    ArrayWriter index(part_file(dataset_, number_, ".index"));
    const BrickLayout layout(info_.dims);
    const std::vector<std::size_t> numbers = bricks_in(layout, box_);
    std::vector<PackedBrick> packed;
    for (std::size_t done = 0; done < numbers.size(); done += packed.size()) {
      packed.resize(std::min(kBatch, numbers.size() - done));
      in_parallel(packed.size(),
                  [&](std::size_t i) { packed[i] = packed_brick(layout, numbers[done + i]); });
      for (const PackedBrick& brick : packed) {
        const BrickEntry entry{.size_and_codec = size_with_codec(brick.bytes.size(), brick.codec),
                               .checksum = brick_checksum(brick.bytes)};
        bricks.add(brick.bytes);
        index.add(std::as_bytes(std::span(&entry, 1)));
      }
      report("bricks", done + packed.size(), numbers.size());
    }
    record_.bricks = bricks.finish();
    record_.index = index.finish();
  }

  [[nodiscard]] PackedBrick packed_brick(const BrickLayout& layout, std::size_t number) const {
    const GridCounts at = layout.at(number);
    const GridCounts extent = layout.extent(at);
    Samples samples;
    samples_->read(layout.side() * GridPoint{at[0], at[1], at[2]},
                   {extent[0], extent[1], extent[2]}, samples);
    return std::visit(
        [&](const auto& values) {
          for (const auto value : values) check_value(static_cast<double>(value));
          return pack_brick(std::as_bytes(std::span(values)), sizeof(values.front()));
        },
        samples);
  }
  void check_value(double value) const {
    if (!(value < info_.min || value > info_.max)) return;  // Also accepts NaN.
    throw VolumeFileError("This is not the planned volume: it has a sample of " +
                          std::to_string(value) + ", outside the range in the plan.");
  }

  void put_layers() {
    ArrayWriter ranges(part_file(dataset_, number_, ".ranges"));
    ArrayWriter coarse(part_file(dataset_, number_, ".coarse"));
    if (samples_) {
      samples_->put_ranges(cells_of_part(info_, box_, box_of(cell_extent(info_))), ranges);
      samples_->put_coarse(cells_of_part(info_, box_, box_of(coarse_extent(info_))), coarse);
    }
    record_.ranges = ranges.finish();
    record_.coarse = coarse.finish();
  }

  void put_curves() {
    CurvesWriter curves(part_file(dataset_, number_, ".curves"));
    if (!box_.is_empty()) {
      ScratchMemory none;
      const CoarseVolume unused(info_, none);
      std::mutex mutex;  // Guards `done` and the progress.
      std::uint64_t done = 0;
      const auto progress = [&](std::uint64_t more) {
        const std::lock_guard lock(mutex);
        report("errors", done += more, box_.samples());
      };
      const SpectrumWork work = {.samples = *samples_,
                                 .coarse = unused,
                                 .scratch = curves,
                                 .for_each = in_threads,
                                 .threads = parallel_threads(),
                                 .column_bytes = options_.column_bytes,
                                 .sink = nullptr,  // The merge builds the levels that have bricks.
                                 .progress = progress};
      record_.cell_curves = make_cell_curves(info_, plan_.plan.bins, work,
                                             cells_of_part(info_, box_, spectrum_cells(info_)));
    }
    record_.curves = curves.finish();
  }

  const fs::path& dataset_;
  const PartOptions& options_;
  const StoredPlan plan_;
  const DatasetInfo& info_;
  const std::size_t number_;
  const PartBox box_;
  PartRecord record_;
  std::unique_ptr<BoxOfVolume> samples_;
};

}  // namespace

void prepare_part(VolumeSource& source, const fs::path& dataset, std::size_t part,
                  const PartOptions& options) {
  if (!is_address(dataset.string())) {
    PartMaker(source, dataset, part, options).make();
    return;
  }
  const BucketParts parts(dataset);
  parts.fetch_plan();
  parts.run([&](const fs::path& file) { PartMaker(source, file, part, options).make(); });
  parts.send_part(part);
}

}  // namespace multitetra
