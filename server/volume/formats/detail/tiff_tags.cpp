#include "server/volume/formats/detail/tiff_tags.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/xml_document.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {
namespace {

// Returns the values of a tag that libtiff does not know; empty if the directory does not have it.
template <typename Number>
std::span<const Number> values_of(TIFF* tiff, std::uint32_t tag) {
  std::uint32_t count = 0;
  const Number* values = nullptr;
  if (TIFFGetField(tiff, tag, &count, &values) != 1 || values == nullptr) return {};
  return {values, count};
}

bool has_type(TIFF* tiff, std::uint32_t tag, TIFFDataType type) {
  const TIFFField* const field = TIFFFindField(tiff, tag, TIFF_ANY);
  return field != nullptr && TIFFFieldDataType(field) == type;
}

std::string text_of_tag(TIFF* tiff, std::uint32_t tag) {
  if (!has_type(tiff, tag, TIFF_ASCII)) return {};
  const std::span<const char> text = values_of<char>(tiff, tag);
  return std::string(text.begin(), std::find(text.begin(), text.end(), '\0'));
}

// MetaMorph: pairs of a kind and a value, which is an offset for fractions and texts; three
// fractions for each image of a stack, of which the first is a distance.
constexpr std::uint32_t kUic1Tag = 33628;
constexpr std::uint32_t kUic2Tag = 33629;

}  // namespace

void add_metamorph(const InputFile& file, TIFF* tiff, TiffPages::Placement& placement) {
  const Endian endian = TIFFIsBigEndian(tiff) != 0 ? Endian::kBig : Endian::kLittle;
  const auto number_at = [&](std::uint64_t at) -> std::uint32_t {
    std::array<std::byte, 4> bytes{};
    if (at + bytes.size() > file.size()) return 0;
    file.read(at, bytes);
    to_host_order(bytes, bytes.size(), endian);
    return std::bit_cast<std::uint32_t>(bytes);
  };
  if (!has_type(tiff, kUic1Tag, TIFF_LONG)) return;
  constexpr std::uint32_t kXCalibration = 4;
  constexpr std::uint32_t kYCalibration = 5;
  constexpr std::uint32_t kCalibrationUnits = 6;
  const std::span<const std::uint32_t> pairs = values_of<std::uint32_t>(tiff, kUic1Tag);
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
    const std::uint32_t kind = pairs[i];
    const std::uint64_t at = pairs[i + 1];
    if (kind == kXCalibration || kind == kYCalibration) {
      placement.spacing[kind - kXCalibration] = stated_spacing(
          static_cast<double>(number_at(at)) / static_cast<double>(number_at(at + 4)));
    } else if (kind == kCalibrationUnits) {
      constexpr std::uint32_t kMaxUnit = 64;
      std::array<std::byte, kMaxUnit> text{};
      const std::uint32_t length = std::min(number_at(at), kMaxUnit);
      if (at + 4 + length > file.size()) continue;
      file.read(at + 4, std::span(text).first(length));
      const std::string unit(reinterpret_cast<const char*>(text.data()), length);
      placement.units[0] = placement.units[1] = unit.substr(0, unit.find('\0'));
    }
  }
  const std::string& unit = placement.units[0];
  if (unit.empty() || unit.starts_with("pixel")) placement = {};  // It is not calibrated.
  if (!has_type(tiff, kUic2Tag, TIFF_RATIONAL)) return;
  // Programs write the distance from the image before, or from the first.
  const std::span<const float> numbers = values_of<float>(tiff, kUic2Tag);
  if (numbers.empty()) return;
  const double first = static_cast<double>(numbers[0]);
  const double second = numbers.size() > 3 ? static_cast<double>(numbers[3]) : first;
  placement.spacing[2] = stated_spacing(first == second ? first : std::abs(second - first));
  if (placement.spacing[2]) placement.units[2] = "µm";
}

void add_geotiff(TIFF* tiff, TiffPages::Placement& placement) {
  constexpr std::uint32_t kPixelScaleTag = 33550;
  constexpr std::uint32_t kNoDataTag = 42113;
  if (has_type(tiff, kPixelScaleTag, TIFF_DOUBLE)) {
    const std::span<const double> scale = values_of<double>(tiff, kPixelScaleTag);
    for (std::size_t axis = 0; axis < std::min<std::size_t>(scale.size(), 3); ++axis) {
      placement.spacing[axis] = stated_spacing(scale[axis]);
    }
  }
  constexpr std::uint32_t kTiePointTag = 33922;
  constexpr std::uint32_t kTransformationTag = 34264;
  placement.is_on_map =
      has_type(tiff, kTiePointTag, TIFF_DOUBLE) || has_type(tiff, kTransformationTag, TIFF_DOUBLE);
  placement.missing = finite_number(trimmed(text_of_tag(tiff, kNoDataTag)));
}

std::string unread_convention(TIFF* tiff) {
  constexpr std::pair<std::uint32_t, const char*> kTags[] = {
      {33560, "Olympus SIS"}, {34118, "Zeiss SEM"}, {34361, "FluoView"},     {34412, "Zeiss LSM"},
      {34682, "FEI SEM"},     {43314, "NIH Image"}, {51123, "Micro-Manager"}};
  for (const auto& [tag, program] : kTags) {
    std::uint32_t count = 0;
    void* values = nullptr;
    const bool is_known = TIFFFindField(tiff, tag, TIFF_ANY) != nullptr;
    if (is_known && TIFFGetField(tiff, tag, &count, &values) == 1) return program;
  }
  return {};
}

TiffPages::Scaling gdal_scaling(TIFF* tiff) {
  constexpr std::uint32_t kMetadataTag = 42112;
  TiffPages::Scaling scaling;
  const std::string text = text_of_tag(tiff, kMetadataTag);
  const Result<XmlElement> xml = text.empty() ? Result<XmlElement>() : parse_xml(text);
  if (!xml) return scaling;
  std::map<std::string, std::pair<double, double>> bands;  // Scale and offset.
  for (const XmlElement* const item : xml->all("Item")) {
    const std::string role = item->attribute("role");
    const auto number = finite_number(item->text);
    if ((role != "scale" && role != "offset") || !number) continue;
    auto& [scale, offset] = bands.try_emplace(item->attribute("sample"), 1.0, 0.0).first->second;
    if (role == "offset") offset = *number;
    if (role == "scale" && *number != 0) scale = *number;
  }
  if (bands.empty()) return scaling;
  // A band without numbers has those that change nothing.
  if (bands.size() < tiff_field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1)) {
    bands.try_emplace("", 1.0, 0.0);
  }
  const auto first = bands.begin()->second;
  if (std::ranges::any_of(bands, [&](const auto& band) { return band.second != first; })) {
    return {.differs = true};
  }
  return {.slope = first.first, .intercept = first.second};
}

std::int64_t images_in_directory(TIFF* tiff) {
  std::uint32_t count = 0;
  void* values = nullptr;
  if (TIFFGetField(tiff, kUic2Tag, &count, &values) == 1 && count > 1) return count;
  return std::max<std::int64_t>(tiff_field<std::uint32_t>(tiff, TIFFTAG_IMAGEDEPTH, 1), 1);
}

}  // namespace multitetra
