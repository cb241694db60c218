// The choice of one of the arrays of a VTK file, and what is told about the others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/volume/formats/vtk/detail/vti_header.hpp"

namespace multitetra {

// The names of the active arrays; empty if the file has none.
struct ActiveArrays {
  std::string of_points;
  std::string of_cells;
};

// Returns the array `wanted`, a name or "PointData/NAME" or "CellData/NAME". If that is empty,
// returns the active or else the first array of the points, or else of the cells. Throws
// VolumeFileError if there is none.
[[nodiscard]] const VtiArray& chosen_array(const std::filesystem::path& file,
                                           const std::vector<VtiArray>& arrays,
                                           const ActiveArrays& active, const std::string& wanted);

// Describes the arrays with as many samples as the chosen one.
[[nodiscard]] VolumeContents contents_beside(const std::vector<VtiArray>& arrays,
                                             const VtiArray& chosen);

// Returns the notice of a choice that nobody made; none if there is nothing to choose.
[[nodiscard]] std::vector<std::string> choice_notices(const std::filesystem::path& file,
                                                      const std::vector<VtiArray>& arrays,
                                                      const VtiArray& chosen,
                                                      const std::string& wanted);

}  // namespace multitetra
