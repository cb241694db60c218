#include "server/volume/formats/detail/contour_level.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <system_error>
#include <vector>

#include "common/base/json.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/xml_document.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxContourBytes = std::uint64_t{16} << 20;

// Returns "1234" for "emd_1234_half_map_1.map.gz".
std::string entry_number(const std::string& name) {
  const std::string lower = lower_case(name);
  if (!lower.starts_with("emd_") && !lower.starts_with("emd-")) return {};
  const std::size_t end = lower.find_first_not_of("0123456789", 4);
  return lower.substr(4, end == std::string::npos ? end : end - 4);
}

std::optional<double> contour_level_in(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > kMaxContourBytes || error) {
    return std::nullopt;
  }
  const std::string text = InputFile(file).beginning(kMaxContourBytes);
  return file.extension() == ".json" ? contour_level_in_json(text) : contour_level_in_xml(text);
}

}  // namespace

// <contour primary="true"><level>0.05</level>; before version 3 <contourLevel>0.05</contourLevel>.
std::optional<double> contour_level_in_xml(std::string_view text) {
  const Result<XmlElement> xml = parse_xml(text);
  std::optional<double> level;  // The first one, unless a primary one follows.
  if (!xml) return level;
  for (const XmlElement* const old : xml->all("contourLevel")) {
    if (!level) level = finite_number(old->text);
  }
  for (const XmlElement* const contour : xml->all("contour")) {
    const auto number = finite_number(contour->text_of("level"));
    const bool is_primary = contour->attribute("primary") == "true";
    if (number && (!level || is_primary)) level = number;
    if (number && is_primary) break;
  }
  return level;
}

std::optional<double> contour_level_in_json(std::string_view text) {
  using MapJson = nlohmann::json;
  const MapJson json = parse_json(text);
  const MapJson::json_pointer place("/map/contour_list/contour");
  if (!json.is_object() || !json.contains(place) || !json.at(place).is_array()) return std::nullopt;
  std::optional<double> level;
  for (const MapJson& contour : json.at(place)) {
    if (!contour.is_object() || !contour.contains("level")) continue;
    const MapJson& number = contour.at("level");
    if (!number.is_number()) continue;
    const bool is_primary = contour.contains("primary") && contour.at("primary") == true;
    if (!level || is_primary) level = number.get<double>();
    if (is_primary) break;
  }
  return level;
}

std::optional<double> sidecar_contour_level(const fs::path& map) {
  const std::string name = map.filename().string();
  const fs::path folder = map.has_parent_path() ? map.parent_path() : fs::path(".");
  std::vector<std::string> stems = {name.substr(0, name.find('.'))};
  if (const std::string number = entry_number(name); !number.empty()) {
    for (const char* const prefix : {"emd-", "emd_", "EMD-"}) stems.push_back(prefix + number);
  }
  for (const fs::path& place : {folder, folder / ".." / "header"}) {
    for (const std::string& stem : stems) {
      for (const char* const suffix : {".xml", "-v30.xml", ".json"}) {
        if (const auto level = contour_level_in(place / (stem + suffix))) return level;
      }
    }
  }
  return std::nullopt;
}

}  // namespace multitetra
