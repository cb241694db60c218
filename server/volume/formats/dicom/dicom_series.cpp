#include "server/volume/formats/dicom/dicom_series.hpp"

#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/dicom/detail/dicom_frames.hpp"
#include "server/volume/formats/dicom/detail/dicom_grid.hpp"
#include "server/volume/formats/dicom/detail/dicom_image.hpp"
#include "server/volume/formats/dicom/detail/dicom_segmentation.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSeriesFiles = 100'000;

using Series = std::map<std::string, std::vector<DicomImage>>;

std::string list_of(const Series& series) {
  std::string text;
  int number = 0;
  for (const auto& [uid, images] : series) {
    const DicomImage& first = images.front();
    text += (number == 0 ? "" : "; ") + std::to_string(number + 1) + ": " + uid + " (" +
            first.modality + ", " + std::to_string(images.size()) + " images of " +
            std::to_string(first.size[0]) + " x " + std::to_string(first.size[1]) +
            (first.description.empty() ? "" : ", " + first.description) + ")";
    if (++number == 20) return text + "; ...";
  }
  return text;
}

std::vector<DicomImage> chosen_series(const fs::path& place, Series& series,
                                      const std::string& wanted) {
  if (series.empty()) {
    fail_reading(place, "it has no DICOM images", "Give the folder with the slices of a series");
  }
  if (wanted.empty() && series.size() == 1) return std::move(series.begin()->second);
  int number = 0;
  for (auto& [uid, images] : series) {
    if (wanted == uid || wanted == std::to_string(++number)) return std::move(images);
  }
  fail_reading(place,
               wanted.empty()
                   ? "it has " + std::to_string(series.size()) + " series: " + list_of(series)
                   : "it has no series " + wanted + "; there are " + list_of(series),
               "Choose one with --series, by its UID or its number in this list");
}

std::string list_of(const std::vector<fs::path>& files) {
  std::string text;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (i == 5) return text + " and " + std::to_string(files.size() - i) + " more";
    text += (i == 0 ? "'" : ", '") + files[i].filename().string() + "'";
  }
  return text;
}

// Returns the files of these images, without duplicates.
std::vector<fs::path> files_of(const std::vector<DicomImage>& images) {
  std::vector<fs::path> files;
  for (const DicomImage& image : images) {
    if (files.empty() || files.back() != image.file) files.push_back(image.file);
  }
  return files;
}

bool are_alike(const DicomImage& a, const DicomImage& b) {
  const double turned = 2 - dot(a.row, b.row) - dot(a.column, b.column);
  const auto is_near = [](double x, double y) { return std::abs(x - y) <= 1e-3 * std::abs(y); };
  return a.size == b.size && a.type == b.type && a.components == b.components && turned < 1e-4 &&
         is_near(a.spacing[0], b.spacing[0]) && is_near(a.spacing[1], b.spacing[1]);
}

