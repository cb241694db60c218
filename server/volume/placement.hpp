// The placement of samples in the world, where a file lacks it or has it wrong.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/vec3.hpp"
#include "common/request/physical_meaning.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Where the directions x, y and z of a file point: each an axis of the world or its opposite.
using AxisDirections = std::array<Vec3, 3>;

// "x,-z,y": the file's y axis points down, its z axis along y. nullopt unless each axis of the
// world comes once.
[[nodiscard]] std::optional<AxisDirections> axis_directions_from(std::string_view text);

// Given values replace those of the file.
struct Placement {
  std::optional<Vec3> spacing = std::nullopt;  // World units between samples; directions stay.
  std::optional<AxisDirections> orient = std::nullopt;  // Turns, or mirrors, all world coordinates.
  std::optional<Vec3> origin = std::nullopt;  // The world coordinates of the first sample.
  // The space of the world axes as the file's reader gives them. Coordinates that are RAS become
  // LPS.
  std::optional<WorldSpace> space = std::nullopt;
  std::optional<std::string> length_unit = std::nullopt;

  friend bool operator==(const Placement&, const Placement&) = default;
};

void place(ImageHeader& header, const Placement& placement);

}  // namespace multitetra
