#include "server/volume/formats/dicom/detail/dicom_image.hpp"

#include <gdcmImageHelper.h>
#include <gdcmMediaStorage.h>
#include <gdcmPixelFormat.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmUIDs.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>
#include <utility>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/dicom/detail/dicom_pixels.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kMaxDicomFrames = 100'000;

std::string text_at(const gdcm::DataSet& data, const gdcm::Tag& tag, std::size_t most = 1024) {
  if (!data.FindDataElement(tag)) return {};
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (bytes == nullptr || bytes->GetLength() > most) return {};
  std::string text(bytes->GetPointer(), bytes->GetLength());
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

// Returns the values of a text element, which backslashes separate.
std::vector<double> numbers_at(const gdcm::DataSet& data, const gdcm::Tag& tag,
                               std::size_t most = 64) {
  std::vector<double> numbers;
  std::string text = text_at(data, tag, 18 * most);
  std::replace(text.begin(), text.end(), '\\', ' ');
  const char* at = text.c_str();
  for (char* end = nullptr; numbers.size() < most; at = end) {
    const double number = std::strtod(at, &end);
    if (end == at || !std::isfinite(number)) break;
    numbers.push_back(number);
  }
  return numbers;
}

std::string value_unit_of(const std::string& rescale_type, const gdcm::DataSet& data,
                          const std::string& modality) {
  if (rescale_type == "US") return {};  // The standard defines US as unspecified.
  if (!rescale_type.empty()) return unit_from(rescale_type);
  if (modality == "CT") return "HU";
  return modality == "PT" ? unit_from(text_at(data, gdcm::Tag(0x0054, 0x1001))) : std::string();
}

// ---- functional groups: properties of all frames, or of one, in Enhanced files

using DicomSequence = gdcm::SmartPointer<gdcm::SequenceOfItems>;

DicomSequence sequence_at(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  if (!data.FindDataElement(tag)) return nullptr;
  return data.GetDataElement(tag).GetValueAsSQ();
}

struct FunctionalGroups {
  std::vector<double> position = {};
  std::vector<double> orientation = {};
  std::vector<double> pixel_spacing = {};
  std::vector<double> slice_spacing = {};
  std::vector<double> slope = {};
  std::vector<double> intercept = {};
  std::string rescale_type = {};
};

// Updates `groups` with the values in `item`.
void read_groups(const gdcm::DataSet& item, FunctionalGroups& groups) {
  const auto take = [&](const gdcm::Tag& group, const gdcm::Tag& tag, std::size_t count,
                        std::vector<double>& into) {
    const DicomSequence sequence = sequence_at(item, group);
    if (sequence == nullptr || sequence->GetNumberOfItems() < 1) return;
    std::vector<double> numbers = numbers_at(sequence->GetItem(1).GetNestedDataSet(), tag);
    if (numbers.size() == count) into = std::move(numbers);
  };
  const gdcm::Tag measures(0x0028, 0x9110);
  const gdcm::Tag transformation(0x0028, 0x9145);
  take({0x0020, 0x9113}, {0x0020, 0x0032}, 3, groups.position);
  take({0x0020, 0x9116}, {0x0020, 0x0037}, 6, groups.orientation);
  take(measures, {0x0028, 0x0030}, 2, groups.pixel_spacing);
  take(measures, {0x0018, 0x0050}, 1, groups.slice_spacing);
  take(measures, {0x0018, 0x0088}, 1, groups.slice_spacing);
  take(transformation, {0x0028, 0x1052}, 1, groups.intercept);
  take(transformation, {0x0028, 0x1053}, 1, groups.slope);
  const DicomSequence rescale = sequence_at(item, transformation);
  if (rescale == nullptr || rescale->GetNumberOfItems() < 1) return;
  groups.rescale_type = text_at(rescale->GetItem(1).GetNestedDataSet(), gdcm::Tag(0x0028, 0x1054));
}

void apply(const FunctionalGroups& groups, DicomImage& image) {
  const auto vector = [](const std::vector<double>& numbers, std::size_t first) {
    return Vec3{numbers[first], numbers[first + 1], numbers[first + 2]};
  };
  if (!groups.position.empty()) image.position = vector(groups.position, 0);
  if (!groups.orientation.empty()) {
    image.row = vector(groups.orientation, 0);
    image.column = vector(groups.orientation, 3);
  }
  if (!groups.pixel_spacing.empty()) {  // The spacing between rows comes first.
    image.spacing[0] = std::abs(groups.pixel_spacing[1]);
    image.spacing[1] = std::abs(groups.pixel_spacing[0]);
  }
  if (!groups.slice_spacing.empty()) image.spacing[2] = std::abs(groups.slice_spacing[0]);
  if (!groups.slope.empty()) image.slope = groups.slope[0];
  if (!groups.intercept.empty()) image.intercept = groups.intercept[0];
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

// Returns the frames of a file with header `whole`, positioned by functional groups, by the offsets
// of a dose grid, or else one slice spacing apart.
std::vector<DicomImage> frames_of(const DicomImage& whole, const gdcm::DataSet& data) {
  const DicomSequence shared = sequence_at(data, gdcm::Tag(0x5200, 0x9229));
  const DicomSequence each = sequence_at(data, gdcm::Tag(0x5200, 0x9230));
  const std::vector<double> offsets =
      numbers_at(data, gdcm::Tag(0x3004, 0x000C), static_cast<std::size_t>(whole.frames));
  FunctionalGroups of_all;
  if (shared != nullptr && shared->GetNumberOfItems() > 0) {
    read_groups(shared->GetItem(1).GetNestedDataSet(), of_all);
  }
  if (each != nullptr && each->GetNumberOfItems() != static_cast<std::size_t>(whole.frames)) {
    fail_damaged(whole.file, "it has " + std::to_string(whole.frames) + " frames, but describes " +
                                 std::to_string(each->GetNumberOfItems()));
  }
  std::vector<DicomImage> images;
  images.reserve(static_cast<std::size_t>(whole.frames));
  for (std::int64_t frame = 0; frame < whole.frames; ++frame) {
    DicomImage& image = images.emplace_back(whole);
    image.frame = frame;
    FunctionalGroups groups = of_all;
    if (each != nullptr) {
      const auto item = static_cast<std::size_t>(frame) + 1;
      read_groups(each->GetItem(item).GetNestedDataSet(), groups);
    }
    apply(groups, image);
    make_orthonormal(image);
    if (!groups.rescale_type.empty() || !groups.slope.empty()) {
      image.value_unit = value_unit_of(groups.rescale_type, data, image.modality);
    }
    const Vec3 normal = cross(image.row, image.column);
    if (each != nullptr) {
      image.has_position = !groups.position.empty();
      image.has_own_place = image.has_position;
    } else {
      const double distance = offsets.size() == static_cast<std::size_t>(whole.frames)
                                  ? offsets[static_cast<std::size_t>(frame)] - offsets[0]
                                  : image.spacing[2] * static_cast<double>(frame);
      image.position = moved(image.position, distance, normal);
    }
    image.along = dot(image.position, normal);
  }
  return images;
}

// ---- one file

struct DicomHeader {
  gdcm::Reader reader;
  std::uint64_t pixels = 0;  // Offset of the value of the pixel data.
};

// Returns false for files without an image.
bool read_dicom_header(const fs::path& path, DicomHeader& header) {
  const gdcm::Tag pixel_data(0x7FE0, 0x0010);
  std::ifstream stream(path, std::ios::binary);
  header.reader.SetStream(stream);
  const bool is_read = header.reader.ReadUpToTag(pixel_data, {pixel_data});
  const gdcm::File& file = header.reader.GetFile();
  const bool has_rows = file.GetDataSet().FindDataElement(gdcm::Tag(0x0028, 0x0010));
  gdcm::MediaStorage kind;
  kind.SetFromHeader(file.GetHeader());
  const char* const uid = kind.GetString();
  gdcm::UIDs known;
  const char* const kind_name = uid != nullptr && known.SetFromUID(uid) ? known.GetName() : nullptr;
  const bool is_image =
      kind_name != nullptr && std::string_view(kind_name).ends_with("Image Storage");
  if (!is_read || (is_image && !has_rows)) {
    fail_damaged(path, "its header ends too early or is damaged");
  }
  stream.clear();
  header.pixels = static_cast<std::uint64_t>(std::max<std::streamoff>(stream.tellg(), 0));
  return has_rows;
}

// Returns whether there are more bytes than announced.
bool check_pixels(const fs::path& path, const DicomHeader& header, const DicomImage& image,
                  const gdcm::PixelFormat& format) {
  const gdcm::TransferSyntax& syntax =
      header.reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  const InputFile file(path);
  if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) {
    check_deflated_dicom(file);
    return false;
  }
  const char* const uid = syntax.GetString();
  const auto photometric =
      gdcm::ImageHelper::GetPhotometricInterpretationValue(header.reader.GetFile());
  // Two uncompressed pixels share their color: four samples instead of six.
  const bool is_subsampled = photometric == gdcm::PhotometricInterpretation::YBR_FULL_422 ||
                             photometric == gdcm::PhotometricInterpretation::YBR_PARTIAL_422;
  return check_dicom_pixels(
      file, {.offset = header.pixels,
             .syntax = uid == nullptr ? std::string_view() : std::string_view(uid),
             .frames = static_cast<std::uint64_t>(image.frames),
             .frame_samples = static_cast<std::uint64_t>(image.size[0] * image.size[1] *
                                                         (is_subsampled ? 2 : image.components)),
             .bits = format.GetBitsAllocated()});
}

}  // namespace

