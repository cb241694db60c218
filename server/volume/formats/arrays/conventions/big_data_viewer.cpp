#include <algorithm>
#include <optional>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"

namespace multitetra {
namespace {

// "/t00000/s00/0/cells": time, setup and level.
struct CellsPath {
  std::int64_t time = 0;
  std::string setup;  // "s00"
  std::int64_t level = 0;
};

std::optional<CellsPath> cells_path(const std::string& array) {
  std::array<std::string, 4> parts;
  std::string_view rest = array;
  for (std::string& part : parts) {
    if (!rest.starts_with('/')) return std::nullopt;
    rest.remove_prefix(1);
    part = rest.substr(0, rest.find('/'));
    rest.remove_prefix(part.size());
  }
  if (!rest.empty() || parts[3] != "cells" || parts[0].empty() || parts[1].empty())
    return std::nullopt;
  const auto time = parse_number<std::int64_t>(parts[0].substr(1));
  const auto setup = parse_number<std::int64_t>(parts[1].substr(1));
  const auto level = parse_number<std::int64_t>(parts[2]);
  if (parts[0][0] != 't' || parts[1][0] != 's' || !time || !setup || !level) return std::nullopt;
  return CellsPath{.time = *time, .setup = parts[1], .level = *level};
}

// Returns the text of the first <name> in an XML text; empty if there is none.
std::string element_text(std::string_view xml, const std::string& name) {
  const std::size_t begin = xml.find("<" + name + ">");
  if (begin == std::string_view::npos) return {};
  xml.remove_prefix(begin + name.size() + 2);
  return std::string(trimmed(xml.substr(0, xml.find('<'))));
}

// Returns the part of the XML beside the file that describes a setup.
std::string setup_text(const ArrayContainer& file, const std::string& setup) {
  constexpr std::size_t kMaxXmlBytes = std::size_t{1} << 26;
  const std::filesystem::path beside =
      file.file().parent_path() / (file.file().stem().string() + ".xml");
  std::error_code error;
  if (!std::filesystem::is_regular_file(beside, error)) return {};
  const std::string xml = InputFile(beside).beginning(kMaxXmlBytes);
  const auto number = parse_number<std::int64_t>(setup.substr(1));
  for (std::size_t at = xml.find("<ViewSetup>"); at != std::string::npos;) {
    const std::size_t end = xml.find("</ViewSetup>", at);
    const std::string text = xml.substr(at, end == std::string::npos ? end : end - at);
    if (parse_number<std::int64_t>(element_text(text, "id")) == number) return text;
    at = xml.find("<ViewSetup>", at + 1);
  }
  return {};
}

}  // namespace

// Level, time and setup (--channel) choose; without a choice, the finest of the first time, if
// there is only one setup.
std::vector<std::string> big_data_viewer_arrays(const ArrayContainer& file,
                                                const VolumeChoice& choice) {
  std::vector<std::string> found;
  for (const std::string& setup : file.children("")) {
    if (file.shape("/" + setup + "/resolutions").empty()) continue;
    for (const std::string& array : file.arrays()) {
      const auto path = cells_path(array);
      if (path && path->setup == setup && path->time == choice.time.value_or(0) &&
          path->level == choice.level.value_or(0)) {
        found.push_back(array);
      }
    }
  }
  return found;
}

bool describe_big_data_viewer(const ArrayContainer& file, const std::string& array,
                              ArrayMeaning& meaning) {
  const std::optional<CellsPath> path = cells_path(array);
  if (!path) return false;
  const std::vector<double> resolutions = file.values("/" + path->setup + "/resolutions");
  if (resolutions.empty()) return false;
  meaning.roles = {DimensionRole::kZ, DimensionRole::kY, DimensionRole::kX};
  // HDF5 files have 16 bits, of type int16 for programs in Java, and are unsigned unless they say
  // otherwise.
  const std::string type = file.text(array, "dataType") + file.text("/" + path->setup, "dataType");
  meaning.is_unsigned = !type.starts_with("int");
  const std::string setup = setup_text(file, path->setup);
  const std::string voxel = setup.substr(std::min(setup.find("<voxelSize>"), setup.size()));
  const std::vector<double> size = finite_numbers(element_text(voxel, "size"));
  const auto level = static_cast<std::size_t>(path->level);
  if (size.size() != 3 || resolutions.size() < 3 * (level + 1)) {
    meaning.is_geometry_unread = true;
    return true;
  }
  StatedNumbers origin = kNotStated;
  StatedNumbers steps = kNotStated;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double factor = resolutions[3 * level + axis];
    steps[axis] = stated_spacing(size[axis] * factor);
    origin[axis] = size[axis] * (factor - 1) / 2;  // Samples are means of those of level 0.
  }
  set_box_axes(meaning.header, origin, steps);
  const std::string unit = element_text(voxel, "unit");
  set_units_of_axes(meaning.header, {unit, unit, unit});
  return true;
}

}  // namespace multitetra
