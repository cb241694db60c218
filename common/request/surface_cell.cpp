#include "common/request/surface_cell.hpp"

#include <algorithm>
#include <bit>
#include <string>

namespace multitetra {

Result<void> check_cell(const OctreeNode& cell) {
  const OctreeCube& cube = cell.cube;
  if (cube.exponent < 1 || cube.exponent > kMaxLatticeBits) {
    return fail(ErrorCode::kInvalidArgument,
                "The cell's exponent is " + std::to_string(cube.exponent) +
                    "; it must be from 1 to " + std::to_string(kMaxLatticeBits) + ".");
  }
  if (std::min({cube.x, cube.y, cube.z}) < 0) {
    return fail(ErrorCode::kInvalidArgument,
                "The cell is " + to_string(cube) + "; x, y and z must be 0 or greater.");
  }
  const std::int32_t finest = cell.finest_spacing;
  if (finest < 1 || !std::has_single_bit(static_cast<std::uint32_t>(finest)) ||
      finest > cube.side() / 2) {
    return fail(ErrorCode::kInvalidArgument,
                "The finest spacing of the cell is " + std::to_string(finest) +
                    "; it must be a power of two from 1 to half the cell's side, " +
                    std::to_string(cube.side() / 2) + ".");
  }
  return {};
}

Result<void> check_cell(const OctreeNode& cell, const DatasetInfo& info) {
  const OctreeCube& cube = cell.cube;
  const std::int32_t least = std::min(kMinCellExponent, info.grid_exponent);
  if (cube.exponent < least || cube.exponent > info.grid_exponent) {
    return fail(ErrorCode::kInvalidArgument,
                "The cell's exponent is " + std::to_string(cube.exponent) + "; in dataset \"" +
                    info.name + "\" it must be from " + std::to_string(least) + " to " +
                    std::to_string(info.grid_exponent) + ".");
  }
  const std::int32_t along = std::int32_t{1} << (info.grid_exponent - cube.exponent);
  if (std::max({cube.x, cube.y, cube.z}) >= along) {
    return fail(ErrorCode::kInvalidArgument, "The cell is " + to_string(cube) + "; in dataset \"" +
                                                 info.name + "\" x, y and z must be less than " +
                                                 std::to_string(along) + " there.");
  }
  return {};
}

}  // namespace multitetra
