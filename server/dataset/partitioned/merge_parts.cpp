#include <algorithm>
#include <stdexcept>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/dataset/brick_codec.hpp"
#include "server/dataset/dataset_writer.hpp"
#include "server/dataset/partitioned/detail/bucket_parts.hpp"
#include "server/dataset/partitioned/detail/part_files.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/partitioned/prepare_parts.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/store/http_options.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Copies a box of items from `file` into an array of all of them in `into`.
void put_box(const fs::path& file, const CellBox& box, const LevelExtent& all, std::size_t width,
             ScratchFile& into) {
  const FileSource source(file);
  const GridPoint extent = box.end - box.begin;
  if (std::min({extent.x, extent.y, extent.z}) <= 0) return;
  std::vector<std::byte> row(static_cast<std::size_t>(extent.x) * width);
  std::uint64_t offset = 0;
  for (std::int32_t z = box.begin.z; z < box.end.z; ++z) {
    for (std::int32_t y = box.begin.y; y < box.end.y; ++y, offset += row.size()) {
      source.read(offset, row);
      into.write_at(all.index({box.begin.x, y, z}) * width, row);
    }
  }
}

std::uint64_t bytes_of(const CellBox& box, std::size_t width) {
  const GridPoint extent = box.end - box.begin;
  if (std::min({extent.x, extent.y, extent.z}) <= 0) return 0;
  return width * static_cast<std::uint64_t>(extent.x) * static_cast<std::uint64_t>(extent.y) *
         static_cast<std::uint64_t>(extent.z);
}

class PartMerger {
 public:
  PartMerger(const fs::path& dataset, const PartOptions& options)
      : dataset_(dataset),
        options_(options),
        plan_(plan_of(dataset)),
        info_(plan_.plan.metadata.info),
        width_(static_cast<std::size_t>(bytes_per_sample(info_.type))),
        layout_(info_.dims),
        boxes_(part_boxes(info_.dims, plan_.plan.parts)),
        ranges_(parts_folder(dataset)),
        coarse_(parts_folder(dataset)),
        places_(layout_.size()),
        part_of_(layout_.size()) {}

  DatasetInfo merge() {
    take_parts();
    DatasetWriter writer(dataset_, info_);
    make_spectrum(writer);
    writer.finish(plan_.plan.metadata,
                  {.coarse = SectionBytes(coarse_bytes(info_), coarse_),
                   .ranges = SectionBytes(ranges_bytes(info_), ranges_),
                   .bins = std::as_bytes(std::span(plan_.plan.bins.edges()))},
                  [&](std::size_t brick) { return packed_brick(brick); });
    return info_;
  }

