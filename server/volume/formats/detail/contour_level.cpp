#include "server/volume/formats/detail/contour_level.hpp"

#include <expat.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "common/base/json.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxContourBytes = std::uint64_t{16} << 20;

// <contour primary="true"><level>0.05</level>; before version 3 <contourLevel>0.05</contourLevel>.
struct ContourHandler {
  // The open contour is the primary one.
  bool is_primary = false;
  bool is_open = false;
  std::string text;
  std::optional<double> level;  // The first one, unless a primary one follows.
  bool has_primary = false;

  static void XMLCALL on_start(void* self, const XML_Char* name, const XML_Char** attributes) {
    auto& handler = *static_cast<ContourHandler*>(self);
    const std::string_view element = name;
    if (element == "contour") {
      handler.is_primary = false;
      for (const XML_Char** at = attributes; *at != nullptr; at += 2) {
        handler.is_primary |=
            std::string_view(at[0]) == "primary" && std::string_view(at[1]) == "true";
      }
    }
    handler.is_open = element == "level" || element == "contourLevel";
    handler.text.clear();
  }
  static void XMLCALL on_text(void* self, const XML_Char* text, int length) {
    auto& handler = *static_cast<ContourHandler*>(self);
    if (handler.is_open) handler.text.append(text, static_cast<std::size_t>(length));
  }
  static void XMLCALL on_end(void* self, const XML_Char*) {
    auto& handler = *static_cast<ContourHandler*>(self);
    if (!handler.is_open) return;
    handler.is_open = false;
    const auto number = finite_number(trimmed(handler.text));
    const bool is_better = !handler.level || (handler.is_primary && !handler.has_primary);
    if (!number || !is_better) return;
    handler.level = number;
    handler.has_primary = handler.is_primary;
  }
};

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

std::optional<double> contour_level_in_xml(std::string_view text) {
  const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(
      XML_ParserCreate(nullptr), &XML_ParserFree);
  ContourHandler handler;
  XML_SetUserData(parser.get(), &handler);
  XML_SetElementHandler(parser.get(), &ContourHandler::on_start, &ContourHandler::on_end);
  XML_SetCharacterDataHandler(parser.get(), &ContourHandler::on_text);
  const auto status = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
  return status == XML_STATUS_OK ? handler.level : std::nullopt;
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
