#include "server/volume/placement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace multitetra {
namespace {

void set_spacing(ImageHeader& header, const Vec3& spacing) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3& column = header.index_to_world.columns[axis];
    const double before = std::sqrt(dot(column, column));
    if (before > 0) {
      column = scaled(column, spacing[axis] / before);
    } else {  // The header has no usable spacing.
      column = {0, 0, 0};
      column[axis] = spacing[axis];
    }
  }
  header.spacing = spacing;
}

void turn(Affine& index_to_world, const AxisDirections& directions) {
  const Affine turned = composed({.columns = directions, .translation = {0, 0, 0}}, index_to_world);
  index_to_world = turned;
  for (Vec3& column : index_to_world.columns) column = sum(column, {0, 0, 0});  // Turns -0 into 0.
  index_to_world.translation = sum(index_to_world.translation, {0, 0, 0});
}

// RAS and LPS differ in the signs of their first two axes.
void turn_to_lps(Affine& index_to_world) {
  const auto turn = [](Vec3& v) { v = {0.0 - v[0], 0.0 - v[1], v[2]}; };
  for (Vec3& column : index_to_world.columns) turn(column);
  turn(index_to_world.translation);
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
  if (placement.spacing) set_spacing(header, *placement.spacing);
  if (placement.orient) turn(header.index_to_world, *placement.orient);
  if (placement.origin) header.index_to_world.translation = *placement.origin;
  if (placement.space) {
    const bool is_turned = *placement.space == WorldSpace::kRas;
    if (is_turned) turn_to_lps(header.index_to_world);
    header.meaning.space = is_turned ? WorldSpace::kLps : *placement.space;
  }
  if (placement.length_unit) header.meaning.length_unit = *placement.length_unit;
}

}  // namespace multitetra