 private:
  static void in_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
    in_parallel(count, body);
  }
  void take_parts() {
    std::string missing;
    for (std::size_t part = 0; part < boxes_.size(); ++part) {
      const fs::path file = part_file(dataset_, part, ".json");
      const auto text = small_text(file);
      if (!text) {
        missing += (missing.empty() ? "" : ", ") + std::to_string(part + 1);
        continue;
      }
      auto record = parse_record(*text);
      if (!record) throw DatasetFileError(file, record.error().text);
      if (record->plan != plan_.id || record->part != part) {
        throw DatasetFileError(file, "it belongs to another plan. Prepare this part again.");
      }
      take(*std::move(record), boxes_[part]);
      if (options_.progress) options_.progress("parts", part + 1, boxes_.size());
    }
    if (missing.empty()) return;
    throw DatasetFileError(parts_folder(dataset_), "missing parts: " + missing + " (of " +
                                                       std::to_string(boxes_.size()) +
                                                       "). Prepare them, then merge.");
  }

  void take(PartRecord record, const PartBox& box) {
    const auto file = [&](const char* suffix) { return part_file(dataset_, record.part, suffix); };
    check_array(file(".index"), record.index);
    check_array(file(".ranges"), record.ranges);
    check_array(file(".coarse"), record.coarse);
    check_array(file(".curves"), record.curves);
    const LevelExtent all_ranges = cell_extent(info_);
    const LevelExtent all_coarse = coarse_extent(info_);
    const CellBox ranges = cells_of_part(info_, box, box_of(all_ranges));
    const CellBox coarse = cells_of_part(info_, box, box_of(all_coarse));
    const CellBox curves = cells_of_part(info_, box, spectrum_cells(info_));
    const std::vector<std::size_t> bricks = bricks_in(layout_, box);
    const bool fits =
        record.ranges.bytes == bytes_of(ranges, 2 * width_) &&
        record.coarse.bytes == bytes_of(coarse, width_) &&
        record.index.bytes == sizeof(BrickEntry) * bricks.size() &&
        (record.cell_curves.tile_ranges.empty() || record.cell_curves.cells == curves);
    if (!fits) {
      throw DatasetFileError(file(".json"),
                             "its size does not match the plan. Prepare this part again.");
    }
    put_box(file(".ranges"), ranges, all_ranges, 2 * width_, ranges_);
    put_box(file(".coarse"), coarse, all_coarse, width_, coarse_);
    take_bricks(record, bricks);
    readers_.push_back(std::make_unique<CurvesReader>(file(".curves")));
    curves_.push_back({std::move(record.cell_curves), readers_.back().get()});
  }

  void take_bricks(const PartRecord& record, const std::vector<std::size_t>& bricks) {
    std::vector<BrickEntry> entries(bricks.size());
    FileSource(part_file(dataset_, record.part, ".index"))
        .read(0, std::as_writable_bytes(std::span(entries)));
    std::uint64_t end = 0;
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      BrickPlace& place = places_[bricks[i]];
      place = {.offset = end,
               .size_and_codec = entries[i].size_and_codec,
               .checksum = entries[i].checksum};
      part_of_[bricks[i]] = static_cast<std::uint16_t>(record.part);
      end += place.size();
    }
    const fs::path file = part_file(dataset_, record.part, ".bricks");
    bricks_.push_back(std::make_unique<FileSource>(file));
    if (bricks_.back()->size() == end && record.bricks.bytes == end) return;
    throw DatasetFileError(file, "its checksum or size does not match. Prepare this part again.");
  }

  // Called from several threads at once.
  [[nodiscard]] PackedBrick packed_brick(std::size_t brick) const {
    const BrickPlace& place = places_[brick];
    PackedBrick packed{.codec = place.codec(), .bytes = std::vector<std::byte>(place.size())};
    bricks_[part_of_[brick]]->read(place.offset, packed.bytes);
    if (brick_checksum(packed.bytes) == place.checksum) return packed;
    throw DatasetFileError(part_file(dataset_, part_of_[brick], ".bricks"),
                           "its checksum or size does not match. Prepare this part again.");
  }

  void make_spectrum(DatasetWriter& writer) {
    ScratchFile scratch(parts_folder(dataset_));
    const CoarseVolume coarse(info_, coarse_);
    const UnreadSamples samples;
    const std::size_t all = SpectrumLayout(info_).size();
    build_spectrum_from(info_, plan_.plan.bins, curves_,
                        {.samples = samples,
                         .coarse = coarse,
                         .scratch = scratch,
                         .for_each = in_threads,
                         .threads = parallel_threads(),
                         .column_bytes = options_.column_bytes,
                         .sink = [&](std::size_t brick, std::span<const std::byte> bytes) {
                           writer.add_spectrum_brick(brick, bytes);
                           if (options_.progress) options_.progress("levels", brick, all);
                         }});
  }

  struct UnreadSamples : SampleBoxes {
    void read(GridPoint, GridPoint, Samples&) const override {
      throw std::logic_error("A merge reads no samples.");
    }
  };

  const fs::path& dataset_;
  const PartOptions& options_;
  const StoredPlan plan_;
  const DatasetInfo& info_;
  const std::size_t width_;
  const BrickLayout layout_;
  const std::vector<PartBox> boxes_;
  ScratchFile ranges_;
  ScratchFile coarse_;
  // Location of each brick in the file of its part.
  std::vector<BrickPlace> places_;
  // Part of each brick.
  std::vector<std::uint16_t> part_of_;
  std::vector<std::unique_ptr<FileSource>> bricks_;  // Indexed by part.
  std::vector<std::unique_ptr<CurvesReader>> readers_;
  std::vector<SavedCurves> curves_;
};

}  // namespace

MergedDataset merge_parts(const fs::path& dataset, const PartOptions& options) {
  if (!is_address(dataset.string())) {
    DatasetInfo info = PartMerger(dataset, options).merge();
    remove_parts(dataset);
    return {.info = std::move(info), .file_bytes = fs::file_size(dataset)};
  }
  const BucketParts parts(dataset);
  parts.fetch_plan();
  parts.fetch_parts();
  MergedDataset merged =
      parts.run([&](const fs::path& file) { return merge_parts(file, options); });
  parts.finish();
  return merged;
}

}  // namespace multitetra
