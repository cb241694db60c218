// The placement of samples as far as a file states it.
//
//   ImageHeader header{.type = type};
//   set_box_axes(header, kNotStated, {stated_spacing(dx), stated_spacing(dy), std::nullopt});
//
// What a reader does not set is unknown, and stays so until place() (server/volume/placement.hpp)
// assumes it, which the user is told. So no reader can claim what its file does not say.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "common/base/affine.hpp"

namespace multitetra {

struct ImageHeader;

// Numbers along x, y, z as far as they are stated.
using StatedNumbers = std::array<std::optional<double>, 3>;
inline constexpr StatedNumbers kNotStated = {};

[[nodiscard]] inline StatedNumbers stated(const Vec3& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

// Returns a spacing that can be one: finite and greater than 0. Anything else is not stated.
[[nodiscard]] inline std::optional<double> stated_spacing(double spacing) {
  return std::isfinite(spacing) && spacing > 0 ? std::optional(spacing) : std::nullopt;
}

struct StatedGeometry {
  // The steps between samples in world coordinates; of length 1 where the spacing is not stated.
  std::array<Vec3, 3> axes = {Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  StatedNumbers spacing = kNotStated;  // Lengths of the axes, finite and > 0.
  StatedNumbers origin = kNotStated;   // World coordinates of the first sample, finite.
};

enum class Fact { kSpacing, kOrigin, kLengthUnit, kScaling, kSign, kMissingValue, kAxes };

// A fact on which the file contradicts itself, so that one of its statements is used. Dropped if
// the user gives the fact (--spacing, --origin, --length-unit).
struct Contradiction {
  Fact fact;
  std::string text;  // "its header counts from -128 to 127, its samples ...; ... is used"
};

// Sets axes along x, y, z. A negative step is an axis that points backwards; a step of 0, NaN or
// infinity is not stated.
void set_box_axes(ImageHeader& header, const StatedNumbers& origin, const StatedNumbers& steps);

// Converts lengths along x, y and z, each in the unit of its axis, to one unit, and sets it. If
// they have no common unit ("mm" and "degree"), sets none and notes a contradiction. Empty units
// are not stated.
void set_units_of_axes(ImageHeader& header, const std::array<std::string, 3>& units);

// Sets axes from the steps between samples in world coordinates. The spacing and the direction of a
// step without length are not stated.
void set_axes(ImageHeader& header, const std::array<Vec3, 3>& steps, const StatedNumbers& origin);

}  // namespace multitetra
