#include "server/volume/formats/detail/dicom_image.hpp"

#include <gdcmImageHelper.h>
#include <gdcmPixelFormat.h>
#include <gdcmReader.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/input_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string text_at(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  if (!data.FindDataElement(tag)) return {};
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (bytes == nullptr || bytes->GetLength() > 1024) return {};
  std::string text(bytes->GetPointer(), bytes->GetLength());
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

// The values of a text element, which are separated by backslashes.
std::vector<double> numbers_at(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  std::vector<double> numbers;
  std::string text = text_at(data, tag);
  std::replace(text.begin(), text.end(), '\\', ' ');
  const char* at = text.c_str();
  for (char* end = nullptr; numbers.size() < 64; at = end) {
    const double number = std::strtod(at, &end);
    if (end == at || !std::isfinite(number)) break;
    numbers.push_back(number);
  }
  return numbers;
}

std::string value_unit_of(const gdcm::DataSet& data, const std::string& modality) {
  const std::string rescale_type = text_at(data, gdcm::Tag(0x0028, 0x1054));
  if (rescale_type == "US") return {};  // Unspecified, by the standard's own word.
  if (!rescale_type.empty()) return unit_from(rescale_type);
  if (modality == "CT") return "HU";
  return modality == "PT" ? unit_from(text_at(data, gdcm::Tag(0x0054, 0x1001))) : std::string();
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

std::optional<DicomImage> dicom_image(const fs::path& path) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.ReadUpToTag(gdcm::Tag(0x7FE0, 0x0010))) return std::nullopt;
  const gdcm::File& file = reader.GetFile();
  const gdcm::DataSet& data = file.GetDataSet();
  if (!data.FindDataElement(gdcm::Tag(0x0028, 0x0010))) return std::nullopt;  // No rows.
  DicomImage image{.file = path,
                   .series = text_at(data, gdcm::Tag(0x0020, 0x000E)),
                   .description = text_at(data, gdcm::Tag(0x0008, 0x103E)),
                   .modality = text_at(data, gdcm::Tag(0x0008, 0x0060))};
  const std::vector<unsigned> dims = gdcm::ImageHelper::GetDimensionsValue(file);
  for (std::size_t axis = 0; axis < std::min<std::size_t>(dims.size(), 3); ++axis)
    image.dims[axis] = dims[axis];
  const gdcm::PixelFormat format = gdcm::ImageHelper::GetPixelFormatValue(file);
  const std::optional<StoredType> type = dicom_type(format);
  if (!type) {
    fail_reading(path, "its pixels are of the type " + std::string(format.GetScalarTypeAsString()),
                 "Give integers of 8 to 32 bits or floats");
  }
  image.type = *type;
  image.components = format.GetSamplesPerPixel();
  image.stored_bits = format.GetBitsStored();
  const auto photometric = gdcm::ImageHelper::GetPhotometricInterpretationValue(file);
  if (photometric == gdcm::PhotometricInterpretation::PALETTE_COLOR) {
    fail_reading(path, "its pixels are numbers of a palette", "Convert it to grey values or RGB");
  }
  const std::vector<double> rescale = gdcm::ImageHelper::GetRescaleInterceptSlopeValue(file);
  if (rescale.size() == 2) {
    image.intercept = rescale[0];
    image.slope = rescale[1];
  }
  image.value_unit = value_unit_of(data, image.modality);
  const std::vector<double> cosines = gdcm::ImageHelper::GetDirectionCosinesValue(file);
  const std::vector<double> origin = gdcm::ImageHelper::GetOriginValue(file);
  const std::vector<double> spacing = gdcm::ImageHelper::GetSpacingValue(file);
  if (cosines.size() != 6 || origin.size() < 3) return std::nullopt;
  image.row = {cosines[0], cosines[1], cosines[2]};
  image.column = {cosines[3], cosines[4], cosines[5]};
  image.position = {origin[0], origin[1], origin[2]};
  image.has_position = data.FindDataElement(gdcm::Tag(0x0020, 0x0032)) || image.dims[2] > 1;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(spacing.size(), 3); ++axis) {
    image.spacing[axis] = std::abs(spacing[axis]);
  }
  const std::vector<double> number = numbers_at(data, gdcm::Tag(0x0020, 0x0013));
  if (!number.empty() && std::abs(number[0]) < 1e15)
    image.number = static_cast<std::int64_t>(number[0]);
  image.along = dot(image.position, cross(image.row, image.column));
  return image;
}

}  // namespace multitetra
