#include "server/volume/formats/dicom/detail/dicom_stack.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "common/base/number_text.hpp"
#include "common/base/vec3.hpp"
#include "server/volume/formats/dicom/detail/dicom_moments.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

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
    notices.push_back("'" + place.string() + "': " + counted(out.size(), "image") + " " + what +
                      (out.size() == 1 ? " is" : " are") + " skipped: " + list_of(files_of(out)) +
                      ".");
  };
  const auto is_slice = [](const DicomImage& image) { return !image.is_localizer; };
  if (std::any_of(images.begin(), images.end(), is_slice)) leave_out("of a localizer", is_slice);
  const auto is_placed = [](const DicomImage& image) { return image.has_position; };
  if (2 * std::count_if(images.begin(), images.end(), is_placed) > std::ssize(images))
    leave_out("without a position", is_placed);
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
    notices.push_back("'" + place.string() + "': the volume includes " +
                      counted(other_images.size(), "image") +
                      " of another patient or study than '" + first.file.filename().string() +
                      "': " + list_of(files_of(other_images)) + ".");
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

// Adds notices about what holds for the images of a volume, or for some of them.
void note_places(const fs::path& place, const std::vector<DicomImage>& stack,
                 std::vector<std::string>& notices) {
  const auto note_if = [&](const auto& holds, const auto& text_of) {
    const auto found = std::find_if(stack.begin(), stack.end(), holds);
    if (found == stack.end()) return;
    notices.push_back("'" + place.string() + "': " + text_of(*found) + ".");
  };
  const auto note = [&](const auto& holds, const std::string& text) {
    note_if(holds, [&](const DicomImage&) { return text; });
  };
  using Image = const DicomImage&;
  note([](Image image) { return image.plane_spacing == SpacingSource::kAtDetector; },
       "the distance of its columns and rows is that at the detector (ImagerPixelSpacing); in the "
       "patient it is smaller");
  note([](Image image) { return image.plane_spacing == SpacingSource::kScannedFilm; },
       "the distance of its columns and rows is that on the scanned film "
       "(NominalScannedPixelSpacing)");
  note_if(
      [](Image image) {
        return image.frames > 1 && !image.has_own_place && image.has_position &&
               image.slice_spacing != SpacingSource::kStated;
      },
      [](Image image) {
        return "its frames have no positions; they are placed " + slice_spacing_text(image);
      });
  note([](Image image) { return !image.has_orientation; },
       "its slices state no orientation; rows are taken along x, columns along y");
  note([](Image image) { return image.is_ybr; },
       "its components are luminance and two color differences (YBR_FULL), not red, green and "
       "blue");
  note_if([](Image image) { return !image.region_notice.empty(); },
          [](Image image) { return image.region_notice; });
  note([](Image image) { return image.unused_bits > 0 && image.is_jpeg; },
       "its header counts bits from another one than its compressed samples have (HighBit); they "
       "are read as decompressed");
  note([](Image image) { return image.is_cine; },
       "its frames follow each other in time (FrameTime); they are stacked as slices");
  note([](Image image) { return image.is_projection; },
       "its frames are images of nuclear medicine that are not reconstructed: no slices of a "
       "volume");
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
  DicomPositions positions;
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
  std::optional<std::vector<DicomImage>> of_one_moment;
  if (evenly && copies > 1 && positions.size() > 1) {
    const std::string same = order_by_moment(positions);
    if (!same.empty()) notices.push_back("'" + place.string() + "': " + same + ".");
    times.count = static_cast<std::int64_t>(copies);
    const FileEntries at_each = {.count = times.count,
                                 .several = "it has " + std::to_string(copies) +
                                            " images at each position, as for several times",
                                 .remedy = kChooseTime};
    time = static_cast<std::size_t>(chosen_entry(place, at_each, choice.time, choice.first));
  } else if (!evenly || copies > 1) {
    of_one_moment = images_of_one_moment(positions);
    std::string names;
    for (const auto& at : positions) {
      for (std::size_t i = 1; i < at.size() && names.size() < 200; ++i) {
        names += (names.empty() ? "" : ", ") + at[i].file.filename().string();
      }
    }
    notices.push_back("'" + place.string() + "': skipped slices at duplicate positions: " + names +
                      ".");
  }
  if (of_one_moment) return *std::move(of_one_moment);
  std::vector<DicomImage> stack;
  for (auto& at : positions) stack.push_back(std::move(at[time]));
  const std::string alternation = alternation_in(stack);
  if (!alternation.empty()) notices.push_back("'" + place.string() + "': " + alternation + ".");
  return stack;
}

}  // namespace

std::vector<DicomImage> dicom_stack(const fs::path& place, std::vector<DicomImage> images,
                                    const VolumeChoice& choice, std::vector<std::string>& notices,
                                    SourceTimes& times) {
  note_origins(place, images, notices);
  drop_outliers(place, images, notices);
  note_places(place, images, notices);
  const DicomImage& first = images.front();
  if (first.frames > 1 && !first.has_own_place && first.file != images.back().file) {
    fail_reading(place,
                 "its series has several files whose frames do not have individual positions",
                 "Give one of these files");
  }
  return stacked(place, std::move(images), choice, notices, times);
}

}  // namespace multitetra
