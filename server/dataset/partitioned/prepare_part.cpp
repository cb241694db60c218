#include <mutex>
#include <stdexcept>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/cell_layers.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/dataset/box_of_volume.hpp"
#include "server/dataset/partitioned/detail/part_files.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/partitioned/prepare_parts.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

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
        source, read.begin, read.end,
        BoxOfVolume::Options{.folder = parts_folder(dataset),
                             .slab_bytes = options.slab_bytes,
                             .progress = [&](std::uint64_t done, std::uint64_t all) {
                               report("samples", done, all);
                             }});
  }

  void make() {
    put_bricks();
    put_layers();
    put_curves();
    write_whole(part_file(dataset_, number_, ".json"), record_text(record_));
  }

 private:
  static void in_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
    in_parallel(count, body);
  }
  std::size_t checked_number(std::size_t part) const {
    if (part < plan_.plan.parts) return part;
    throw std::invalid_argument("The plan has " + std::to_string(plan_.plan.parts) +
                                " parts, and part " + std::to_string(part + 1) + " is asked for.");
  }
  void check_volume(const VolumeHeader& header) const {
    if (header.dims == info_.dims && header.type == info_.type && header.spacing == info_.spacing &&
        header.index_to_world == info_.index_to_world) {
      return;
    }
    throw VolumeFileError(
        "The volume is another one than was planned: sizes, type or place differ.");
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
    throw VolumeFileError("The volume is another one than was planned: it has a sample of " +
                          std::to_string(value) + ", beyond the range that was found.");
  }

  void put_layers() {
    ArrayWriter ranges(part_file(dataset_, number_, ".ranges"));
    ArrayWriter coarse(part_file(dataset_, number_, ".coarse"));
    const CellBox cells = cells_of_part(info_, box_, box_of(cell_extent(info_)));
    for (std::int32_t z = cells.begin.z; z < cells.end.z; ++z) {
      ranges.add(ranges_of_layer(info_, *samples_, cells, z, in_threads));
    }
    const CellBox points = cells_of_part(info_, box_, box_of(coarse_extent(info_)));
    for (std::int32_t z = points.begin.z; z < points.end.z; ++z) {
      coarse.add(coarse_of_layer(info_, *samples_, points, z, in_threads));
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
  PartMaker(source, dataset, part, options).make();
}

}  // namespace multitetra
