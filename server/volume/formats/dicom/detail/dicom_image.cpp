#include "server/volume/formats/dicom/detail/dicom_image.hpp"

#include <gdcmImageHelper.h>
#include <gdcmMediaStorage.h>
#include <gdcmPixelFormat.h>
#include <gdcmReader.h>
#include <gdcmUIDs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/unpacking.hpp"
#include "server/volume/formats/dicom/detail/dicom_elements.hpp"
#include "server/volume/formats/dicom/detail/dicom_geometry.hpp"
#include "server/volume/formats/dicom/detail/dicom_meta.hpp"
#include "server/volume/formats/dicom/detail/dicom_moments.hpp"
#include "server/volume/formats/dicom/detail/dicom_pixels.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;
using gdcm::Tag;

constexpr std::array<std::uint16_t, 3> kPixelElements = {0x0008, 0x0009, 0x0010};
constexpr std::uint32_t kMaxDicomFrames = 100'000;
constexpr std::string_view kDeflatedSyntax = "1.2.840.10008.1.2.1.99";
constexpr std::string_view kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr std::string_view kLabelMap = "1.2.840.10008.5.1.4.1.1.66.7";

struct DicomHeader {
  gdcm::Reader reader;
  std::uint16_t element = 0x0010;  // Of the pixel data in group 7FE0.
  std::uint64_t pixels = 0;        // Offset of the value of the pixel data.
  bool is_damaged = false;

  [[nodiscard]] const gdcm::DataSet& data() const { return reader.GetFile().GetDataSet(); }
};

// Reads up to the value of an element; false if the header is damaged.
bool read_up_to(const fs::path& path, std::uint16_t element, DicomHeader& header) {
  const Tag pixel_data(0x7FE0, element);
  std::ifstream stream(path, std::ios::binary);
  header.reader.SetStream(stream);
  const bool is_read = header.reader.ReadUpToTag(
      pixel_data, {Tag(0x7FE0, 0x0008), Tag(0x7FE0, 0x0009), Tag(0x7FE0, 0x0010)});
  stream.clear();
  header.element = element;
  header.pixels = static_cast<std::uint64_t>(std::max<std::streamoff>(stream.tellg(), 0));
  return is_read;
}

// Reads all of a file that is deflated as a whole, in which GDCM cannot stop at an element.
bool read_deflated(const fs::path& path, std::uint64_t meta_end, DicomHeader& header) {
  UnpackedStream(InputFile(path), meta_end, Packing::kDeflate).require_good_end();
  header.reader.SetFileName(path.c_str());
  return header.reader.Read();
}

// Returns nullptr for files without an image.
std::unique_ptr<DicomHeader> read_dicom_header(const fs::path& path) {
  auto header = std::make_unique<DicomHeader>();
  const InputFile file(path);
  const std::uint64_t meta_end = dicom_meta_end(file);
  const bool is_deflated = file.beginning(meta_end).find(kDeflatedSyntax) != std::string::npos;
  if (!is_deflated) check_dicom_elements(file, meta_end);
  const bool is_read =
      is_deflated ? read_deflated(path, meta_end, *header) : read_up_to(path, 0x0010, *header);
  const bool has_rows = header->data().FindDataElement(Tag(0x0028, 0x0010));
  gdcm::MediaStorage kind;
  kind.SetFromHeader(header->reader.GetFile().GetHeader());
  const char* const uid = kind.GetString();
  gdcm::UIDs known;
  const char* const name = uid != nullptr && known.SetFromUID(uid) ? known.GetName() : nullptr;
  const bool is_image = name != nullptr && std::string_view(name).ends_with("Image Storage");
  if (!is_read || (is_image && !has_rows)) {
    header->is_damaged = true;
    return header;
  }
  return has_rows ? std::move(header) : nullptr;
}

bool is_deflated(const DicomHeader& header) {
  return header.reader.GetFile().GetHeader().GetDataSetTransferSyntax() ==
         gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
}

// Finds the pixels of a file that is deflated as a whole: its elements have no places in the file.
void find_deflated_pixels(const fs::path& path, DicomHeader& header) {
  for (const std::uint16_t element : kPixelElements) {
    header.element = element;
    if (header.data().FindDataElement(Tag(0x7FE0, element))) return;
  }
  fail_reading(path, "it has no pixel data", "Leave it out");
}