// Drops localizers, and images whose size, type, spacing or orientation differs from the majority.
void drop_outliers(const fs::path& place, std::vector<DicomImage>& images,
                   std::vector<std::string>& notices) {
  const auto leave_out = [&](const std::string& what, const auto& stays) {
    const auto first_out = std::stable_partition(images.begin(), images.end(), stays);
    if (first_out == images.end()) return;
    const std::vector<DicomImage> out(first_out, images.end());
    images.erase(first_out, images.end());
    notices.push_back("'" + place.string() + "': " + std::to_string(out.size()) + " images " +
                      what + " are skipped: " + list_of(files_of(out)) + ".");
  };
  const auto is_slice = [](const DicomImage& image) { return !image.is_localizer; };
  if (std::any_of(images.begin(), images.end(), is_slice))
    leave_out("that are localizers", is_slice);
  std::vector<std::pair<DicomImage, std::size_t>> kinds;
  for (const DicomImage& image : images) {
    auto found = std::find_if(kinds.begin(), kinds.end(),
                              [&](const auto& kind) { return are_alike(kind.first, image); });
    if (found == kinds.end()) found = kinds.insert(kinds.end(), {image, 0});
    ++found->second;
    if (kinds.size() > 64) break;
  }
  const auto most_common = std::max_element(
      kinds.begin(), kinds.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (kinds.size() > 1 && 2 * most_common->second <= images.size()) {
    fail_reading(
        place,
        "its images have " + std::to_string(kinds.size()) +
            " sizes, types, spacings or orientations, none of them shared by most images; '" +
            kinds[0].first.file.filename().string() + "' and '" +
            kinds[1].first.file.filename().string() + "' differ",
        "Give a folder with the slices of one volume only");
  }
  const DicomImage model = most_common->first;
  leave_out("of another size, type, spacing or orientation than most",
            [&](const DicomImage& image) { return are_alike(image, model); });
}

// Adds notices about the files, independent of their positions.
void note_origins(const fs::path& place, const std::vector<DicomImage>& images,
                  std::vector<std::string>& notices) {
  std::vector<DicomImage> other_images;
  std::vector<DicomImage> longer;
  const DicomImage& first = images.front();
  for (const DicomImage& image : images) {
    if (image.patient != first.patient || image.study != first.study) other_images.push_back(image);
    if (image.has_excess_bytes && image.frame == 0) longer.push_back(image);
  }
  if (!other_images.empty()) {
    notices.push_back("'" + place.string() + "': " + std::to_string(other_images.size()) +
                      " images of this series are of another patient or study than '" +
                      first.file.filename().string() + "': " + list_of(files_of(other_images)) +
                      ". They are included in the volume.");
  }
  const double skew =
      std::max_element(images.begin(), images.end(), [](const auto& a, const auto& b) {
        return a.skew < b.skew;
      })->skew;
  if (skew > 0) {
    notices.push_back("'" + place.string() +
                      "': the directions of rows and columns are rounded and not at right angles "
                      "(cosine " +
                      shortest_text(std::round(1e4 * skew) / 1e4) + "); they were corrected.");
  }
  if (!longer.empty()) {
    notices.push_back(
        "'" + place.string() +
        "': files have more pixel data than their headers declare; the rest is ignored: " +
        list_of(files_of(longer)) + ".");
  }
}

// "2 mm apart (SliceThickness)"
std::string slice_spacing_text(const DicomImage& image) {
  const std::string source =
      image.slice_spacing == SpacingSource::kSliceThickness  ? "SliceThickness"
      : image.slice_spacing == SpacingSource::kBetweenSlices ? "SpacingBetweenSlices"
                                                             : "no element states their distance";
  return rounded_text(image.spacing[2]) + " mm apart (" + source + ")";
}

// Adds notices about how the images are placed.
void note_places(const fs::path& place, const DicomImage& first,
                 std::vector<std::string>& notices) {
  const auto note = [&](const std::string& text) {
    notices.push_back("'" + place.string() + "': " + text + ".");
  };
  if (first.plane_spacing == SpacingSource::kAtDetector) {
    note(
        "the distance of its columns and rows is that at the detector (ImagerPixelSpacing); in "
        "the patient it is smaller");
  }
  if (first.plane_spacing == SpacingSource::kScannedFilm) {
    note(
        "the distance of its columns and rows is that on the scanned film "
        "(NominalScannedPixelSpacing)");
  }
  if (first.frames > 1 && !first.has_own_place && first.slice_spacing != SpacingSource::kStated) {
    note("its frames have no positions; they are placed " + slice_spacing_text(first));
  }
  if (!first.region_notice.empty()) note(first.region_notice);
  if (first.unused_bits > 0 && first.is_jpeg) {
    note(
        "its header counts bits from another one than its compressed samples have (HighBit); they "
        "are read as decompressed");
  }
  if (first.is_cine) {
    note("its frames follow each other in time (FrameTime); they are stacked as slices");
  }
  if (first.is_projection) {
    note(
        "its frames are images of nuclear medicine that are not reconstructed: no slices of a "
        "volume");
  }
}

// Marks the spacings that no element of the files states.
void mark_assumed(const std::vector<DicomImage>& stack, ImageHeader& header) {
  const DicomImage& first = stack.front();
  if (first.plane_spacing == SpacingSource::kNone) {
    header.geometry.spacing[0] = std::nullopt;
    header.geometry.spacing[1] = std::nullopt;
  }
  const bool is_placed =
      stack.size() > 1 && first.has_position && (first.frames == 1 || first.has_own_place);
  if (!is_placed && first.slice_spacing == SpacingSource::kNone) {
    header.geometry.spacing[2] = std::nullopt;
  }
}

// Returns one image per position, sorted by position: the chosen one if there are several.
std::vector<DicomImage> stacked(const fs::path& place, std::vector<DicomImage> images,
                                const VolumeChoice& choice, std::vector<std::string>& notices,
                                SourceTimes& times) {
  if (!std::all_of(images.begin(), images.end(),
                   [](const DicomImage& image) { return image.has_position; })) {
    notices.push_back("'" + place.string() +
                      "': its slices have no positions; they are placed in the order of their "
                      "numbers, " +
                      slice_spacing_text(images.front()) + ".");
    std::sort(images.begin(), images.end(), [](const DicomImage& a, const DicomImage& b) {
      return std::tie(a.number, a.file, a.frame) < std::tie(b.number, b.file, b.frame);
    });
    const Vec3 normal = cross(images.front().row, images.front().column);
    for (std::size_t i = 0; i < images.size(); ++i) {
      images[i].along = static_cast<double>(i) * images[i].spacing[2];
      for (std::size_t row = 0; row < 3; ++row)
        images[i].position[row] = normal[row] * images[i].along;
    }
    return images;
  }
  std::sort(images.begin(), images.end(), [](const DicomImage& a, const DicomImage& b) {
    return std::tie(a.along, a.number, a.file, a.frame) <
           std::tie(b.along, b.number, b.file, b.frame);
  });
  std::vector<std::vector<DicomImage>> positions;
  for (DicomImage& image : images) {
    constexpr double kSamePlace = 1e-3;  // mm
    if (positions.empty() || image.along - positions.back().front().along > kSamePlace)
      positions.emplace_back();
    positions.back().push_back(std::move(image));
  }
  const std::size_t copies = positions.front().size();
  const bool evenly = std::all_of(positions.begin(), positions.end(),
                                  [&](const auto& at) { return at.size() == copies; });
  std::size_t time = 0;
  if (evenly && copies > 1 && positions.size() > 1) {
    times.count = static_cast<std::int64_t>(copies);
    const FileEntries at_each = {.count = times.count,
                                 .several = "it has " + std::to_string(copies) +
                                            " images at each position, as for several times",
                                 .remedy = kChooseTime};
    time = static_cast<std::size_t>(chosen_entry(place, at_each, choice.time, choice.first));
  } else if (!evenly || copies > 1) {
    std::string names;
    for (const auto& at : positions) {
      for (std::size_t i = 1; i < at.size() && names.size() < 200; ++i) {
        names += (names.empty() ? "" : ", ") + at[i].file.filename().string();
      }
    }
    notices.push_back("'" + place.string() + "': skipped slices at duplicate positions: " + names +
                      ".");
  }
  std::vector<DicomImage> stack;
  for (auto& at : positions) stack.push_back(std::move(at[time]));
  return stack;
}

// Returns "IM--" for "IM-0001-0042".
std::string without_digits(std::string name) {
  std::erase_if(name, [](char c) { return c >= '0' && c <= '9'; });
  return name;
}

class DicomSlices : public StoredSlices {
 public:
  DicomSlices(std::vector<DicomImage> stack, const ImageHeader& header, bool rescale)
      : stack_(std::move(stack)), header_(header), rescale_(rescale) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = first; i < first + count; ++i, into += header_.slice_bytes()) {
      const DicomImage& image = stack_[i];
      const std::span<const std::byte> samples = frames_.samples(image);
      note_padding(image, samples);
      if (rescale_) {
        to_values(image, samples.data(), into);
      } else {
        std::memcpy(into, samples.data(), samples.size());
      }
    }
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    if (!padding_) return {};
    return {"'" + stack_.front().file.string() + "': samples whose stored number is " +
            shortest_text(*padding_) +
            " are padding outside of the image (PixelPaddingValue); they are kept as values."};
  }

 private:
  void note_padding(const DicomImage& image, std::span<const std::byte> samples) {
    if (!image.padding || padding_) return;
    const std::size_t width = bytes_of(image.type);
    for (std::size_t at = 0; at + width <= samples.size(); at += width) {
      if (number_from(image.type, samples.data() + at) != *image.padding) continue;
      padding_ = image.padding;
      return;
    }
  }

  // Converts slices with their own slope to values.
  void to_values(const DicomImage& image, const std::byte* from, std::byte* into) const {
    const std::size_t count = header_.slice_bytes() / sizeof(float);
    with_number_type(image.type, [&]<typename Number>() {
      for (std::size_t i = 0; i < count; ++i) {
        Number number;
        std::memcpy(&number, from + i * sizeof(Number), sizeof(Number));
        const auto value =
            static_cast<float>(image.slope * static_cast<double>(number) + image.intercept);
        std::memcpy(into + i * sizeof(float), &value, sizeof(float));
      }
    });
  }

  std::vector<DicomImage> stack_;
  ImageHeader header_;
  bool rescale_;
  DicomFrames frames_;
  std::optional<double> padding_;  // Once it occurs.
};

}  // namespace

