#include "server/volume/formats/dicom/dicom_series.hpp"

#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/dicom/detail/dicom_frames.hpp"
#include "server/volume/formats/dicom/detail/dicom_grid.hpp"
#include "server/volume/formats/dicom/detail/dicom_image.hpp"
#include "server/volume/formats/dicom/detail/dicom_segmentation.hpp"
#include "server/volume/formats/dicom/detail/dicom_stack.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSeriesFiles = 100'000;

using Series = std::map<std::string, std::vector<DicomImage>>;

// Returns the image for which a series cannot be read, or null.
const DicomImage* refused_image(const std::vector<DicomImage>& images) {
  const auto found = std::find_if(images.begin(), images.end(),
                                  [](const DicomImage& image) { return !image.refusal.empty(); });
  return found == images.end() ? nullptr : &*found;
}

// "CT, 5 images of 8 x 6, abdomen"
std::string text_of(const std::vector<DicomImage>& images) {
  const DicomImage& first = images.front();
  return first.modality + ", " + counted(images.size(), "image") + " of " + sides_text(first.size) +
         (first.description.empty() ? "" : ", " + first.description) +
         (refused_image(images) == nullptr ? "" : ", cannot be read");
}

std::string list_of(const Series& series) {
  std::string text;
  int number = 0;
  for (const auto& [uid, images] : series) {
    text += (number == 0 ? "" : "; ") + std::to_string(number + 1) + ": " + uid + " (" +
            text_of(images) + ")";
    if (++number == 20) return text + "; ...";
  }
  return text;
}

// Lists the series in `contents`.
std::vector<DicomImage> chosen_series(const fs::path& place, Series& series,
                                      const VolumeChoice& choice, VolumeContents& contents) {
  const std::string& wanted = choice.series;
  if (series.empty()) {
    fail_reading(place, "it has no DICOM images", "Give the folder with the slices of a series");
  }
  int number = 0;
  std::vector<DicomImage>* chosen = nullptr;
  for (auto& [uid, images] : series) {
    const std::string option = std::to_string(++number);
    if (series.size() > 1 && contents.entries.size() < kMaxSourceMembers) {
      contents.entries.push_back({.kind = "series",
                                  .name = uid,
                                  .detail = text_of(images),
                                  .option = "--series " + option});
    }
    const bool is_any = series.size() == 1 || (choice.first && refused_image(images) == nullptr);
    if (wanted.empty() ? is_any && chosen == nullptr : wanted == uid || wanted == option) {
      chosen = &images;
    }
  }
  if (chosen != nullptr) {
    if (const DicomImage* image = refused_image(*chosen)) throw VolumeFileError(image->refusal);
    return std::move(*chosen);
  }
  fail_reading(place,
               wanted.empty()
                   ? "it has " + std::to_string(series.size()) + " series: " + list_of(series)
                   : "it has no series " + wanted + "; there are " + list_of(series),
               "Choose one with --series, by its UID or its number in this list");
}

// Returns "IM--" for "IM-0001-0042".
std::string without_digits(std::string name) {
  std::erase_if(name, [](char c) { return c >= '0' && c <= '9'; });
  return name;
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

class DicomSlices : public StoredSlices {
 public:
  explicit DicomSlices(std::vector<DicomImage> stack) : stack_(std::move(stack)) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = first; i < first + count; ++i) {
      const std::span<const std::byte> samples = frames_.samples(stack_[i]);
      note_padding(stack_[i], samples);
      into = std::copy(samples.begin(), samples.end(), into);
    }
  }

  [[nodiscard]] std::vector<std::string> findings() const override {
    if (!padding_) return {};
    const auto [low, high] = *padding_;
    return {"'" + stack_.front().file.string() + "': samples whose stored number is " +
            shortest_text(low) + (low < high ? " to " + shortest_text(high) : "") +
            " are padding outside of the image (PixelPaddingValue); they are kept as values."};
  }

 private:
  void note_padding(const DicomImage& image, std::span<const std::byte> samples) {
    if (!image.padding || padding_) return;
    const std::size_t width = bytes_of(image.type);
    for (std::size_t at = 0; at + width <= samples.size(); at += width) {
      const double number = number_from(image.type, samples.data() + at);
      if (number < (*image.padding)[0] || number > (*image.padding)[1]) continue;
      padding_ = image.padding;
      return;
    }
  }

  std::vector<DicomImage> stack_;
  DicomFrames frames_;
  std::optional<std::array<double, 2>> padding_;  // Once it occurs.
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
  std::vector<DicomImage> images = chosen_series(place, all, choice, volume.contents);
  if (images.front().segmentation != Segmentation::kNone) {
    StoredVolume labels = open_dicom_segmentation(place, std::move(images), choice);
    labels.contents.entries = std::move(volume.contents.entries);
    return labels;
  }
  const std::vector<DicomImage> stack =
      dicom_stack(place, std::move(images), choice, volume.notices, volume.contents.times);
  const DicomImage& first = stack.front();
  const DicomGrid grid = dicom_grid(place, stack, choice, volume.notices);
  std::vector<std::array<double, 2>> scales;
  for (const DicomImage& image : stack) scales.push_back({image.slope, image.intercept});
  const bool rescale = scales != std::vector(scales.size(), scales.front());

  ImageHeader& header = volume.header;
  header.dims = {first.size[0], first.size[1], static_cast<std::int64_t>(stack.size())};
  header.type = rescale ? StoredType::kF32 : first.type;
  header.components = first.components;
  const bool is_in_patient = first.has_orientation && !first.is_in_own_space;
  header.meaning = {.space = is_in_patient ? WorldSpace::kLps : WorldSpace::kUnnamed,
                    .length_unit = "mm",
                    .value_unit = first.value_unit};
  const auto all_have = [&](bool DicomImage::*fact) {
    return std::all_of(stack.begin(), stack.end(),
                       [&](const DicomImage& image) { return image.*fact; });
  };
  const bool is_rescaled = all_have(&DicomImage::has_rescale);
  header.values.scaling = is_rescaled ? Basis::kStated : Basis::kAssumed;
  if (!all_have(&DicomImage::has_sign)) header.values.sign = Basis::kAssumed;
  const auto unmapped = std::find_if(stack.begin(), stack.end(), [](const DicomImage& image) {
    return !image.mapping_notice.empty();
  });
  if (unmapped != stack.end()) {
    header.contradictions.push_back({Fact::kScaling, unmapped->mapping_notice});
  }
  if (!rescale && first.components == 1) {
    header.slope = first.slope;
    header.intercept = first.intercept;
    header.stored_bits = first.stored_bits;
  }
  set_axes(header, grid.steps, first.has_origin ? stated(grid.origin) : kNotStated);
  mark_assumed(stack, header);
  check_header(place, header);
  const std::size_t numbers = first.frame_bytes() / bytes_of(first.type);
  volume.slices = std::make_unique<DicomSlices>(stack);
  if (rescale) {
    volume.slices = scaled_slices(std::move(volume.slices), first.type, numbers, std::move(scales));
  }
  volume.resampled = grid.resampled;
  return volume;
}

}  // namespace multitetra