// Finds floats, which are in elements of their own and have no PixelRepresentation.
void find_floats(const fs::path& path, DicomHeader& header) {
  if (header.data().FindDataElement(Tag(0x0028, 0x0103))) return;
  for (const std::uint16_t element : std::span(kPixelElements).first(2)) {
    DicomHeader of_floats;
    if (!read_up_to(path, element, of_floats) ||
        !has_pixels_before(InputFile(path), of_floats.pixels, element)) {
      continue;
    }
    header.element = element;
    header.pixels = of_floats.pixels;
    return;
  }
}

// Checks the length of the pixel data; sets how frames can be read.
void check_pixels(const DicomHeader& header, std::uint64_t bits, DicomImage& image) {
  const gdcm::File& dicom = header.reader.GetFile();
  const gdcm::TransferSyntax& syntax = dicom.GetHeader().GetDataSetTransferSyntax();
  const InputFile file(image.file);
  image.element = header.element;
  if (is_deflated(header)) return;
  const bool is_native = syntax == gdcm::TransferSyntax::ExplicitVRLittleEndian ||
                         syntax == gdcm::TransferSyntax::ImplicitVRLittleEndian;
  const bool is_big = syntax == gdcm::TransferSyntax::ExplicitVRBigEndian;
  const bool has_floats = image.element != 0x0010;
  // The order of the words of larger big-endian numbers differs by program.
  if (is_big && (has_floats || bits > 16)) {
    fail_reading(image.file, "its pixels of " + std::to_string(bits) + " bits are big-endian",
                 "Save it as Explicit VR Little Endian");
  }
  if (has_floats && !is_native) {
    fail_reading(image.file, "its floating-point pixels are compressed",
                 "Save it without compression");
  }
  const auto photometric = gdcm::ImageHelper::GetPhotometricInterpretationValue(dicom);
  // Two uncompressed pixels share their color: four samples instead of six.
  const bool is_subsampled = photometric == gdcm::PhotometricInterpretation::YBR_FULL_422 ||
                             photometric == gdcm::PhotometricInterpretation::YBR_PARTIAL_422;
  const char* const uid = syntax.GetString();
  const DicomPixels pixels = {
      .element = header.element,
      .offset = header.pixels,
      .syntax = uid == nullptr ? std::string_view() : std::string_view(uid),
      .frames = static_cast<std::uint64_t>(image.frames),
      .frame_samples = static_cast<std::uint64_t>(image.size[0] * image.size[1] *
                                                  (is_subsampled ? 2 : image.components)),
      .bits = bits};
  image.has_excess_bytes = check_dicom_pixels(file, pixels);
  image.is_jpeg = pixels.syntax.starts_with("1.2.840.10008.1.2.4.");
  const bool is_plain = image.components == 1;  // GDCM aborts on some overlays and bits.
  if (is_plain && is_native) image.pixels_at = header.pixels;
}

// Converts a CIELab value, whose numbers are spread over 16 bits, to sRGB.
std::optional<std::uint32_t> color_from_lab(const std::vector<std::uint16_t>& lab) {
  if (lab.size() != 3) return std::nullopt;
  const auto share = [&](std::size_t i) { return lab[i] / 65535.0; };
  const double fy = (100 * share(0) + 16) / 116;
  const double fx = fy + (255 * share(1) - 128) / 500;
  const double fz = fy - (255 * share(2) - 128) / 200;
  const auto linear = [](double f) {
    return f > 6.0 / 29 ? f * f * f : 3 * (6.0 / 29) * (6.0 / 29) * (f - 4.0 / 29);
  };
  const double x = 0.9505 * linear(fx);  // White of sRGB, D65.
  const double y = linear(fy);
  const double z = 1.089 * linear(fz);
  std::uint32_t color = 0;
  for (const double part :
       {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z}) {
    const double light = std::clamp(part, 0.0, 1.0);
    const double shown =
        light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
    color = color << 8 | static_cast<std::uint32_t>(std::lround(255 * shown));
  }
  return color;
}

Segmentation segmentation_in(const gdcm::DataSet& data) {
  const std::string kind = text_at(data, Tag(0x0008, 0x0016));
  if (kind == kLabelMap) return Segmentation::kLabelMap;
  if (kind != kSegmentation) return Segmentation::kNone;
  const std::string type = text_at(data, Tag(0x0062, 0x0001));
  if (type == "LABELMAP") return Segmentation::kLabelMap;
  return type == "FRACTIONAL" ? Segmentation::kFractional : Segmentation::kBinary;
}