std::optional<StoredType> dicom_type(const gdcm::PixelFormat& format) {
  switch (format.GetScalarType()) {
    case gdcm::PixelFormat::UINT8:
      return StoredType::kU8;
    case gdcm::PixelFormat::INT8:
      return StoredType::kI8;
    case gdcm::PixelFormat::UINT12:
    case gdcm::PixelFormat::UINT16:
      return StoredType::kU16;
    case gdcm::PixelFormat::INT12:
    case gdcm::PixelFormat::INT16:
      return StoredType::kI16;
    case gdcm::PixelFormat::UINT32:
      return StoredType::kU32;
    case gdcm::PixelFormat::INT32:
      return StoredType::kI32;
    case gdcm::PixelFormat::FLOAT32:
      return StoredType::kF32;
    case gdcm::PixelFormat::FLOAT64:
      return StoredType::kF64;
    default:
      return std::nullopt;
  }
}

std::vector<DicomImage> dicom_images(const fs::path& path) {
  DicomHeader header;
  if (!read_dicom_header(path, header)) return {};
  const gdcm::File& file = header.reader.GetFile();
  const gdcm::DataSet& data = file.GetDataSet();
  DicomImage image{.file = path,
                   .series = text_at(data, gdcm::Tag(0x0020, 0x000E)),
                   .study = text_at(data, gdcm::Tag(0x0020, 0x000D)),
                   .patient = text_at(data, gdcm::Tag(0x0010, 0x0020)),
                   .description = text_at(data, gdcm::Tag(0x0008, 0x103E)),
                   .modality = text_at(data, gdcm::Tag(0x0008, 0x0060))};
  image.is_localizer =
      text_at(data, gdcm::Tag(0x0008, 0x0008)).find("LOCALIZER") != std::string::npos;
  const std::vector<unsigned> dims = gdcm::ImageHelper::GetDimensionsValue(file);
  for (std::size_t axis = 0; axis < std::min<std::size_t>(dims.size(), 2); ++axis)
    image.size[axis] = dims[axis];
  if (dims.size() > 2) image.frames = dims[2];
  if (image.frames < 1 || image.frames > kMaxDicomFrames) {
    fail_reading(path, "it has " + std::to_string(image.frames) + " frames",
                 "Give a file with 1 to " + std::to_string(kMaxDicomFrames));
  }
  const gdcm::PixelFormat format = gdcm::ImageHelper::GetPixelFormatValue(file);
  const std::optional<StoredType> type = dicom_type(format);
  if (!type) {
    fail_reading(path, "its pixels have the type " + std::string(format.GetScalarTypeAsString()),
                 "Give integers of 8 to 32 bits or floats");
  }
  image.type = *type;
  image.components = format.GetSamplesPerPixel();
  image.stored_bits = format.GetBitsStored();
  const auto photometric = gdcm::ImageHelper::GetPhotometricInterpretationValue(file);
  if (photometric == gdcm::PhotometricInterpretation::PALETTE_COLOR) {
    fail_reading(path, "its pixels are palette indices", "Convert it to gray values or RGB");
  }
  const std::vector<double> rescale = gdcm::ImageHelper::GetRescaleInterceptSlopeValue(file);
  if (rescale.size() == 2) {
    image.intercept = rescale[0];
    image.slope = rescale[1];
  }
  image.value_unit = value_unit_of(text_at(data, gdcm::Tag(0x0028, 0x1054)), data, image.modality);
  // GDCM replaces directions that are not quite at right angles by the identity.
  std::vector<double> cosines = numbers_at(data, gdcm::Tag(0x0020, 0x0037));
  if (cosines.size() != 6) cosines = gdcm::ImageHelper::GetDirectionCosinesValue(file);
  const std::vector<double> origin = gdcm::ImageHelper::GetOriginValue(file);
  const std::vector<double> spacing = gdcm::ImageHelper::GetSpacingValue(file);
  if (cosines.size() != 6 || origin.size() < 3) return {};
  image.row = {cosines[0], cosines[1], cosines[2]};
  image.column = {cosines[3], cosines[4], cosines[5]};
  image.position = {origin[0], origin[1], origin[2]};
  image.has_position = data.FindDataElement(gdcm::Tag(0x0020, 0x0032)) || image.frames > 1;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(spacing.size(), 3); ++axis) {
    image.spacing[axis] = std::abs(spacing[axis]);
  }
  const std::vector<double> number = numbers_at(data, gdcm::Tag(0x0020, 0x0013));
  if (!number.empty() && std::abs(number[0]) < 1e15)
    image.number = static_cast<std::int64_t>(number[0]);
  image.has_excess_bytes = check_pixels(path, header, image, format);
  return frames_of(image, data);
}

}  // namespace multitetra
