#include "server/volume/formats/dicom_series.hpp"

#include <gdcmImageReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/dicom_image.hpp"
#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 100'000;
constexpr double kEvenly = 0.01;  // Of the distance of slices: how far one may be from its place.

using Series = std::map<std::string, std::vector<DicomImage>>;

std::string list_of(const Series& series) {
  std::string text;
  int number = 0;
  for (const auto& [uid, images] : series) {
    const DicomImage& first = images.front();
    text += (number == 0 ? "" : "; ") + std::to_string(number + 1) + ": " + uid + " (" +
            first.modality + ", " + std::to_string(images.size()) + " files of " +
            std::to_string(first.dims[0]) + " x " + std::to_string(first.dims[1]) +
            (first.description.empty() ? "" : ", " + first.description) + ")";
    if (++number == 20) return text + "; ...";
  }
  return text;
}

std::vector<DicomImage> chosen_series(const fs::path& place, Series& series,
                                      const std::string& wanted) {
  if (series.empty()) {
    fail_reading(place, "there are no DICOM images",
                 "Give the folder that has the slices of a series");
  }
  if (wanted.empty() && series.size() == 1) return std::move(series.begin()->second);
  int number = 0;
  for (auto& [uid, images] : series) {
    if (wanted == uid || wanted == std::to_string(++number)) return std::move(images);
  }
  fail_reading(place,
               wanted.empty()
                   ? "it holds " + std::to_string(series.size()) + " series: " + list_of(series)
                   : "it has no series " + wanted + "; there are " + list_of(series),
               "Choose one with --series, by its UID or its number in this list");
}

void require_alike(const std::vector<DicomImage>& images) {
  const DicomImage& first = images.front();
  for (const DicomImage& image : images) {
    const double turned = 2 - dot(image.row, first.row) - dot(image.column, first.column);
    if (image.dims == first.dims && image.type == first.type &&
        image.components == first.components && turned < 1e-4) {
      continue;
    }
    fail_reading(image.file,
                 "its size, type or orientation is not that of '" + first.file.filename().string() +
                     "' in the same series",
                 "Give a folder with the slices of one volume only");
  }
}

// One image for each position, sorted by it: of several at each position the chosen one.
std::vector<DicomImage> stacked(const fs::path& place, std::vector<DicomImage> images,
                                const VolumeChoice& choice, std::vector<std::string>& notices,
                                SourceTimes& times) {
  if (!std::all_of(images.begin(), images.end(),
                   [](const DicomImage& image) { return image.has_position; })) {
    notices.push_back(
        "'" + place.string() +
        "': its slices have no positions; they are taken in the order of their numbers, one "
        "slice spacing apart.");
    std::sort(images.begin(), images.end(), [](const DicomImage& a, const DicomImage& b) {
      return std::pair(a.number, a.file) < std::pair(b.number, b.file);
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
    return std::tuple(a.along, a.number, a.file) < std::tuple(b.along, b.number, b.file);
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
    if (!choice.time && !choice.first) {
      fail_reading(
          place,
          "it has " + std::to_string(copies) + " images at each position, as for several times",
          "Choose one with --time, from 0 on, or prepare them with --all-times");
    }
    const std::int64_t chosen = choice.time.value_or(0);
    if (chosen < 0 || chosen >= times.count) {
      fail_reading(place, "it has no time " + std::to_string(chosen),
                   "Choose 0 to " + std::to_string(copies - 1));
    }
    time = static_cast<std::size_t>(chosen);
  } else if (!evenly || copies > 1) {
    std::string names;
    for (const auto& at : positions) {
      for (std::size_t i = 1; i < at.size() && names.size() < 200; ++i) {
        names += (names.empty() ? "" : ", ") + at[i].file.filename().string();
      }
    }
    notices.push_back("'" + place.string() +
                      "': slices that lie where another one does are left out: " + names + ".");
  }
  std::vector<DicomImage> stack;
  for (auto& at : positions) stack.push_back(std::move(at[time]));
  return stack;
}

// The step from slice to slice. Throws when they are not evenly spaced.
Vec3 slice_step(const fs::path& place, const std::vector<DicomImage>& stack) {
  const DicomImage& first = stack.front();
  const Vec3 normal = cross(first.row, first.column);
  Vec3 step{};
  if (stack.size() == 1) {
    for (std::size_t row = 0; row < 3; ++row) step[row] = normal[row] * first.spacing[2];
    return step;
  }
  std::vector<double> gaps;
  for (std::size_t i = 1; i < stack.size(); ++i)
    gaps.push_back(stack[i].along - stack[i - 1].along);
  std::vector<double> sorted = gaps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double usual = sorted[sorted.size() / 2];
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (std::abs(gaps[i] - usual) <= kEvenly * usual) continue;
    const double missing = std::round(gaps[i] / usual) - 1;
    fail_reading(
        place,
        "between '" + stack[i].file.filename().string() + "' and '" +
            stack[i + 1].file.filename().string() + "' are " + std::to_string(gaps[i]) +
            " mm, and " + std::to_string(usual) + " mm between most slices" +
            (missing >= 1 ? "; " + std::to_string(static_cast<int>(std::min(missing, 1e6))) +
                                " seem to be missing"
                          : ""),
        "Get all slices, or resample the series to even distances");
  }
  for (std::size_t row = 0; row < 3; ++row) {
    step[row] =
        (stack.back().position[row] - first.position[row]) / static_cast<double>(stack.size() - 1);
  }
  return step;
}

class DicomSlices : public StoredSlices {
 public:
  DicomSlices(std::vector<DicomImage> stack, const ImageHeader& header, bool rescale)
      : stack_(std::move(stack)), header_(header), rescale_(rescale) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    for (std::size_t i = first; i < first + count; ++i, into += header_.slice_bytes()) {
      const auto frames = static_cast<std::size_t>(stack_.front().dims[2]);
      load(i / frames);
      const std::size_t frame_bytes = pixels_.size() / frames;
      const std::byte* const frame = pixels_.data() + i % frames * frame_bytes;
      if (rescale_) {
        to_values(stack_[i / frames], frame, into);
      } else {
        std::memcpy(into, frame, frame_bytes);
      }
    }
  }

 private:
  void load(std::size_t index) {
    if (loaded_ == index) return;
    const DicomImage& image = stack_[index];
    gdcm::ImageReader reader;
    reader.SetFileName(image.file.c_str());
    if (!reader.Read()) {
      fail_reading(image.file, "its image cannot be read",
                   "Get a whole copy of it, or decompress it first");
    }
    const gdcm::Image& pixels = reader.GetImage();
    const std::size_t needed =
        static_cast<std::size_t>(image.dims[0] * image.dims[1] * image.dims[2] * image.components) *
        bytes_of(image.type);
    if (pixels.GetBufferLength() != needed || dicom_type(pixels.GetPixelFormat()) != image.type) {
      fail_reading(image.file,
                   "its image has " + std::to_string(pixels.GetBufferLength()) +
                       " bytes and its header promises " + std::to_string(needed),
                   "Get a whole copy of it");
    }
    pixels_.resize(needed);
    loaded_ = ~std::size_t{0};
    if (!pixels.GetBuffer(reinterpret_cast<char*>(pixels_.data()))) {
      fail_reading(image.file, "its pixels cannot be unpacked",
                   "Decompress it first, for example with gdcmconv --raw");
    }
    loaded_ = index;
  }

  // Slices with a slope of their own become values.
  void to_values(const DicomImage& image, const std::byte* from, std::byte* into) const {
    const auto each = [&]<typename Number>(Number) {
      const std::size_t count = header_.slice_bytes() / sizeof(float);
      for (std::size_t i = 0; i < count; ++i) {
        Number number;
        std::memcpy(&number, from + i * sizeof(Number), sizeof(Number));
        const auto value =
            static_cast<float>(image.slope * static_cast<double>(number) + image.intercept);
        std::memcpy(into + i * sizeof(float), &value, sizeof(float));
      }
    };
    with_number_type(image.type, [&]<typename Number>() { each(Number{}); });
  }

  std::vector<DicomImage> stack_;
  ImageHeader header_;
  bool rescale_;
  std::size_t loaded_ = ~std::size_t{0};
  std::vector<std::byte> pixels_;
};

}  // namespace

