#include "server/volume/formats/vtk/detail/array_choice.hpp"

#include <algorithm>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string names_of(const std::vector<VtiArray>& arrays) {
  constexpr std::size_t kMostNamed = 20;
  const bool has_both = std::any_of(arrays.begin(), arrays.end(), [&](const VtiArray& array) {
    return array.of_cells != arrays.front().of_cells;
  });
  std::string names;
  for (std::size_t i = 0; i < arrays.size() && i < kMostNamed; ++i) {
    names += (i == 0 ? "" : ", ") + (has_both ? arrays[i].section + "/" : "") + arrays[i].name;
  }
  return names + (arrays.size() > kMostNamed ? ", ..." : "");
}

// VTK's marks of points and cells that are copies, hidden or invalid.
bool is_mask(const VtiArray& array) {
  return array.name == "vtkGhostType" || array.name == "vtkGhostLevels" ||
         array.name == "vtkValidPointMask";
}

}  // namespace

const VtiArray& chosen_array(const fs::path& file, const std::vector<VtiArray>& arrays,
                             const ActiveArrays& active, const std::string& wanted) {
  if (arrays.empty()) {
    fail_reading(file, "it has no arrays of numbers", "Save it with point data");
  }
  const auto find = [&](const std::string& name, bool of_cells) {
    return std::find_if(arrays.begin(), arrays.end(), [&](const VtiArray& array) {
      return array.of_cells == of_cells &&
             (name.empty() ? !is_mask(array)
                           : array.name == name || array.section + "/" + array.name == name);
    });
  };
  for (const bool of_cells : {false, true}) {
    auto found = find(!wanted.empty() ? wanted
                      : of_cells      ? active.of_cells
                                      : active.of_points,
                      of_cells);
    if (found == arrays.end() && wanted.empty()) found = find("", of_cells);
    if (found != arrays.end()) return *found;
  }
  if (wanted.empty()) return arrays.front();
  fail_reading(file, "it has no array '" + wanted + "'", "Its arrays are " + names_of(arrays));
}

VolumeContents contents_beside(const std::vector<VtiArray>& arrays, const VtiArray& chosen) {
  VolumeContents contents;
  for (const VtiArray& array : arrays) {
    if (array.of_cells != chosen.of_cells || contents.fields.size() == kMaxSourceMembers) continue;
    const std::string name = member_name_from(array.name);
    if (name.empty()) {
      contents.unnamed.push_back(array.name);
    } else {
      contents.fields.push_back(
          {.name = name, .array = array.name, .components = array.components});
    }
  }
  return contents;
}

std::vector<std::string> choice_notices(const fs::path& file, const std::vector<VtiArray>& arrays,
                                        const VtiArray& chosen, const std::string& wanted) {
  if (arrays.size() < 2 || !wanted.empty()) return {};
  return {choice_notice(file, arrays.size(), "arrays", "'" + chosen.name + "'",
                        "--array (" + names_of(arrays) + "), or prepare each with --field")};
}

}  // namespace multitetra
