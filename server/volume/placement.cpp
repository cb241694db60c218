#include "server/volume/placement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "common/base/address_text.hpp"
#include "common/base/number_text.hpp"

namespace multitetra {
namespace {

void set_spacing(StatedGeometry& geometry, const Vec3& spacing) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3& step = geometry.axes[axis];
    step = scaled(step, spacing[axis] / length(step));
  }
  geometry.spacing = stated(spacing);
}

// Turns each axis and the origin; each direction is a world axis or its opposite.
void turn(StatedGeometry& geometry, const AxisDirections& directions) {
  const Affine map = {.columns = directions, .translation = {0, 0, 0}};
  for (Vec3& axis : geometry.axes) axis = sum(map(axis), {0, 0, 0});  // Turns -0 into 0.
  const StatedNumbers origin = std::exchange(geometry.origin, kNotStated);
  for (std::size_t from = 0; from < 3; ++from) {
    for (std::size_t to = 0; to < 3; ++to) {
      const double sign = directions[from][to];
      if (sign != 0 && origin[from]) geometry.origin[to] = sign * *origin[from] + 0.0;
    }
  }
}

// RAS and LPS differ in the signs of their first two axes.
constexpr Vec3 kRasToLps = {-1, -1, 1};

AxisDirections axes_with_signs(const Vec3& signs) {
  return {Vec3{signs[0], 0, 0}, {0, signs[1], 0}, {0, 0, signs[2]}};
}

// Returns the axes with more than one sample along which `numbers` are not stated: "x and z".
std::string axes_without(const StatedNumbers& numbers, const ImageHeader& header) {
  std::string axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!numbers[axis] && header.dims[axis] > 1) axes += "xyz"[axis];
  }
  if (axes.size() == 3) return "x, y and z";
  if (axes.size() == 2) axes.insert(1, " and ");
  return axes;
}

// "-y"
std::string direction_text(const Vec3& direction) {
  std::size_t axis = 0;
  while (direction[axis] == 0) ++axis;
  return std::string(direction[axis] < 0 ? "-" : "") + "xyz"[axis];
}

}  // namespace

std::optional<AxisDirections> axis_directions_from(std::string_view text) {
  AxisDirections directions = {};
  std::array<bool, 3> is_named = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t end = std::min(text.find(','), text.size());
    std::string_view word = text.substr(0, end);
    if ((i < 2) == (end == text.size())) return std::nullopt;
    text.remove_prefix(std::min(end + 1, text.size()));
    const double sign = word.starts_with('-') ? -1 : 1;
    if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
    const std::size_t axis = std::string_view("xyz").find(word);
    if (word.size() != 1 || axis == std::string_view::npos || is_named[axis]) return std::nullopt;
    is_named[axis] = true;
    directions[i][axis] = sign;
  }
  return directions;
}

bool is_mirror(const AxisDirections& directions) {
  return Affine{.columns = directions, .translation = {0, 0, 0}}.determinant() < 0;
}

