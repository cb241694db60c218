#include "common/wire/detail/file_positions.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/base/number_text.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {
namespace {

// Returns how far the float moves a coordinate.
double displacement(double coordinate, double origin) {
  const double relative = coordinate - origin;
  return std::abs(double{static_cast<float>(relative)} - relative);
}

double largest_displacement(const PositionedMesh& mesh, const Vec3& origin) {
  double largest = 0;
  for (const Vec3& position : mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      largest = std::max(largest, displacement(position[axis], origin[axis]));
    }
  }
  return largest;
}

// Returns "-500000,-5400000,0": a shift to near the origin, in as few digits as that takes.
std::string shift_text(const PositionedMesh& mesh) {
  const auto [low, high] = position_bounds(mesh.positions);
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double extent = std::max(high[axis] - low[axis], 1e-300);
    const double unit = std::pow(10.0, std::ceil(std::log10(extent)));
    const double shift = -unit * std::round(low[axis] / unit);
    std::array<char, 400> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(),
                                   shift == 0 ? 0.0 : shift, std::chars_format::fixed)
                         .ptr;
    text.append(text.empty() ? "" : ",").append(digits.data(), end);
  }
  return text;
}

}  // namespace

std::pair<Vec3, Vec3> position_bounds(const std::vector<Vec3>& positions) {
  std::pair box(positions.front(), positions.front());
  for (const Vec3& position : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.first[axis] = std::min(box.first[axis], position[axis]);
      box.second[axis] = std::max(box.second[axis], position[axis]);
    }
  }
  return box;
}

std::vector<std::array<float, 3>> float_positions(const PositionedMesh& mesh, const Vec3& origin) {
  std::vector<std::array<float, 3>> floats;
  floats.reserve(mesh.positions.size());
  for (const Vec3& position : mesh.positions) {
    const Vec3 relative = difference(position, origin);
    floats.push_back({static_cast<float>(relative[0]), static_cast<float>(relative[1]),
                      static_cast<float>(relative[2])});
  }
  return floats;
}

bool fits_in_floats(const PositionedMesh& mesh, const Vec3& origin) {
  return std::all_of(mesh.positions.begin(), mesh.positions.end(), [&](const Vec3& position) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (displacement(position[axis], origin[axis]) > mesh.rounding_limits[axis]) return false;
    }
    return true;
  });
}

void require_floats(const PositionedMesh& mesh, const char* format, const Vec3& origin) {
  if (fits_in_floats(mesh, origin)) return;
  refuse_coordinates(mesh, format, largest_displacement(mesh, origin));
}

void refuse_coordinates(const PositionedMesh& mesh, const char* format, double displacement) {
  const Vec3& limits = mesh.rounding_limits;
  throw MeshCoordinatesError(
      std::string(format) + " files have 32-bit coordinates, which would move vertices by " +
          rounded_text(displacement) + "; at most " +
          rounded_text(*std::min_element(limits.begin(), limits.end())) +
          " keeps the surface as it was checked. Write PLY, OBJ or VTP, whose coordinates are "
          "as fine as needed, or coordinates of samples (\"index\").",
      shift_text(mesh));
}

Vec3 origin_for_floats(const PositionedMesh& mesh) {
  if (mesh.positions.empty() || fits_in_floats(mesh)) return {0, 0, 0};
  const auto [low, high] = position_bounds(mesh.positions);
  return moved(low, 0.5, difference(high, low));
}

}  // namespace multitetra