// Refuses what GDCM would abort on.
void check_format(const DicomHeader& header, const DicomImage& image) {
  const auto allocated = binary_at<std::uint16_t>(header.data(), Tag(0x0028, 0x0100));
  if (allocated.empty() || allocated[0] == 0) {
    fail_damaged(image.file, "it does not state the bits of its samples (BitsAllocated)");
  }
  const auto samples = binary_at<std::uint16_t>(header.data(), Tag(0x0028, 0x0002));
  if (samples.empty() || samples[0] == 1 || samples[0] == 3 || samples[0] == 4) return;
  fail_reading(image.file,
               "its pixels have " + std::to_string(samples[0]) + " samples (SamplesPerPixel)",
               "Give gray values or RGB");
}

// Sets what the samples are; returns their bits in the file.
std::uint64_t set_type(const DicomHeader& header, DicomImage& image) {
  if (header.element != 0x0010) {
    image.type = header.element == 0x0008 ? StoredType::kF32 : StoredType::kF64;
    return 8 * bytes_of(image.type);
  }
  check_format(header, image);
  const gdcm::PixelFormat format = gdcm::ImageHelper::GetPixelFormatValue(header.reader.GetFile());
  image.components = format.GetSamplesPerPixel();
  image.has_sign = header.data().FindDataElement(Tag(0x0028, 0x0103));
  const auto planes = binary_at<std::uint16_t>(header.data(), Tag(0x0028, 0x0006));
  image.has_planes = image.components > 1 && !planes.empty() && planes[0] == 1;
  image.stored_bits = format.GetBitsStored();
  // GDCM takes bits that end elsewhere for the lowest ones.
  const auto high = binary_at<std::uint16_t>(header.data(), Tag(0x0028, 0x0102));
  if (!high.empty() && high[0] >= image.stored_bits && high[0] < format.GetBitsAllocated()) {
    image.unused_bits = high[0] + 1 - image.stored_bits;
  }
  image.has_bits = image.segmentation != Segmentation::kNone && format.GetBitsAllocated() == 1;
  if (image.has_bits) return 1;
  const std::optional<StoredType> type = dicom_type(format);
  if (!type || format.GetBitsAllocated() != 8 * bytes_of(*type)) {
    fail_reading(image.file,
                 "its pixels have the type " + std::string(format.GetScalarTypeAsString()) +
                     " in " + std::to_string(format.GetBitsAllocated()) + " bits",
                 "Give integers of 8, 16 or 32 bits or floats");
  }
  image.type = *type;
  const auto photometric =
      gdcm::ImageHelper::GetPhotometricInterpretationValue(header.reader.GetFile());
  if (photometric == gdcm::PhotometricInterpretation::PALETTE_COLOR &&
      image.segmentation == Segmentation::kNone) {
    fail_reading(image.file, "its pixels are palette indices", "Convert it to gray values or RGB");
  }
  // GDCM decompresses streams of JPEG without a conversion of colors.
  image.is_ybr = photometric == gdcm::PhotometricInterpretation::YBR_FULL ||
                 photometric == gdcm::PhotometricInterpretation::YBR_FULL_422;
  return format.GetBitsAllocated();
}

// Sets how values follow from stored numbers. Not by GDCM, which ignores the rescale of
// projections.
void set_values(const gdcm::DataSet& data, DicomImage& image) {
  std::vector<double> slope = numbers_at(data, Tag(0x0028, 0x1053));
  if (slope.empty()) slope = numbers_at(data, Tag(0x3004, 0x000E));  // DoseGridScaling.
  const std::vector<double> intercept = numbers_at(data, Tag(0x0028, 0x1052));
  set_rescale(slope, intercept, image);
  if (data.FindDataElement(Tag(0x0028, 0x3000))) {
    image.mapping_notice =
        "its values are given by a table (ModalityLUTSequence), which is not read; its numbers are "
        "read as stored";
  }
  image.value_unit = dicom_value_unit(text_at(data, Tag(0x0028, 0x1054)), data, image.modality);
  const auto padding = binary_at<std::uint16_t>(data, Tag(0x0028, 0x0120));
  if (padding.empty() || bytes_of(image.type) > 2) return;
  const auto limit = binary_at<std::uint16_t>(data, Tag(0x0028, 0x0121));
  const bool is_signed = name(image.type).starts_with('i');
  const auto number = [&](std::uint16_t bits) -> double {
    return is_signed ? static_cast<std::int16_t>(bits) : bits;
  };
  const auto [low, high] =
      std::minmax({number(padding[0]), number(limit.empty() ? padding[0] : limit[0])});
  image.padding = {low, high};
}