std::vector<fs::path> dicom_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::vector<fs::path> others;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file_name = entry->path().filename().string();
    std::error_code ignored;
    if (file_name.starts_with('.') || file_name == "DICOMDIR" || !entry->is_regular_file(ignored))
      continue;
    if (files.size() >= kMaxSeriesFiles) {
      fail_reading(folder, "it has more than " + std::to_string(kMaxSeriesFiles) + " DICOM files",
                   "Give the folder of one series");
    }
    if (is_dicom(InputFile(entry->path()).beginning(132))) {
      files.push_back(entry->path());
    } else {
      others.push_back(entry->path());
    }
  }
  // A slice truncated before its DICM mark would otherwise be missing silently.
  for (const fs::path& other : others) {
    const bool is_sibling = lower_case(other.extension().string()) == ".dcm" ||
                            (!files.empty() && other.parent_path() == files.front().parent_path() &&
                             without_digits(other.filename().string()) ==
                                 without_digits(files.front().filename().string()));
    if (!is_sibling) continue;
    fail_reading(other, "it is not a DICOM file, or is truncated before its header",
                 "Get a complete copy of the file, or remove it from the series");
  }
  std::sort(files.begin(), files.end());
  return files;
}

StoredVolume open_dicom(const fs::path& place, const std::vector<fs::path>& files,
                        const VolumeChoice& choice) {
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  Series all;
  for (const fs::path& file : files) {
    for (DicomImage& image : dicom_images(file)) {
      std::vector<DicomImage>& series = all[image.series];
      series.push_back(std::move(image));
    }
  }
  StoredVolume volume{.header = {.values = kNumbersAsStored}};
  std::vector<DicomImage> images = chosen_series(place, all, choice.series);
  if (images.front().segmentation != Segmentation::kNone) {
    return open_dicom_segmentation(place, std::move(images), choice);
  }
  note_origins(place, images, volume.notices);
  drop_outliers(place, images, volume.notices);
  note_places(place, images.front(), volume.notices);
  if (images.front().frames > 1 && !images.front().has_own_place &&
      images.front().file != images.back().file) {
    fail_reading(place,
                 "its series has several files whose frames do not have individual positions",
                 "Give one of these files");
  }
  const std::vector<DicomImage> stack =
      stacked(place, std::move(images), choice, volume.notices, volume.contents.times);
  const DicomImage& first = stack.front();
  const DicomGrid grid = dicom_grid(place, stack, choice, volume.notices);
  const bool rescale = std::any_of(stack.begin(), stack.end(), [&](const DicomImage& image) {
    return image.slope != first.slope || image.intercept != first.intercept;
  });

  ImageHeader& header = volume.header;
  header.dims = {first.size[0], first.size[1], static_cast<std::int64_t>(stack.size())};
  header.type = rescale ? StoredType::kF32 : first.type;
  header.components = first.components;
  header.meaning = {.space = first.is_in_own_space ? WorldSpace::kUnnamed : WorldSpace::kLps,
                    .length_unit = "mm",
                    .value_unit = first.value_unit};
  header.values.scaling = first.has_rescale ? Basis::kStated : Basis::kAssumed;
  if (first.has_value_table) {
    header.contradictions.push_back({Fact::kScaling,
                                     "its values are given by a table (ModalityLUTSequence), which "
                                     "is not read; its numbers are "
                                     "read as stored"});
  }
  if (!rescale && first.components == 1) {
    header.slope = first.slope;
    header.intercept = first.intercept;
    header.stored_bits = first.stored_bits;
  }
  set_axes(header, grid.steps, first.has_origin ? stated(grid.origin) : kNotStated);
  mark_assumed(stack, header);
  check_header(place, header);
  volume.slices = std::make_unique<DicomSlices>(stack, header, rescale);
  volume.resampled = grid.resampled;
  return volume;
}

}  // namespace multitetra
