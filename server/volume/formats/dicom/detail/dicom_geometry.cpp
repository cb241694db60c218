#include "server/volume/formats/dicom/detail/dicom_geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "server/volume/formats/dicom/detail/dicom_elements.hpp"
#include "server/volume/formats/dicom/detail/dicom_moments.hpp"

namespace multitetra {
namespace {

using gdcm::Tag;

const Tag kPixelSpacing(0x0028, 0x0030);
const Tag kSpacingBetweenSlices(0x0018, 0x0088);
const Tag kSliceThickness(0x0018, 0x0050);

void set_plane_spacing(const std::vector<double>& numbers, SpacingSource source,
                       DicomImage& image) {
  if (numbers.size() < 2 || numbers[0] == 0 || numbers[1] == 0) return;
  image.spacing[0] = std::abs(numbers[1]);  // The spacing between rows comes first.
  image.spacing[1] = std::abs(numbers[0]);
  image.plane_spacing = source;
}

void set_slice_spacing(const std::vector<double>& numbers, SpacingSource source,
                       DicomImage& image) {
  if (numbers.empty() || numbers[0] == 0) return;
  image.spacing[2] = std::abs(numbers[0]);
  image.slice_spacing = source;
}

// Sets the spacing that elements of the file itself state; the last of each kind counts.
void set_spacing(const gdcm::DataSet& data, DicomImage& image) {
  const std::pair<Tag, SpacingSource> kPlanes[] = {
      {Tag(0x0018, 0x2010), SpacingSource::kScannedFilm},
      {Tag(0x3002, 0x0011), SpacingSource::kAtDetector},
      {Tag(0x0018, 0x1164), SpacingSource::kAtDetector},
      {kPixelSpacing, SpacingSource::kStated}};
  for (const auto& [tag, source] : kPlanes) set_plane_spacing(numbers_at(data, tag), source, image);
  set_slice_spacing(numbers_at(data, kSliceThickness), SpacingSource::kSliceThickness, image);
  set_slice_spacing(numbers_at(data, kSpacingBetweenSlices), SpacingSource::kBetweenSlices, image);
}

// Sets the spacing that the regions of an ultrasound image state, if they agree on one.
void set_region_spacing(const gdcm::DataSet& data, DicomImage& image) {
  constexpr std::uint16_t kPlane = 1;
  constexpr std::uint16_t kCentimeters = 3;
  const DicomSequence regions = sequence_at(data, Tag(0x0018, 0x6011));
  const std::size_t count = regions == nullptr ? 0 : regions->GetNumberOfItems();
  std::set<std::array<double, 2>> spacings;
  for (std::size_t i = 1; i <= count; ++i) {
    const gdcm::DataSet& region = regions->GetItem(i).GetNestedDataSet();
    const auto is = [&](std::uint16_t element, std::uint16_t wanted) {
      const auto number = binary_at<std::uint16_t>(region, Tag(0x0018, element));
      return !number.empty() && number[0] == wanted;
    };
    const auto x = binary_at<double>(region, Tag(0x0018, 0x602C));
    const auto y = binary_at<double>(region, Tag(0x0018, 0x602E));
    if (!is(0x6012, kPlane) || !is(0x6024, kCentimeters) || !is(0x6026, kCentimeters)) continue;
    if (!x.empty() && !y.empty()) spacings.insert({10 * std::abs(y[0]), 10 * std::abs(x[0])});
  }
  if (spacings.size() == 1 && image.plane_spacing == SpacingSource::kNone) {
    const auto [rows, columns] = *spacings.begin();
    return set_plane_spacing({rows, columns}, SpacingSource::kStated, image);
  }
  const bool differs =
      !spacings.empty() && !spacings.contains({image.spacing[1], image.spacing[0]});
  if (count > 0 && spacings.size() != 1 && image.plane_spacing == SpacingSource::kNone) {
    image.region_notice = spacings.empty()
                              ? "its ultrasound regions state no distances in a plane"
                              : "its ultrasound regions state several distances of columns and "
                                "rows; none is used";
  } else if (differs) {
    image.region_notice =
        "its ultrasound regions state other distances of columns and rows than PixelSpacing, which "
        "is used";
  }
}

Vec3 vector_in(const std::vector<double>& numbers, std::size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

// Applies the mapping to real-world values that a parametric map has; notes those of others.
void apply_mapping(const gdcm::DataSet& item, bool has_real_values, DicomImage& image) {
  const DicomSequence mappings = sequence_at(item, Tag(0x0040, 0x9096));
  if (mappings == nullptr || mappings->GetNumberOfItems() == 0) return;
  if (!has_real_values) {
    if (!image.mapping_notice.empty()) return;  // Another way is not applied, either.
    image.mapping_notice =
        "it also maps its numbers to real-world values (RealWorldValueMappingSequence), which is "
        "not applied";
    return;
  }
  const gdcm::DataSet& mapping = mappings->GetItem(1).GetNestedDataSet();
  const auto slope = binary_at<double>(mapping, Tag(0x0040, 0x9225));
  const auto intercept = binary_at<double>(mapping, Tag(0x0040, 0x9224));
  if (slope.empty() || intercept.empty() || slope[0] == 0) {
    image.mapping_notice =
        "its values are given by a table (RealWorldValueLUTData), which is not read; its numbers "
        "are read as stored";
    return;
  }
  if (mappings->GetNumberOfItems() > 1) {
    image.mapping_notice = "of its " + std::to_string(mappings->GetNumberOfItems()) +
                           " mappings to values (RealWorldValueMappingSequence), the first is used";
  }
  image.has_rescale = true;
  image.slope = slope[0];
  image.intercept = intercept[0];
  with_item(mapping, Tag(0x0040, 0x08EA), [&](const gdcm::DataSet& unit) {
    const std::string code = text_at(unit, Tag(0x0008, 0x0100));
    image.value_unit = code == "1" ? std::string() : unit_from(code);
  });
}

// Applies functional groups: properties of all frames, or of one, in enhanced files.
void apply_groups(const gdcm::DataSet& item, const gdcm::DataSet& file, bool has_real_values,
                  DicomImage& image) {
  const auto set_position = [&](const std::vector<double>& position, bool is_in_own_space) {
    if (position.size() != 3) return;
    image.position = vector_in(position, 0);
    image.has_own_place = image.has_origin = true;
    image.is_in_own_space = is_in_own_space;
  };
  const auto set_orientation = [&](const std::vector<double>& orientation) {
    if (orientation.size() != 6) return;
    image.row = vector_in(orientation, 0);
    image.column = vector_in(orientation, 3);
    image.has_orientation = true;
  };
  with_item(item, Tag(0x0020, 0x9113), [&](const gdcm::DataSet& plane) {
    set_position(numbers_at(plane, Tag(0x0020, 0x0032)), /*is_in_own_space=*/false);
  });
  with_item(item, Tag(0x0020, 0x9116), [&](const gdcm::DataSet& plane) {
    set_orientation(numbers_at(plane, Tag(0x0020, 0x0037)));
  });
  // Those of enhanced ultrasound are in a space of its volume.
  with_item(item, Tag(0x0020, 0x930E), [&](const gdcm::DataSet& plane) {
    set_position(binary_at<double>(plane, Tag(0x0020, 0x9301)), /*is_in_own_space=*/true);
  });
  with_item(item, Tag(0x0020, 0x930F), [&](const gdcm::DataSet& plane) {
    set_orientation(binary_at<double>(plane, Tag(0x0020, 0x9302)));
  });
  with_item(item, Tag(0x0028, 0x9110),
            [&](const gdcm::DataSet& measures) { set_spacing(measures, image); });
  with_item(item, Tag(0x0028, 0x9145), [&](const gdcm::DataSet& rescale) {
    const std::vector<double> slope = numbers_at(rescale, Tag(0x0028, 0x1053));
    const std::vector<double> intercept = numbers_at(rescale, Tag(0x0028, 0x1052));
    const std::string type = text_at(rescale, Tag(0x0028, 0x1054));
    set_rescale(slope, intercept, image);
    if (slope.empty() && type.empty()) return;
    image.value_unit = dicom_value_unit(type, file, image.modality);
  });
  with_item(item, Tag(0x0062, 0x000A), [&](const gdcm::DataSet& identified) {
    const auto numbers = binary_at<std::uint16_t>(identified, Tag(0x0062, 0x000B));
    if (!numbers.empty()) image.segment = numbers[0];
  });
  set_moment_of_frame(item, image);
  apply_mapping(item, has_real_values, image);
}

// Headers round the directions: makes them orthonormal, turning both by the same angle. Leaves
// differences that are of no effect. Fails for those that no rounding explains.
void make_orthonormal(DicomImage& image) {
  constexpr double kNoEffect = 1e-4;
  constexpr double kMostRounded = 0.03;  // Two decimals.
  const double lengths[] = {length(image.row), length(image.column)};
  const double skew = std::abs(dot(image.row, image.column));
  const double off = std::max({std::abs(lengths[0] - 1), std::abs(lengths[1] - 1), skew});
  if (off <= kNoEffect) return;
  if (!(off <= kMostRounded)) {
    fail_reading(image.file,
                 "the directions of its rows and columns (ImageOrientationPatient) are not of "
                 "length 1 and at right angles",
                 "Correct the header");
  }
  image.skew = skew;
  const Vec3 row = scaled(image.row, 1 / lengths[0]);
  const Vec3 column = scaled(image.column, 1 / lengths[1]);
  const Vec3 middle = sum(row, column);
  const Vec3 across = difference(row, column);
  const Vec3 u = scaled(middle, std::sqrt(0.5) / length(middle));
  const Vec3 v = scaled(across, std::sqrt(0.5) / length(across));
  image.row = sum(u, v);
  image.column = difference(u, v);
}

// Returns the distance of each frame of a file without positions from the first one.
std::vector<double> distances_of_frames(DicomImage& image, const gdcm::DataSet& data) {
  const auto frames = static_cast<std::size_t>(image.frames);
  std::vector<double> offsets = numbers_at(data, Tag(0x3004, 0x000C), frames);  // Of a dose grid.
  if (frames > 1 && offsets.size() == frames) {
    for (std::size_t i = frames; i-- > 0;) offsets[i] -= offsets[0];
    image.slice_spacing = SpacingSource::kStated;
    return offsets;
  }
  // In nuclear medicine, the sign tells on which side of the first slice the others lie, and frames
  // may be numbered by slice.
  const bool is_nuclear = image.modality == "NM" || image.modality == "PT";
  const std::vector<double> between = numbers_at(data, kSpacingBetweenSlices);
  const double sign = is_nuclear && !between.empty() && between[0] < 0 ? -1 : 1;
  if (is_nuclear && image.slice_spacing == SpacingSource::kBetweenSlices) {
    image.slice_spacing = SpacingSource::kStated;
  }
  const auto slices = binary_at<std::uint16_t>(data, Tag(0x0054, 0x0080));
  std::vector<double> distances;
  for (std::size_t i = 0; i < frames; ++i) {
    const double slice = slices.size() == frames ? static_cast<double>(slices[i]) - slices[0]
                                                 : static_cast<double>(i);
    distances.push_back(sign * image.spacing[2] * slice);
  }
  return distances;
}

// Sets the place of the first frame, if the file states it.
void set_place(const gdcm::DataSet& data, DicomImage& image) {
  std::vector<double> cosines = numbers_at(data, Tag(0x0020, 0x0037));
  std::vector<double> origin = numbers_at(data, Tag(0x0020, 0x0032));
  with_item(data, Tag(0x0054, 0x0022), [&](const gdcm::DataSet& detector) {  // Nuclear medicine.
    if (cosines.size() != 6) cosines = numbers_at(detector, Tag(0x0020, 0x0037));
    if (origin.size() != 3) origin = numbers_at(detector, Tag(0x0020, 0x0032));
  });
  image.has_orientation = cosines.size() == 6;
  if (!image.has_orientation) cosines = {1, 0, 0, 0, 1, 0};
  image.row = vector_in(cosines, 0);
  image.column = vector_in(cosines, 3);
  image.has_origin = origin.size() == 3;
  if (image.has_origin) image.position = vector_in(origin, 0);
  image.has_position = image.has_origin || image.frames > 1;
}

// ---- Siemens mosaics: the slices of a volume as tiles of one image

struct Mosaic {
  std::int64_t slices = 0;          // 0 if the header does not state them.
  std::vector<double> normal = {};  // From slice to slice; three numbers, or none.
};

// Returns the numbers of an element of a CSA header (version 2): elements of a name of 64 bytes and
// five numbers, of which the first but two are the count of items; items of four numbers, of which
// the second is the length of the text that follows, padded to four bytes.
std::vector<double> csa_numbers(std::string_view csa, std::string_view wanted) {
  constexpr std::size_t kNameBytes = 64;
  const auto number_at = [&](std::size_t at) {
    std::uint32_t number = 0;  // Requires a little-endian host.
    if (at + sizeof number <= csa.size()) std::memcpy(&number, csa.data() + at, sizeof number);
    return std::size_t{number};
  };
  if (!csa.starts_with("SV10")) return {};
  std::size_t at = 16;
  for (std::size_t elements = number_at(8); elements > 0 && at < csa.size(); --elements) {
    const std::string_view name = csa.substr(at, kNameBytes);
    const bool is_wanted = name.substr(0, name.find('\0')) == wanted;
    std::size_t items = number_at(at + kNameBytes + 12);
    std::string text;
    for (at += kNameBytes + 20; items > 0 && at < csa.size(); --items) {
      const std::size_t length = number_at(at + 4);
      if (length > csa.size()) return {};
      if (is_wanted && at + 16 < csa.size()) {
        const std::string_view item = csa.substr(at + 16, length);
        text += std::string(item.substr(0, item.find('\0'))) + ' ';
      }
      at += 16 + (length + 3) / 4 * 4;
    }
    if (is_wanted) return numbers_in(text);
  }
  return {};
}

// Returns nullopt if the image is no mosaic.
std::optional<Mosaic> mosaic_in(const gdcm::DataSet& data) {
  if (text_at(data, Tag(0x0008, 0x0008)).find("MOSAIC") == std::string::npos) return std::nullopt;
  constexpr std::size_t kMaxCsaBytes = std::size_t{1} << 22;
  Mosaic mosaic;
  const auto counts = binary_at<std::uint16_t>(data, Tag(0x0019, 0x100A));
  if (!counts.empty()) mosaic.slices = counts[0];
  const std::string csa = text_at(data, Tag(0x0029, 0x1010), kMaxCsaBytes);
  const std::vector<double> slices = csa_numbers(csa, "NumberOfImagesInMosaic");
  if (!slices.empty() && slices[0] >= 1 && slices[0] < 1e6) {
    mosaic.slices = static_cast<std::int64_t>(slices[0]);
  }
  mosaic.normal = csa_numbers(csa, "SliceNormalVector");
  return mosaic;
}

std::vector<DicomImage> slices_of_mosaic(const DicomImage& whole, const Mosaic& mosaic) {
  std::int64_t across = 1;
  while (across * across < mosaic.slices) ++across;
  if (mosaic.slices < 1 || whole.size[0] % across != 0 || whole.size[1] % across != 0) {
    fail_reading(whole.file,
                 "it is a Siemens mosaic, the slices of a volume as tiles of one image, but does "
                 "not state how many",
                 "Convert it to NIfTI, for example with dcm2niix");
  }
  std::vector<DicomImage> slices;
  for (std::int64_t i = 0; i < mosaic.slices; ++i) {
    DicomImage& slice = slices.emplace_back(whole);
    slice.frame = i;
    slice.frames = mosaic.slices;
    slice.size = {whole.size[0] / across, whole.size[1] / across};
    slice.tile = DicomTile{.mosaic_columns = whole.size[0],
                           .mosaic_rows = whole.size[1],
                           .first_column = i % across * slice.size[0],
                           .first_row = i / across * slice.size[1]};
    // The stated position is that of a mosaic with the center of the slices.
    const std::array<Vec3, 2> directions = {whole.row, whole.column};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto beside = static_cast<double>(whole.size[axis] - slice.size[axis]) / 2;
      slice.position = moved(slice.position, beside * whole.spacing[axis], directions[axis]);
    }
    Vec3 normal = cross(whole.row, whole.column);
    const double along = mosaic.normal.size() == 3 ? dot(normal, vector_in(mosaic.normal, 0)) : 1;
    if (along < 0) normal = scaled(normal, -1);
    slice.position = moved(slice.position, whole.spacing[2] * static_cast<double>(i), normal);
    slice.has_own_place = true;
    slice.along = dot(slice.position, cross(whole.row, whole.column));
  }
  return slices;
}

}  // namespace

void set_rescale(const std::vector<double>& slope, const std::vector<double>& intercept,
                 DicomImage& image) {
  if (slope.empty() && intercept.empty()) return;
  if (!slope.empty() && slope[0] == 0) return;
  image.has_rescale = true;
  if (!slope.empty()) image.slope = slope[0];
  if (!intercept.empty()) image.intercept = intercept[0];
}

std::string dicom_value_unit(const std::string& rescale_type, const gdcm::DataSet& data,
                             const std::string& modality) {
  if (rescale_type == "US") return {};  // The standard defines US as unspecified.
  if (!rescale_type.empty()) return unit_from(rescale_type);
  if (data.FindDataElement(Tag(0x0028, 0x3000))) return {};  // A table that is not read.
  if (modality == "CT") return "HU";
  if (modality == "RTDOSE" && text_at(data, Tag(0x3004, 0x0002)) == "GY") return "Gy";
  return modality == "PT" ? unit_from(text_at(data, Tag(0x0054, 0x1001))) : std::string();
}

std::vector<DicomImage> frames_of_dicom(DicomImage whole, const gdcm::File& file) {
  const gdcm::DataSet& data = file.GetDataSet();
  set_place(data, whole);
  set_spacing(data, whole);
  set_region_spacing(data, whole);
  whole.is_cine = whole.frames > 1 && (data.FindDataElement(Tag(0x0018, 0x1063)) ||
                                       data.FindDataElement(Tag(0x0018, 0x1065)));
  const std::string kind = text_at(data, Tag(0x0008, 0x0016));
  const bool has_real_values = kind == "1.2.840.10008.5.1.4.1.1.30";  // A parametric map.
  const auto apply = [&](const gdcm::DataSet& item, DicomImage& image) {
    apply_groups(item, data, has_real_values, image);
  };
  apply_mapping(data, false, whole);
  with_item(data, Tag(0x5200, 0x9229), [&](const gdcm::DataSet& shared) { apply(shared, whole); });
  if (const auto mosaic = mosaic_in(data); whole.frames == 1 && mosaic) {
    make_orthonormal(whole);
    return slices_of_mosaic(whole, *mosaic);
  }
  const DicomSequence each = sequence_at(data, Tag(0x5200, 0x9230));
  if (each != nullptr && each->GetNumberOfItems() != static_cast<std::size_t>(whole.frames)) {
    fail_damaged(whole.file, "it has " + std::to_string(whole.frames) + " frames, but describes " +
                                 std::to_string(each->GetNumberOfItems()));
  }
  const std::vector<double> distances = distances_of_frames(whole, data);
  std::vector<DicomImage> images;
  images.reserve(static_cast<std::size_t>(whole.frames));
  for (std::int64_t frame = 0; frame < whole.frames; ++frame) {
    DicomImage& image = images.emplace_back(whole);
    image.frame = frame;
    const auto index = static_cast<std::size_t>(frame);
    if (each != nullptr) apply(each->GetItem(index + 1).GetNestedDataSet(), image);
    make_orthonormal(image);
    const Vec3 normal = cross(image.row, image.column);
    if (each != nullptr) {
      image.has_position = image.has_own_place;
    } else {
      image.position = moved(image.position, distances[index], normal);
    }
    image.along = dot(image.position, normal);
  }
  return images;
}

}  // namespace multitetra