std::string nearest_rotations(const AxisDirections& mirror) {
  constexpr AxisDirections kUnturned = {Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::string turns;
  for (std::size_t opposite = 0; opposite < 2; ++opposite) {
    AxisDirections turn = mirror;
    turn[opposite] = scaled(turn[opposite], -1);
    if (turn == kUnturned) continue;
    turns += turns.empty() ? "" : " or ";
    for (std::size_t i = 0; i < 3; ++i) turns += (i == 0 ? "" : ",") + direction_text(turn[i]);
  }
  return turns;
}

void place(ImageHeader& header, const Placement& placement) {
  StatedGeometry& geometry = header.geometry;
  if (placement.space) turn(geometry, axes_with_signs(header.turned_by));  // Back to the file's.
  if (placement.spacing) set_spacing(geometry, *placement.spacing);
  if (placement.orient) turn(geometry, *placement.orient);
  if (placement.origin) geometry.origin = stated(*placement.origin);
  if (placement.space) {
    const bool is_turned = *placement.space == WorldSpace::kRas;
    if (is_turned) turn(geometry, axes_with_signs(kRasToLps));
    header.meaning.space = is_turned ? WorldSpace::kLps : *placement.space;
  }
  if (placement.length_unit) header.meaning.length_unit = *placement.length_unit;
  std::erase_if(header.contradictions, [&](const Contradiction& about) {
    return (about.fact == Fact::kSpacing && placement.spacing) ||
           (about.fact == Fact::kOrigin && placement.origin) ||
           (about.fact == Fact::kLengthUnit && placement.length_unit);
  });
}

namespace {

// "times 0.5 plus 10 (stated), unsigned (by format), 50 is missing (stated)"
std::string values_text(const ImageHeader& header) {
  const auto with = [](const std::string& text, Basis basis) {
    return text + " (" + std::string(name(basis)) + ")";
  };
  const bool is_scaled = header.slope != 1 || header.intercept != 0;
  std::string text = with(is_scaled ? "times " + shortest_text(header.slope) + " plus " +
                                          shortest_text(header.intercept)
                                    : "as stored",
                          header.values.scaling);
  const char kind = name(header.type)[0];
  if (kind != 'f') text += ", " + with(kind == 'u' ? "unsigned" : "signed", header.values.sign);
  std::string missing;
  constexpr std::size_t kListed = 8;
  for (const double number :
       std::span(header.missing).first(std::min(kListed, header.missing.size()))) {
    missing += (missing.empty() ? "" : ", ") + shortest_text(number);
  }
  if (header.valid_range) {
    missing += (missing.empty() ? "" : ", ") +
               ("outside of " + shortest_text((*header.valid_range)[0])) + " to " +
               shortest_text((*header.valid_range)[1]);
  }
  return text + ", " +
         with(missing.empty() ? "none missing" : "missing: " + missing, header.values.missing);
}

}  // namespace

VolumeHeader settled(const ImageHeader& header) {
  const StatedGeometry& geometry = header.geometry;
  VolumeHeader settled{.meaning = header.meaning, .values = values_text(header)};
  bool has_spacing = false;
  bool has_origin = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    settled.dims[axis] = static_cast<std::int32_t>(header.dims[axis]);
    settled.spacing[axis] = geometry.spacing[axis].value_or(1);
    settled.index_to_world.columns[axis] = geometry.axes[axis];
    settled.index_to_world.translation[axis] = geometry.origin[axis].value_or(0);
    has_spacing = has_spacing || geometry.spacing[axis];
    has_origin = has_origin && (geometry.origin[axis] || header.dims[axis] == 1);
  }
  const std::string axes = axes_without(geometry.spacing, header);
  PhysicalMeaning& meaning = settled.meaning;
  if (!axes.empty()) meaning.assumed = "spacing along " + axes;
  if (!has_origin) meaning.assumed += meaning.assumed.empty() ? "origin" : ", origin";
  meaning.geometry = meaning.assumed.empty()     ? GeometryBasis::kStated
                     : has_spacing || has_origin ? GeometryBasis::kPartly
                                                 : GeometryBasis::kAssumed;
  return settled;
}

std::vector<std::string> fact_notices(const std::filesystem::path& file,
                                      const ImageHeader& header) {
  const std::string source = "'" + without_password(file.string()) + "': ";
  std::vector<std::string> notices;
  if (const std::string axes = axes_without(header.geometry.spacing, header); !axes.empty()) {
    notices.push_back(
        source + "the file states no spacing along " + axes + "; " +
        (header.meaning.length_unit.empty() ? "1" : "1 " + header.meaning.length_unit) +
        " is assumed. Give it with --spacing.");
  }
  if (header.values.scaling == Basis::kAssumed && !header.meaning.value_unit.empty()) {
    notices.push_back(source + "the file states no scaling; its numbers are read as " +
                      header.meaning.value_unit + ".");
  }
  if (header.values.sign == Basis::kAssumed) {
    const bool is_unsigned = name(header.type).starts_with('u');
    notices.push_back(source +
                      "the file does not state whether its integers have a sign; they are " +
                      (is_unsigned ? "read as unsigned." : "read as signed."));
  }
  for (const Contradiction& about : header.contradictions) {
    notices.push_back(source + about.text + ".");
  }
  return notices;
}

}  // namespace multitetra