// Refuses the tiles of a larger image, which are no slices.
void refuse_tiles(const gdcm::DataSet& data, const DicomImage& image) {
  if (image.frames == 1 || !data.FindDataElement(Tag(0x0048, 0x0006))) return;
  fail_reading(image.file,
               "its frames are tiles of one larger image (TotalPixelMatrixColumns), as of a slide",
               "Convert it to TIFF, for example with Bio-Formats");
}

// Sets all but the places of the frames.
void complete(DicomHeader& header, DicomImage& image) {
  if (header.is_damaged) fail_damaged(image.file, "its header ends too early or is damaged");
  is_deflated(header) ? find_deflated_pixels(image.file, header) : find_floats(image.file, header);
  const gdcm::DataSet& data = header.data();
  const std::string kind = text_at(data, Tag(0x0008, 0x0008));
  image.is_localizer = kind.find("LOCALIZER") != std::string::npos;
  const std::vector<unsigned> dims = gdcm::ImageHelper::GetDimensionsValue(header.reader.GetFile());
  for (std::size_t axis = 0; axis < std::min<std::size_t>(dims.size(), 2); ++axis) {
    image.size[axis] = dims[axis];
  }
  if (dims.size() > 2) image.frames = dims[2];
  if (image.frames < 1 || image.frames > kMaxDicomFrames) {
    fail_reading(image.file, "it has " + std::to_string(image.frames) + " frames",
                 "Give a file with 1 to " + std::to_string(kMaxDicomFrames));
  }
  image.is_projection =
      image.modality == "NM" && image.frames > 1 && kind.find("RECON") == std::string::npos;
  refuse_tiles(data, image);
  image.segmentation = segmentation_in(data);
  const std::uint64_t bits = set_type(header, image);
  set_values(data, image);
  const std::vector<double> number = numbers_at(data, Tag(0x0020, 0x0013));
  if (!number.empty() && std::abs(number[0]) < 1e15) {
    image.number = static_cast<std::int64_t>(number[0]);
  }
  set_moment(data, image);
  check_pixels(header, bits, image);
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
  const std::unique_ptr<DicomHeader> header = read_dicom_header(path);
  if (header == nullptr) return {};
  const gdcm::DataSet& data = header->data();
  DicomImage image{.file = path,
                   .series = text_at(data, Tag(0x0020, 0x000E)),
                   .study = text_at(data, Tag(0x0020, 0x000D)),
                   .patient = text_at(data, Tag(0x0010, 0x0020)),
                   .description = text_at(data, Tag(0x0008, 0x103E)),
                   .modality = text_at(data, Tag(0x0008, 0x0060))};
  try {
    complete(*header, image);
    return frames_of_dicom(image, header->reader.GetFile());
  } catch (const VolumeFileError& problem) {
    if (image.series.empty()) throw;
    image.refusal = problem.what();
    return {image};
  }
}

std::vector<SourceLabel> dicom_segments(const fs::path& path) {
  const std::unique_ptr<DicomHeader> header = read_dicom_header(path);
  if (header == nullptr) return {};
  std::vector<SourceLabel> labels;
  const DicomSequence segments = sequence_at(header->data(), Tag(0x0062, 0x0002));
  const std::size_t count = segments == nullptr ? 0 : segments->GetNumberOfItems();
  for (std::size_t i = 1; i <= std::min<std::size_t>(count, kMaxSourceMembers); ++i) {
    const gdcm::DataSet& segment = segments->GetItem(i).GetNestedDataSet();
    const auto numbers = binary_at<std::uint16_t>(segment, Tag(0x0062, 0x0004));
    if (numbers.empty() || numbers[0] == 0) continue;
    const double number = numbers[0];
    Label label{.value = number,
                .name = member_name_from(text_at(segment, Tag(0x0062, 0x0005))),
                .color = color_from_lab(binary_at<std::uint16_t>(segment, Tag(0x0062, 0x000D)))};
    if (label.name.empty()) label.name = "segment " + std::to_string(numbers[0]);
    if (!check_member({.series = "segments", .label = label})) continue;
    const bool is_repeated = std::any_of(
        labels.begin(), labels.end(), [&](const SourceLabel& one) { return one.stored == number; });
    if (is_repeated) continue;
    labels.push_back({.label = std::move(label), .stored = number});
  }
  return labels;
}

}  // namespace multitetra
