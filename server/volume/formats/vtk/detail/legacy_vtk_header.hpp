// Parses structured points of legacy VTK files: the grid, and where the samples of each array are.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/vec3.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/vtk/detail/vti_header.hpp"

namespace multitetra {

struct LegacyVtkHeader {
  bool is_text = false;                  // Otherwise binary, big-endian.
  std::array<std::int64_t, 3> points{};  // Along each axis.
  std::optional<Vec3> spacing = std::nullopt;
  std::optional<Vec3> origin = std::nullopt;
  std::vector<VtiArray> arrays;  // `begin` is the offset of the samples in the file.
  std::vector<double> times;     // The time in a field TimeValue or TIME in front of the samples.
  std::string unread;            // The first word of a part that is not understood; may be empty.

  [[nodiscard]] std::array<std::int64_t, 3> cells() const;
};

// Throws VolumeFileError unless the file has structured points and an array.
[[nodiscard]] LegacyVtkHeader parse_legacy_vtk(const InputFile& file);

}  // namespace multitetra
