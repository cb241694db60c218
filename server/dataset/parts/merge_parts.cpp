#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/cell_layers.hpp"
#include "server/core/spectrum/plane_sources.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/dataset/objects/object_folder.hpp"
#include "server/dataset/objects/object_layout.hpp"
#include "server/dataset/objects/object_structure.hpp"
#include "server/dataset/parts/part_files.hpp"
#include "server/dataset/parts/part_plan.hpp"
#include "server/dataset/parts/prepare_parts.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using namespace section_names;

// Rows of a box of items into an array of all of them, which lies in a file.
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
      into.put_at(all.index({box.begin.x, y, z}) * width, row);
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
  PartMerger(const fs::path& folder, const PartOptions& options)
      : folder_(folder),
        options_(options),
        plan_(plan_in(folder)),
        info_(plan_.plan.metadata.info),
        width_(static_cast<std::size_t>(bytes_per_sample(info_.type))),
        objects_(info_.dims, info_.type),
        boxes_(part_boxes(info_.dims, plan_.plan.parts)),
        ranges_(parts_folder(folder)),
        coarse_(parts_folder(folder)),
        spectrum_(parts_folder(folder)),
        sums_(objects_.bricks().size()),
        names_(objects_.size()),
        index_(SpectrumLayout(info_).size()) {}

  ConvertedObjects merge() {
    take_parts();
    make_spectrum();
    return write();
  }

 private:
  static void in_threads(std::size_t count, const std::function<void(std::size_t)>& body) {
    in_parallel(count, body);
  }
  void take_parts() {
    std::string missing;
    for (std::size_t part = 0; part < boxes_.size(); ++part) {
      const fs::path file = part_file(folder_, part, ".json");
      const auto text = small_text(file);
      if (!text) {
        missing += (missing.empty() ? "" : ", ") + std::to_string(part + 1);
        continue;
      }
      auto record = parse_record(*text);
      if (!record) throw DatasetFileError(file, record.error().text);
      if (record->plan != plan_.id || record->part != part) {
        throw DatasetFileError(file, "it is of another plan. Prepare this part again.");
      }
      take(*std::move(record), boxes_[part]);
      if (options_.progress) options_.progress("parts", part + 1, boxes_.size());
    }
    if (missing.empty()) return;
    throw DatasetFileError(folder_, "of the " + std::to_string(boxes_.size()) +
                                        " parts these are not there: " + missing +
                                        ". Prepare them, then merge.");
  }

  void take(PartRecord record, const PartBox& box) {
    const auto file = [&](const char* suffix) { return part_file(folder_, record.part, suffix); };
    check_array(file(".sums"), record.sums);
    check_array(file(".ranges"), record.ranges);
    check_array(file(".coarse"), record.coarse);
    check_array(file(".curves"), record.curves);
    const LevelExtent all_ranges = cell_extent(info_);
    const LevelExtent all_coarse = coarse_extent(info_);
    const CellBox ranges = cells_of_part(info_, box, box_of(all_ranges));
    const CellBox coarse = cells_of_part(info_, box, box_of(all_coarse));
    const CellBox curves = cells_of_part(info_, box, spectrum_cells(info_));
    const std::vector<std::size_t> objects = objects_in(objects_, box);
    std::vector<std::size_t> bricks;
    for (const std::size_t object : objects) {
      const std::vector<std::size_t> more = objects_.bricks_of(object);
      bricks.insert(bricks.end(), more.begin(), more.end());
    }
    const bool fits = record.ranges.bytes == bytes_of(ranges, 2 * width_) &&
                      record.coarse.bytes == bytes_of(coarse, width_) &&
                      record.sums.bytes == sizeof(std::uint64_t) * bricks.size() &&
                      record.objects.size() == objects.size() &&
                      (record.cell_curves.places.empty() || record.cell_curves.cells == curves);
    if (!fits) {
      throw DatasetFileError(file(".json"),
                             "it has more or less than its part of the plan. Prepare it again.");
    }
    put_box(file(".ranges"), ranges, all_ranges, 2 * width_, ranges_);
    put_box(file(".coarse"), coarse, all_coarse, width_, coarse_);
    std::vector<std::uint64_t> sums(bricks.size());
    FileSource(file(".sums")).read(0, std::as_writable_bytes(std::span(sums)));
    for (std::size_t i = 0; i < bricks.size(); ++i) sums_[bricks[i]] = sums[i];
    for (std::size_t i = 0; i < objects.size(); ++i) {
      names_[objects[i]] = record.objects[i];
      check_object(record.objects[i], objects_.bytes_of(objects[i]));
    }
    readers_.push_back(std::make_unique<CurvesReader>(file(".curves")));
    curves_.push_back({std::move(record.cell_curves), readers_.back().get()});
  }
  // That it is there; what is in it was looked at when it was written.
  void check_object(const ObjectName& name, std::uint64_t bytes) const {
    std::error_code missing;
    const fs::path file = folder_ / name.key();
    if (name.size == bytes && fs::file_size(file, missing) == bytes && !missing) return;
    throw DatasetFileError(file, "the object of a part is missing. Prepare the part again.");
  }

  void make_spectrum() {
    ScratchFile scratch(parts_folder(folder_));
    const CoarseVolume coarse(info_, coarse_);
    const BoxesNobodyReads samples;
    std::uint64_t offset = 0;
    build_spectrum_from(info_, plan_.plan.bins, curves_,
                        {.samples = samples,
                         .coarse = coarse,
                         .scratch = scratch,
                         .for_each = in_threads,
                         .threads = parallel_threads(),
                         .column_bytes = options_.column_bytes,
                         .sink = [&](std::size_t brick, std::span<const std::byte> bytes) {
                           index_[brick] = {.offset = offset,
                                            .size = static_cast<std::uint32_t>(bytes.size()),
                                            .checksum = checksum(bytes)};
                           spectrum_.put_at(offset, bytes);
                           offset += bytes.size();
                           if (options_.progress) options_.progress("levels", brick, index_.size());
                         }});
    spectrum_bytes_ = offset;
  }

  ConvertedObjects write() {
    const ObjectFolder folder(folder_);
    const std::vector<ObjectName> spectrum = put_spectrum(folder);
    const std::string metadata = metadata_text(plan_.plan.metadata);
    Manifest manifest = {.content_id = {}, .sections = {}, .first = {}, .later = {}};
    RunWriter first(folder);
    RunWriter later(folder);
    SectionTable& sections = manifest.sections;
    const auto place = [&](const char* name, std::uint64_t size, std::uint64_t sum) {
      const std::uint64_t end =
          sections.empty() ? kHeadBytes : sections.back().offset + sections.back().size;
      sections.push_back(
          {.name = name, .offset = section_begin(end), .size = size, .checksum = sum});
    };
    const auto edges = std::as_bytes(std::span(plan_.plan.bins.edges()));
    const auto sums = std::as_bytes(std::span(sums_));
    const auto index = std::as_bytes(std::span(index_));
    const auto text = std::as_bytes(std::span(metadata));
    first.add(text);
    first.add(edges);
    first.add(index);
    first.add(multitetra::bytes_of(std::span<const ObjectName>(spectrum)));
    const std::uint64_t coarse_sum =
        add_array(coarse_, width_ * coarse_extent(info_).size(), first);
    later.add(multitetra::bytes_of(std::span<const ObjectName>(names_)));
    later.add(sums);
    const std::uint64_t ranges_sum =
        add_array(ranges_, 2 * width_ * cell_extent(info_).size(), later);
    // In the order in which one process writes them.
    std::uint64_t sample_bytes = width_;
    for (const std::int32_t side : info_.dims) sample_bytes *= static_cast<std::uint64_t>(side);
    place(kSamples, sample_bytes, 0);
    place(kSpectrum, spectrum_bytes_, 0);
    place(kCoarse, width_ * coarse_extent(info_).size(), coarse_sum);
    place(kRanges, 2 * width_ * cell_extent(info_).size(), ranges_sum);
    place(kBins, edges.size(), checksum(edges));
    place(kSampleChecksums, sums.size(), checksum(sums));
    place(kSpectrumIndex, index.size(), checksum(index));
    place(kMetadata, text.size(), checksum(text));
    manifest.first = first.finish();
    manifest.later = later.finish();
    manifest.content_id = content_id_text(sections);
    folder.finish(manifest);
    return told(manifest, spectrum);
  }

  std::vector<ObjectName> put_spectrum(const ObjectFolder& folder) const {
    const SpectrumObjects objects(info_, index_);
    std::vector<ObjectName> names;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      std::vector<std::byte> object;
      for (const std::size_t brick : objects.bricks_of(i)) {
        const std::size_t begin = object.size();
        object.resize(begin + index_[brick].size);
        spectrum_.get(index_[brick].offset, std::span(object).subspan(begin));
      }
      names.push_back(folder.put(object));
    }
    return names;
  }

  static std::uint64_t add_array(const ScratchFile& array, std::uint64_t bytes, RunWriter& run) {
    RunningChecksum sum;
    std::vector<std::byte> portion;
    for (std::uint64_t done = 0; done < bytes; done += portion.size()) {
      portion.resize(std::min<std::uint64_t>(kRunObjectBytes, bytes - done));
      array.get(done, portion);
      sum.add(portion);
      run.add(portion);
    }
    return sum.value();
  }

  [[nodiscard]] ConvertedObjects told(const Manifest& manifest,
                                      const std::vector<ObjectName>& spectrum) const {
    std::set<ObjectName> all(names_.begin(), names_.end());
    all.insert(spectrum.begin(), spectrum.end());
    all.insert(manifest.first.objects.begin(), manifest.first.objects.end());
    all.insert(manifest.later.objects.begin(), manifest.later.objects.end());
    ConvertedObjects converted{.objects = all.size()};
    for (const ObjectName& name : all) converted.bytes += name.size;
    return converted;
  }

  struct BoxesNobodyReads : SampleBoxes {
    void read(GridPoint, GridPoint, Samples&) const override {
      throw std::logic_error("A merge reads no samples.");
    }
  };

  const fs::path& folder_;
  const PartOptions& options_;
  const KnownPlan plan_;
  const DatasetInfo& info_;
  const std::size_t width_;
  const SampleObjects objects_;
  const std::vector<PartBox> boxes_;
  ScratchFile ranges_;
  ScratchFile coarse_;
  ScratchFile spectrum_;
  std::uint64_t spectrum_bytes_ = 0;
  std::vector<std::uint64_t> sums_;
  std::vector<ObjectName> names_;
  std::vector<BrickPlace> index_;
  std::vector<std::unique_ptr<CurvesReader>> readers_;
  std::vector<KeptCurves> curves_;
};

}  // namespace

std::vector<std::size_t> missing_parts(const fs::path& folder) {
  const KnownPlan known = plan_in(folder);
  std::vector<std::size_t> missing;
  for (std::size_t part = 0; part < known.plan.parts; ++part) {
    const auto text = small_text(part_file(folder, part, ".json"));
    const auto record = text ? parse_record(*text) : fail(ErrorCode::kUnknown, "");
    if (!record || record->plan != known.id) missing.push_back(part);
  }
  return missing;
}

ConvertedObjects merge_parts(const fs::path& folder, const PartOptions& options) {
  const ConvertedObjects converted = PartMerger(folder, options).merge();
  std::error_code ignored;  // What stays harms nobody.
  fs::remove_all(parts_folder(folder), ignored);
  return converted;
}

}  // namespace multitetra