bool is_dicom(std::string_view beginning) {
  return beginning.size() >= 132 && beginning.substr(128, 4) == "DICM";
}

std::vector<fs::path> dicom_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file_name = entry->path().filename().string();
    std::error_code ignored;
    if (file_name.starts_with('.') || file_name == "DICOMDIR" || !entry->is_regular_file(ignored))
      continue;
    if (files.size() >= kMostFiles) {
      fail_reading(folder, "it holds more than " + std::to_string(kMostFiles) + " DICOM files",
                   "Give the folder of one series");
    }
    if (is_dicom(InputFile(entry->path()).beginning(132))) files.push_back(entry->path());
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
    if (auto image = dicom_image(file)) all[image->series].push_back(*std::move(image));
  }
  StoredVolume volume;
  std::vector<DicomImage> images = chosen_series(place, all, choice.series);
  require_alike(images);
  if (images.front().dims[2] > 1 && images.size() > 1) {
    fail_reading(place, "its series has several files of several frames each",
                 "Give one of these files");
  }
  const std::vector<DicomImage> stack =
      stacked(place, std::move(images), choice, volume.notices, volume.members.times);
  const DicomImage& first = stack.front();
  const auto differs = [&](const DicomImage& image) {
    return image.slope != first.slope || image.intercept != first.intercept;
  };
  const bool rescale = std::any_of(stack.begin(), stack.end(), differs);

  ImageHeader& header = volume.header;
  header.dims = {first.dims[0], first.dims[1],
                 first.dims[2] * static_cast<std::int64_t>(stack.size())};
  header.type = rescale ? StoredType::kF32 : first.type;
  header.components = first.components;
  header.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = first.value_unit};
  if (!rescale && first.components == 1) {
    header.slope = first.slope;
    header.intercept = first.intercept;
    header.stored_bits = first.stored_bits;
  }
  std::array<Vec3, 3> steps = {first.row, first.column, slice_step(place, stack)};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (double& part : steps[axis]) part *= first.spacing[axis];
  }
  set_axes(place, header, steps, first.position);
  check_header(place, header);
  const ImageHeader known = header;
  volume.slices = std::make_unique<DicomSlices>(stack, known, rescale);
  return volume;
}

}  // namespace multitetra
