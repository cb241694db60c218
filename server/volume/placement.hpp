// Places samples in the world if their file does not, or does so incorrectly.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/vec3.hpp"
#include "common/request/physical_meaning.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The directions of a file's x, y and z axes: each is a world axis or its opposite.
using AxisDirections = std::array<Vec3, 3>;

// Parses "x,-z,y": the file's y axis points along -z, its z axis along y. Returns nullopt unless
// each world axis occurs once.
[[nodiscard]] std::optional<AxisDirections> axis_directions_from(std::string_view text);

// Whether these directions make a mirror image of what they are given: left becomes right.
[[nodiscard]] bool is_mirror(const AxisDirections& directions);

// "-x,y,-z or x,-y,-z": the turns nearest to a mirror, with the same direction for z.
[[nodiscard]] std::string nearest_rotations(const AxisDirections& mirror);

// Present values replace those of the file.
struct Placement {
  std::optional<Vec3> spacing = std::nullopt;  // World units between samples; directions are kept.
  std::optional<AxisDirections> orient = std::nullopt;  // Rotates or mirrors all world coordinates.
  std::optional<Vec3> origin = std::nullopt;            // World coordinates of the first sample.
  // The space of the world axes as the reader returns them. RAS coordinates are converted to LPS.
  std::optional<WorldSpace> space = std::nullopt;
  std::optional<std::string> length_unit = std::nullopt;

  friend bool operator==(const Placement&, const Placement&) = default;
};

void place(ImageHeader& header, const Placement& placement);

}  // namespace multitetra
